//! Homogeneous boxes of any size, written as URDF into a temporary folder.

use std::fs;
use tempfile::TempDir;

/// Standard gravity of a scenario, m/s^2.
pub const G: f64 = 9.81;

/// A box with its frame at its centre and a sole on its bottom face.
pub struct Body {
    folder: TempDir,
    /// Half lengths along x, y, z, m.
    pub half: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
}

impl Body {
    /// A homogeneous box.
    pub fn new(half: [f64; 3], mass: f64) -> Self {
        let body = Body { folder: TempDir::new().expect("a folder for the robot"), half, mass };
        let [xx, yy, zz] = body.inertia();
        let urdf = format!(
            r#"<robot name="body"><link name="block"><inertial><mass value="{mass}"/>
            <inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial></link></robot>"#
        );
        fs::write(body.folder.path().join("body.urdf"), urdf).expect("the folder is writable");
        body
    }

    /// The sizes of the test cases: the block of the repository, a heavy flat slab, a small die, an
    /// oblong brick.
    pub fn several() -> [Body; 4] {
        [([0.1, 0.1, 0.05], 1.0), ([0.4, 0.4, 0.02], 30.0), ([0.01, 0.01, 0.01], 0.008), ([0.12, 0.06, 0.03], 2.5)]
            .map(|(half, mass)| Body::new(half, mass))
    }

    /// Principal moments of inertia about the centre, `m (b^2 + c^2) / 3` with half lengths.
    pub fn inertia(&self) -> [f64; 3] {
        let [a, b, c] = self.half.map(|x| x * x * self.mass / 3.0);
        [b + c, a + c, a + b]
    }

    /// Horizontal distance of a corner from the centre, m.
    pub fn radius(&self) -> f64 {
        self.half[0].hypot(self.half[1])
    }

    /// Corners of the sole in order, x and y.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let [a, b, _] = self.half;
        [[-a, -b], [a, -b], [a, b], [-a, b]]
    }

    /// The `robot` line of a scenario; `base` is the inside of its `base` table.
    pub fn robot(&self, base: &str) -> String {
        let polygon = self.corners().map(|[x, y]| [x, y, -self.half[2]]);
        format!(
            "robot = {{ model = {:?}, base = {{ {base} }}, soles = [{{ name = \"bottom\", link = \"block\", polygon = {polygon:?} }}] }}\n",
            self.folder.path().join("body.urdf")
        )
    }

    /// As [`robot`](Self::robot) on one point below, at x and y from the centre.
    pub fn on_point(&self, [x, y]: [f64; 2]) -> String {
        format!(
            "robot = {{ model = {:?}, soles = [{{ name = \"tip\", link = \"block\", polygon = [[{x}, {y}, {}]] }}] }}\n",
            self.folder.path().join("body.urdf"),
            -self.half[2]
        )
    }

    /// As [`robot`](Self::robot) without a sole.
    pub fn floating(&self, base: &str) -> String {
        format!("robot = {{ model = {:?}, base = {{ {base} }}, soles = [] }}\n", self.folder.path().join("body.urdf"))
    }
}
