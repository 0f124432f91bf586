//! Terrain of a scenario: entries and their files as convex pieces, and files that are refused.

use std::path::Path;

use stiction::nalgebra::{Matrix3, Vector3};
use stiction::scenario::{Diagnostic, Run, parse};
use stiction::terrain::{PieceRef, Terrain, TerrainPiece};
use stiction::{assemble, geometry::Plane};

use super::{FULL, runs};

/// The only run of a scenario in a folder with these files.
fn run(text: &str, files: &[(&str, &[u8])]) -> (tempfile::TempDir, Run) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let block = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/block/block.urdf");
    let text = format!("robot = {{ model = {block:?} }}\n{text}");
    let file = parse(&folder.path().join("s.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let run = file.expand(&[]).unwrap_or_else(|e| panic!("{e}")).remove(0);
    (folder, run)
}

fn terrain(run: &Run) -> (Terrain, Vec<Diagnostic>) {
    let mut errors = Vec::new();
    let terrain = assemble::terrain::terrain(run, None, &mut Vec::new(), &mut errors);
    (terrain, errors)
}

#[track_caller]
fn refused(text: &str, files: &[(&str, &[u8])], position: Option<(&str, usize, usize)>, message: &str) {
    let (_folder, run) = run(text, files);
    let errors = terrain(&run).1;
    assert_eq!(errors.len(), 1, "{text}: {errors:?}");
    assert!(errors[0].message.contains(message), "{}", errors[0].message);
    if let Some((file, line, column)) = position {
        let found = errors[0].position.unwrap();
        assert!(errors[0].file.ends_with(file), "{}", errors[0].file);
        assert_eq!((found.line, found.column), (line, column), "{}", errors[0]);
    }
}

#[test]
fn entries_have_names_poses_and_friction() {
    let text = "[floor]\nfriction = { static = 0.7, kinetic = 0.5 }\n\
                [[terrain]]\ntype = \"box\"\nposition = [1, 2, 3]\nrpy = [0, 0, \"90 deg\"]\nsize = [2, 1, 0.5]\n\
                [[terrain]]\ntype = \"stairs\"\nname = \"up\"\nfriction = 0.2\n\
                steps = 3\nrise = 0.1\nrun = 0.3\nwidth = 1\n";
    let (_folder, run) = run(text, &[]);
    let (terrain, errors) = terrain(&run);
    assert!(errors.is_empty());
    let pieces = terrain.pieces();
    let names: Vec<_> = pieces.iter().map(|p| (&*p.name, p.entry, p.mu_s, p.mu_k)).collect();
    let step = ("up", 1, 0.2, 0.2);
    assert_eq!(names, [("terrain.0", 0, 0.7, 0.5), step, step, step]);
    // Turned by 90 degrees, the length 2 is along y.
    for p in &pieces[0].points {
        let from_centre = (p - Vector3::new(1.0, 2.0, 3.0)).abs();
        assert!((from_centre - Vector3::new(0.5, 1.0, 0.25)).norm() < 1e-12, "{p}");
    }
    // A resolved scenario is the same.
    let again = parse(&run.file, run.resolved_toml.clone()).unwrap().expand(&[]).unwrap().remove(0);
    assert_eq!(again.scenario, run.scenario);
}

#[test]
fn all_types_of_the_full_scenario_become_pieces() {
    let run = &runs(FULL)[0];
    let (terrain, errors) = terrain(run);
    assert!(errors.is_empty(), "{errors:?}");
    let count = |name: &str| terrain.pieces().iter().filter(|p| &*p.name == name).count();
    let counts = ["plank", "slope", "stairs", "stone", "terrain.6"].map(count);
    assert_eq!(counts, [1, 1, 5, 6, 1]);
    // Two triangles of the pyramid's base are one face of its hull.
    let hull = terrain.pieces().iter().find(|p| &*p.name == "terrain.6").unwrap();
    assert_eq!((hull.points.len(), hull.faces.len()), (5, 5));
    let inputs: Vec<_> = run.inputs.iter().map(|input| input.key.as_str()).filter(|k| k.contains("terrain")).collect();
    assert_eq!(inputs, ["terrain.3.file", "terrain.4.file", "terrain.5.file", "terrain.6.file"]);
    // The picture has the heights of the table, and 0.1 m are not its distances.
    let [table, picture, given] = terrain.grids() else { panic!("three height fields") };
    for (a, b) in table.heights().values.iter().zip(&picture.heights().values) {
        assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    }
    assert_eq!(given.heights().values, [0.0, 0.02, 0.01, 0.0]);
    assert_eq!(table.spacing(), [0.5, 1.0 / 3.0]);
    assert_eq!(picture.spacing(), [0.1, 0.1]);
    // Row 2, column 2 of the table has 5 cm, less 2 cm.
    let top = table.point(2, 2);
    assert!((top - Vector3::new(0.0, 1.0 / 6.0, 0.03)).norm() < 1e-12, "{top}");
    assert!((table.height(top.x, top.y).unwrap() - 0.03).abs() < 1e-12);
    assert!((table.entry().to_world(&top) - Vector3::new(0.0, 3.0 + 1.0 / 6.0, 0.03)).norm() < 1e-12);
}

#[test]
fn pieces_of_a_tilted_field_are_found_below_a_point_of_its_surface() {
    let text = "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.csv\"\nspacing = 0.5\n\
                position = [1, 2, 3]\nrpy = [0.1, -0.2, 0.5]\n";
    let (_folder, run) = run(text, &[("h.csv", b"0,0.1,0\n0.2,0.3,0\n0,0,0.1\n")]);
    let (terrain, errors) = terrain(&run);
    assert!(errors.is_empty());
    let grid = &terrain.grids()[0];
    let mut buffer = TerrainPiece::prism_buffer();
    for k in 0..100 {
        let (x, y) = (0.0097 * f64::from(k) - 0.48, 0.0071 * f64::from(k * 13 % 100) - 0.35);
        let surface = grid.height(x, y).unwrap();
        let at = |z: f64| grid.entry().to_world(&Vector3::new(x, y, z));
        let mut containing = |p: Vector3<f64>| {
            let mut pieces = Vec::new();
            terrain.near(&p, &p, |piece| pieces.push(piece));
            pieces.retain(|piece| terrain.piece(*piece, &mut buffer).contains(&p));
            pieces
        };
        assert!(containing(at(surface + 1e-9)).is_empty());
        assert!(matches!(containing(at(surface - 1e-9))[..], [PieceRef::Prism { grid: 0, .. }]));
    }
}

#[test]
fn heights_may_be_written_in_place_of_a_file() {
    let text = |heights: &str| {
        format!("[[terrain]]\ntype = \"heightfield\"\n{heights}\nspacing = 0.5\nscale = 2\noffset = 0.1\n")
    };
    let table = "heights = [[0, 0.1, 0], [0.2, 0.3, 0.4]]";
    let (_folder, written) = run(&text(table), &[]);
    let (_other, of_file) = run(&text("file = \"h.csv\""), &[("h.csv", b"0,0.1,0\n0.2,0.3,0.4\n")]);
    let [written, of_file] = [written, of_file].map(|run| terrain(&run).0);
    assert_eq!(written.grids(), of_file.grids());
    refused(&text("heights = [[0, 1], [0]]"), &[], Some(("s.toml", 4, 11)), "row 2 has 1 heights, the first one has 2");
}

#[test]
fn the_floor_hides_faces_of_terrain() {
    let text = "[[terrain]]\ntype = \"box\"\nposition = [0, 0, 0.1]\nsize = [1, 1, 0.2]\n\
                [[terrain]]\ntype = \"heightfield\"\nfile = \"h.csv\"\nspacing = 1\n";
    let (_folder, run) = run(text, &[("h.csv", b"-1,-1,-1\n-1,-1,-1\n-1,-1,1\n")]);
    let level = Plane { rotation: Matrix3::identity(), point: Vector3::zeros() };
    let terrain = assemble::terrain::terrain(&run, Some(level), &mut Vec::new(), &mut Vec::new());
    assert_eq!(terrain.pieces()[0].faces.iter().filter(|face| face.touchable).count(), 5);
    let (mut buffer, mut tops, mut walls) = (TerrainPiece::prism_buffer(), 0, 0);
    let far = Vector3::repeat(100.0);
    terrain.near(&-far, &far, |piece| {
        if let PieceRef::Prism { .. } = piece {
            let piece = terrain.piece(piece, &mut buffer);
            tops += usize::from(piece.faces[0].touchable);
            walls += piece.faces[1..].iter().filter(|face| face.touchable).count();
        }
    });
    assert_eq!((tops, walls), (2, 2), "only the corner rises above the floor");
}

#[test]
fn broken_height_fields_are_refused_with_file_and_line() {
    let field = |rest: &str| format!("[[terrain]]\ntype = \"heightfield\"\n{rest}\n");
    let csv = field("file = \"h.csv\"\nspacing = 0.1");
    let in_table = |line, column| Some(("h.csv", line, column));
    refused(&csv, &[("h.csv", b"0,1\n2,x\n")], in_table(2, 3), "expected a finite number, found \"x\"");
    refused(&csv, &[("h.csv", b"0,1\n2,nan\n")], in_table(2, 3), "expected a finite number, found \"nan\"");
    refused(&csv, &[("h.csv", b"# h\n0,1\n2,3,4\n")], in_table(3, 1), "this row has 3 heights, the first one has 2");
    let at_key = Some(("s.toml", 4, 8));
    refused(&csv, &[("h.csv", b"0,1\n")], at_key, "h.csv: the grid has 1 x 2 heights (rows x columns); from 2 to 4096");
    refused(&csv, &[("h.csv", b"0,1\n2,\xff\n")], at_key, "h.csv: the file is not UTF-8");
    refused(
        &csv,
        &[("h.csv", b"0,1\n2,1e7\n")],
        at_key,
        "the height 10000000 m in row 2, column 2 is beyond 1000000 m",
    );
    let narrow = field("file = \"h.csv\"\nsize = [1, 1e-6]");
    refused(&narrow, &[("h.csv", b"0,1\n2,3\n4,5\n")], Some(("s.toml", 5, 8)), "3 rows and 2 columns of this size are");
    let png = field("file = \"h.png\"\nspacing = 0.1\nheight = [0, 1]");
    refused(&png, &[("h.png", b"\xff\xd8 a JPEG")], at_key, "h.png: the file is not a PNG");
    let whole = std::fs::read("tests/scenario/bumps.png").unwrap();
    refused(&png, &[("h.png", &whole[..60])], at_key, "h.png: the PNG is damaged: it ends within a chunk");
}

#[test]
fn broken_meshes_are_refused_at_their_key() {
    let mesh = |rest: &str| format!("[[terrain]]\ntype = \"mesh\"\nfile = \"m.obj\"\n{rest}\n");
    let at_key = Some(("s.toml", 4, 8));
    refused(&mesh(""), &[("m.obj", b"v 0 0 0\n")], at_key, "m.obj: it has no triangles");
    let flat = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4\nf 1 4 3\n";
    refused(&mesh("as = \"convex\""), &[("m.obj", flat)], at_key, "it is flat, so its convex hull has no volume");
    refused(
        &mesh("scale = 1e7"),
        &[("m.obj", flat)],
        at_key,
        "at the scale 10000000 it has coordinates beyond 1000000 m",
    );
    let line = b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    refused(&mesh(""), &[("m.obj", line)], at_key, "none of its triangles has an area");
    let (_folder, run) = run(&mesh(""), &[("m.obj", flat)]);
    assert_eq!(terrain(&run).0.pieces().len(), 2, "as triangles it is a ground");
}

#[test]
fn the_number_of_faces_has_a_bound() {
    let stairs = "[[terrain]]\ntype = \"stairs\"\nsteps = 1000\nrise = 0.1\nrun = 0.3\nwidth = 1\n";
    let message = "with `terrain.166` the terrain has 1002000 faces, at most 1000000 are allowed";
    refused(&stairs.repeat(167), &[], Some(("s.toml", 998, 1)), message);
}
