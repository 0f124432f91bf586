//! A contact method written outside the crate: a frictionless floor of springs and dampers under every vertex.
//!
//!     cargo run --release --example own_contact_method

use std::error::Error;
use stiction::contact_methods::{
    ContactMethod, ContactSolver, Level, Problem, Scheme, Selection, SelectionInput, SoleState, Solution, States,
};
use stiction::nalgebra::Vector3;
use stiction::{Scenario, Simulation};

/// `N = max(0, -k height - c v_n)` for every vertex below the floor.
#[derive(Clone, Copy, Debug)]
struct Springs {
    stiffness: f64,
    damping: f64,
}

impl ContactMethod for Springs {
    fn name(&self) -> &str {
        "springs"
    }

    fn solver(&self, _: &Problem) -> Box<dyn ContactSolver> {
        Box::new(*self)
    }
}

impl ContactSolver for Springs {
    fn scheme(&self) -> Scheme {
        Scheme::Compliant
    }

    /// Forces follow from heights and velocities, so there are no states to choose among.
    fn select(&mut self, p: &mut Problem, _: &SelectionInput, out: &mut Solution) -> Selection {
        self.respond(p, &States::default(), out);
        Selection::unchecked(States::default())
    }

    /// Only called by velocity-level integrators; see [`main`].
    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        assert_eq!(p.level, Level::Acceleration, "this method runs with Runge-Kutta integrators only");
        self.select(p, input, out)
    }

    fn respond(&mut self, p: &Problem, _: &States, out: &mut Solution) {
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, vertex) in sole.vertices.iter().enumerate() {
                let is_below = vertex.height < 0.0;
                let force = -self.stiffness * vertex.height - self.damping * vertex.velocity.z;
                out.set_vertex_force(
                    s,
                    i,
                    if is_below { Vector3::new(0.0, 0.0, force.max(0.0)) } else { Vector3::zeros() },
                );
            }
        }
        out.gather_vertex_forces(p);
    }
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let text = r#"
        duration = 3.0
        robot = { model = "robots/block/block.toml" }
        integrator = { method = "rk4", step = 1e-4 }
    "#;
    let mut setup = Scenario::parse("springs.toml", text)?.runs()?[0].setup()?;
    let springs = Springs { stiffness: 1e4, damping: 100.0 };
    setup.contact.method = Box::new(springs);
    let mut simulation = Simulation::new(setup)?;
    simulation.run_to_end(&mut ())?;
    // At rest four springs carry the weight of 1 kg.
    let (depth, expected) = (0.05 - simulation.state().position.z, 9.81 / (4.0 * springs.stiffness));
    println!("the block stands {depth:.9} m deep, closed form {expected:.9} m");
    assert!((depth - expected).abs() < 1e-9);
    assert_eq!(simulation.contact_states().next(), Some(SoleState::FREE));
    Ok(())
}
