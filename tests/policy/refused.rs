//! Errors of policies are found before the first step, at the position of the wrong value.

use super::folder;
use super::onnx_file::identity;

const TASK: &str = "observations = [{ term = \"gravity\" }]
action = { joints = [\"left_knee\", \"right_knee\", \"head_pan\"] }";

fn text(task: &str) -> String {
    format!(
        "duration = 1.0\nrobot = {{ model = \"ROBOTS/hoap2/hoap2.toml\" }}\n\
         [[task]]\ntype = \"policy\"\nfile = \"n.onnx\"\n{task}\n"
    )
}

/// The diagnostics of a task, at the first of which `line` and the message must be.
#[track_caller]
fn refused(network: impl AsRef<[u8]>, task: &str, line: usize, message: &str) {
    let found = folder(network).refused(&text(task));
    let first = &found.0[0];
    let at = first.position.map(|position| position.line);
    assert!(first.message.contains(message), "{task}\n{found}");
    assert_eq!(at, Some(line), "{task}\n{found}");
}

/// Line 4 is that of `type`, 5 of `file`, 6 the first of the task's own keys.
#[test]
fn joints_soles_and_lists_must_fit_the_robot() {
    let network = identity(3);
    let with = |observation: &str| {
        format!(
            "observations = [{{ {observation} }}]\naction = {{ joints = [\"left_knee\", \"right_knee\", \"head_pan\"] }}"
        )
    };
    refused(&network, &with("term = \"joint-velocities\", joints = [\"left_ne\"]"), 6, "has no joint `left_ne`");
    refused(&network, &with("term = \"joint-velocities\", joints = [\"x*\"]"), 6, "has no joint `x*`");
    let twice = "term = \"joint-velocities\", joints = [\"left_knee\", \"left_*\"]";
    refused(&network, &with(twice), 6, "the joint `left_knee` is named twice");
    refused(&network, &with("term = \"contacts\", soles = [\"lef\"]"), 6, "has no sole `lef`");
    refused(&network, &with("term = \"gravity\", scale = [1, 2]"), 6, "must be one number or a list of 3, not of 2");
    let gains = "observations = [{ term = \"gravity\" }]\naction = { joints = [\"left_knee\"], kp = [1, 2] }";
    refused(&network, gains, 7, "must be one number or a list of 1, not of 2");
    refused(&network, &format!("posture = {{ left_ne = 1 }}\n{TASK}"), 6, "has no joint `left_ne`");
    refused(&network, &format!("keyframe = \"stand\"\n{TASK}"), 6, "has no keyframe `stand`");
    refused(
        &network,
        "observations = [{ term = \"gravity\" }]\naction = { joints = [\"knee\"] }",
        7,
        "no joint `knee`",
    );
}

#[test]
fn keys_must_belong_to_their_term() {
    let network = identity(3);
    let with =
        |observation: &str| format!("observations = [{{ {observation} }}]\naction = {{ joints = [\"left_knee\"] }}");
    let meaningless = "has no meaning with this `term`: leave it out";
    refused(&network, &with("term = \"gravity\", joints = [\"left_knee\"]"), 6, meaningless);
    refused(&network, &with("term = \"gravity\", values = [1]"), 6, meaningless);
    refused(&network, &with("term = \"sole-forces\", threshold = 1"), 6, meaningless);
    refused(&network, &with("term = \"joint-velocities\", relative = false"), 6, meaningless);
    refused(&network, &with("term = \"command\""), 6, "`task.0.observations.0` needs `values`");
    refused(&network, &with("term = \"sine\""), 6, "`task.0.observations.0` needs `period`");
    refused(&network, &with("term = \"weight\""), 6, "cannot be \"weight\"");
    refused(&network, "observations = []\naction = { joints = [\"left_knee\"] }", 6, "must have at least one term");
    refused(&network, "observations = [{ term = \"gravity\" }]\naction = { joints = [] }", 7, "at least one joint");
    refused(&network, &format!("{TASK}\nhistory = 1001"), 8, "must be at most 1000, not 1001");
    refused(&network, &format!("{TASK}\ndecimation = 0"), 8, "must be at least 1, not 0");
    refused(&network, &format!("{TASK}\nchange = [{{ at = 0.5, values = [1] }}]"), 8, "requires one term `command`");
    let command = "observations = [{ term = \"command\", values = [1, 2] }]\naction = { joints = [\"left_knee\"] }";
    let change = format!("{command}\nchange = [{{ at = 0.5, values = [1] }}]");
    refused(&network, &change, 8, "must have 2 numbers, as the term `command` has, not 1");
    let force =
        "observations = [{ term = \"gravity\" }]\naction = { joints = [\"left_knee\"], mode = \"force\", kp = 1 }";
    refused(&network, force, 7, "has no meaning with `mode = \"force\"`");
    let negative = "observations = [{ term = \"gravity\" }]\naction = { joints = [\"left_knee\"], kd = [-1] }";
    refused(&network, negative, 7, "must be 0 or greater, not -1");
}

#[test]
fn the_file_must_be_named_and_readable() {
    let task = text(TASK).replace("n.onnx", "n.pt");
    let found = folder(identity(3)).refused(&task).to_string();
    assert!(found.contains("must name a file that ends in `.onnx`, not \"n.pt\""), "{found}");
    let task = text(TASK).replace("n.onnx", "none.onnx");
    let found = folder(identity(3)).refused(&task).to_string();
    assert!(found.contains("cannot read ") && found.contains("none.onnx"), "{found}");
}

/// A program without networks still checks the task, then names the build that has them.
#[cfg(not(feature = "policy"))]
#[test]
fn a_program_without_networks_says_how_to_get_them() {
    let found = folder(identity(3)).refused(&text(TASK));
    let first = &found.0[0];
    assert_eq!(first.message, "this program was built without networks, which the type `policy` requires");
    assert_eq!(first.position.map(|position| position.line), Some(4));
    let help = first.help.as_deref().unwrap_or_default();
    assert!(help.contains("`cargo build --release --features policy`"), "{help}");
}

#[cfg(feature = "policy")]
mod networks {
    use super::super::onnx_file::{FLOAT, Message, affine, constant, file, node, value};
    use super::{TASK, identity, refused};

    const THREE: [Option<u64>; 2] = [None, Some(3)];
    /// Number of the type of double precision.
    const DOUBLE: u64 = 11;

    #[test]
    fn widths_must_match_the_observations_and_joints() {
        let terms = "observations = [{ term = \"gravity\" }, { term = \"joint-positions\" }]
            action = { joints = [\"left_knee\", \"right_knee\"] }\nhistory = 2";
        let message = "the input `obs` of the network takes 3 numbers, the observations have 10: \
            gravity 3, joint-positions 2; times `history` = 2";
        refused(identity(3), terms, 6, message);
        let message =
            "the output `actions` of the network has 2 numbers, the action has 3: left_knee, right_knee, head_pan";
        refused(affine(3, &[0.0; 6], &[0.0; 2]), TASK, 7, message);
    }

    #[test]
    fn inputs_and_outputs_must_be_known() {
        let two = |task: &str, line: usize, message: &str| {
            let network = file(
                &[value("a", FLOAT, &THREE), value("b", FLOAT, &THREE)],
                &[value("y", FLOAT, &THREE), value("z", FLOAT, &THREE)],
                &[],
                &[node("Add", &["a", "b"], &["y"]), node("Sub", &["a", "b"], &["z"])],
            );
            refused(network, &format!("{TASK}\n{task}"), line, message);
        };
        two("", 5, "the network must have one output besides states; it has `y`, `z`");
        two("output = \"y\"", 5, "the network must have one input besides states; it has `a`, `b`");
        two("output = \"x\"", 8, "the network has no output `x`; it has `y`, `z`");
        two("output = \"y\"\ninput = \"c\"", 9, "the network has no input `c`; it has `a`, `b`");
        two("output = \"y\"\ninput = \"a\"", 5, "the network also requires the input `b`");
        two("state = [{ input = \"b\", output = \"h\" }]", 8, "the network has no output `h`; it has `y`, `z`");
        let state = "state = [{ input = \"b\", output = \"z\" }, { input = \"b\", output = \"z\" }]";
        two(state, 8, "names \"b\" a second time");
    }

    #[test]
    fn states_must_keep_their_size() {
        let network = file(
            &[value("obs", FLOAT, &THREE), value("h", FLOAT, &[Some(1), Some(2)])],
            &[value("y", FLOAT, &THREE), value("g", FLOAT, &THREE)],
            &[],
            &[node("Relu", &["obs"], &["y"]), node("Neg", &["obs"], &["g"])],
        );
        let task = format!("{TASK}\nstate = [{{ input = \"h\", output = \"g\" }}]");
        refused(network, &task, 8, "the output `g` of the network has 3 numbers, its input has 2");
    }

    #[test]
    fn unsupported_networks_are_refused() {
        let network = |kind: u64, dims: &[Option<u64>], node: Message| {
            file(&[value("obs", kind, dims)], &[value("y", kind, dims)], &[constant("c", &[1], &[1.0])], &[node])
        };
        let unknown = network(FLOAT, &THREE, node("Wobble", &["obs"], &["y"]));
        refused(unknown, TASK, 5, "operators that are not supported: `Wobble`");
        let random = network(FLOAT, &THREE, node("RandomNormalLike", &["obs"], &["y"]));
        refused(random, TASK, 5, "the operator `RandomNormalLike` draws random numbers");
        let double = network(DOUBLE, &THREE, node("Neg", &["obs"], &["y"]));
        refused(double, TASK, 5, "the input `obs` takes numbers of type F64, supported is F32");
        let rows = network(FLOAT, &[Some(4), Some(3)], node("Neg", &["obs"], &["y"]));
        refused(rows, TASK, 5, "the input `obs` has the shape [4, 3], supported is one row");
        let undefined = network(FLOAT, &THREE, node("Add", &["obs", "d"], &["y"]));
        refused(undefined, TASK, 5, "the network");
        refused("no network", TASK, 5, "it is no ONNX file");
        refused("", TASK, 5, "it is no ONNX file: it has no graph");
        let whole = identity(3);
        refused(&whole[..whole.len() / 2], TASK, 5, "it is no ONNX file");
    }

    /// Numbers in another file would be missing in the run key.
    #[test]
    fn all_numbers_must_be_in_the_file() {
        let location = Message::default().bytes(1, "location").bytes(2, "weights.bin");
        let tensor = Message::default().number(1, 3).number(2, FLOAT).bytes(8, "c").bytes(13, location).number(14, 1);
        let network = file(
            &[value("obs", FLOAT, &THREE)],
            &[value("y", FLOAT, &THREE)],
            &[tensor],
            &[node("Add", &["obs", "c"], &["y"])],
        );
        refused(network, TASK, 5, "the numbers of `c` are in another file");
    }

    /// Damaged files are refused or run; nothing panics.
    #[test]
    fn damaged_files_do_not_panic() {
        let whole = identity(3);
        let folder = super::folder(&whole);
        let mut accepted = 0;
        for i in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[i] ^= 1 << (i % 8);
            std::fs::write(folder.path().join("n.onnx"), damaged).expect("the folder is writable");
            let run = folder.run(&super::text(TASK)).unwrap_or_else(|e| panic!("{e}"));
            accepted += usize::from(stiction::assemble::setup(&run, &crate::support::folder::robot_of(&run)).is_ok());
        }
        println!("{accepted} of {} accepted", whole.len());
    }
}
