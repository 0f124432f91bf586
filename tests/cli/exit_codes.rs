//! Tests of each exit code.

use super::Place;

#[test]
fn a_passed_run_exits_with_0() {
    let place = Place::new();
    place.block("rest.toml", "");
    place.runner(&["--set", "duration=0.1", "rest.toml"]).exits(0);
}

#[test]
fn a_broken_expectation_exits_with_1() {
    let place = Place::new();
    place.block("rest.toml", "[[expect]]\nmetric = \"final_base_z\"\nmin = 1.0\n");
    let done = place.runner(&["--set", "duration=0.1", "rest.toml"]).exits(1);
    assert!(done.stdout.contains("below 1"), "{}", done.stdout);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["failed"]);
    assert!(summary.column("message")[0].starts_with("final_base_z is 0.0"), "{:?}", summary.column("message"));
}

#[test]
fn a_fall_is_a_failure_only_against_an_expectation() {
    let place = Place::new();
    // The block's base is 5 cm above the floor.
    place.block("low.toml", "[stop]\nfallen = { below = 1.0 }\n");
    place.runner(&["low.toml"]).exits(0);
    assert_eq!(place.summary("results").column("outcome"), ["fallen"]);
    place.block("up.toml", "[stop]\nfallen = { below = 1.0 }\n[[expect]]\noutcome = \"passed\"\n");
    place.runner(&["up.toml"]).exits(1);
    assert_eq!(place.summary("results").column("outcome"), ["failed"]);
}

#[test]
fn wrong_usage_exits_with_2() {
    let place = Place::new();
    place.block("rest.toml", "");
    let wrong: &[&[&str]] = &[
        &[],
        &["run"],
        &["--no-such-option", "rest.toml"],
        &["-j", "0", "rest.toml"],
        &["-j", "two", "rest.toml"],
        &["--timeout", "0", "rest.toml"],
        &["--timeout", "nan", "rest.toml"],
        &["--set", "duration", "rest.toml"],
        &["--set", "duration=[1", "rest.toml"],
        &["--max-runs", "0", "rest.toml"],
        &["schema", "results"],
        &["list", "--format", "xml", "rest.toml"],
        &["inspect"],
        &["report", "results"],
    ];
    for arguments in wrong {
        let done = place.runner(arguments).exits(2);
        assert!(!done.stderr.is_empty(), "{arguments:?} prints no error");
        assert!(!place.path("results").exists(), "{arguments:?} wrote");
    }
}

#[test]
fn invalid_numbers_are_refused_with_the_valid_range() {
    let place = Place::new();
    place.block("rest.toml", "");
    for (arguments, expected) in [
        (&["rest.toml", "--jobs", "0"][..], "expected a whole number of at least 1"),
        (&["rest.toml", "-j", "-2"], "expected a whole number of at least 1"),
        (&["rest.toml", "--max-fail", "-1"], "expected a whole number of at least 1"),
        (&["rest.toml", "--max-runs", "0"], "expected a whole number of at least 1"),
        (&["rest.toml", "--timeout", "-1"], "expected a number of seconds greater than 0"),
        (&["rest.toml", "--slow", "soon"], "expected a number of seconds greater than 0"),
        (&["replay", "x", "--timeout", "-1"], "expected a number of seconds greater than 0"),
        (&["view", "x", "--rate", "-1"], "expected a number greater than 0"),
        (&["export", "x", "--rate", "-1"], "expected a number greater than 0"),
        (&["compare", "a", "b", "--absolute", "-1"], "expected a number of at least 0"),
        (&["compare", "a", "b", "--timing", "-1"], "expected a number of at least 1"),
    ] {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains(expected), "{arguments:?}: {}", done.stderr);
    }
}

#[test]
fn a_misspelt_command_is_distinguished_from_a_missing_file() {
    let place = Place::new();
    place.block("rest.toml", "");
    let done = place.runner(&["chekc", "rest.toml"]).exits(2);
    assert!(done.stderr.contains("did you mean `runner check`?"), "{}", done.stderr);
    let done = place.runner(&["nowhere.toml"]).exits(2);
    assert!(done.stderr.contains("nowhere.toml") && done.stderr.contains("cannot read"), "{}", done.stderr);
}

#[test]
fn a_diverged_run_exits_with_3() {
    let place = Place::new();
    // Speeds beyond 1e6 m/s count as divergence.
    place.block("fast.toml", "base = { linear_velocity = [1e7, 0, 0] }\n");
    place.runner(&["fast.toml"]).exits(3);
    assert_eq!(place.summary("results").column("outcome"), ["diverged"]);
    place.block("known.toml", "base = { linear_velocity = [1e7, 0, 0] }\n[[expect]]\noutcome = \"diverged\"\n");
    place.runner(&["known.toml"]).exits(0);
}

#[test]
fn a_timed_out_run_exits_with_3_and_other_runs_continue() {
    let place = Place::new();
    place.block("long.toml", "[log]\nrate = 0\n[sweep]\ngrid = { duration = [1e9, 0.1] }\n");
    let done = place.runner(&["long.toml", "--timeout", "1", "-j", "1"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["timed-out", "passed"], "{}", done.stderr);
    assert_eq!(summary.column("message")[0], "not at its end after 1 s of wall-clock time");
    let wall = summary.numbers("wall_s")[0];
    // The limit begins some instants before the time is measured, and the run ends after it: how much depends on
    // the load of the machine.
    assert!(wall >= 0.5, "ended after {wall} s");
    let simulated = summary.numbers("duration_s")[0];
    assert!(simulated > 0.0 && simulated < 1e9, "the state at the time limit is kept: {simulated}");
}

#[test]
fn a_time_limit_applies_while_a_script_is_loaded() {
    let place = Place::new();
    // Nine tenths of the instructions that a script may use while it is loaded: some tenths of a
    // second.
    place.write("slow.luau", "for i = 1, 9e5 do local x = {} end\nfunction run() return {} end\n");
    place.block("slow.toml", &"[[force]]\ntype = \"script\"\nfile = \"slow.luau\"\n".repeat(10));
    let done = place.runner(&["slow.toml", "--timeout", "0.001"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["timed-out"], "{}", done.stderr);
    assert_eq!(summary.column("message"), ["not at its end after 0.001 s of wall-clock time"]);
}

/// Soles that no state clamps in the vertices below the floor: very many states are tried.
const SUNK_SOLES: &str = r#"
soles = [
    { name = "l_foot0", link = "l_foot", polygon = [[0.043752055442, -0.01442925476, -0.002225301688], [0.049249263013, -0.035509823691, -0.029959030838], [0.017879441854, -0.04354248418, -0.043929717865], [-0.007005381415, -0.027426372451, -0.024830348144], [0.00898477316, -0.009433407147, 0.000944398534]] },
    { name = "l_foot1", link = "l_foot", polygon = [[-0.030593008133, 0.010756779121, 0.008274283052], [-0.043716030696, -0.003185542975, -0.00936420583], [-0.039602084234, -0.004918072083, -0.035011664652], [-0.021349054342, 0.006863821553, -0.04935503381], [-0.002701844823, 0.023288131718, -0.041593463775], [0.002297815222, 0.031987017863, -0.017571575091], [-0.010114920196, 0.026410041296, 0.004621660105]] },
    { name = "l_foot2", link = "l_foot", polygon = [[0.049873892085, 0.031140468229, -0.022353844096], [0.036793423822, 0.01957197627, -0.041661606795], [0.031251523238, -0.005687257562, -0.044657737762], [0.037421354507, -0.025616514998, -0.029086089268], [0.050656908842, -0.025208658705, -0.006672430232], [0.060991543873, -0.00477081279, 0.005705296935], [0.060643068632, 0.020306907916, -0.001273588782]] },
    { name = "r_foot0", link = "r_foot", polygon = [[0.069406412266, -0.033079545467, 0.006107605631], [0.059485218372, -0.057111791798, -0.017720748448], [0.044401675024, -0.040128484308, -0.044698950703], [0.045000726459, -0.005599976707, -0.037544042573], [0.060454503955, -0.001243492919, -0.006143863907]] },
    { name = "r_foot1", link = "r_foot", polygon = [[0.043552086429, -0.020132582648, 0.005089843046], [0.064802529384, -0.010184866057, -0.006187566475], [0.066480734354, 0.004131091139, -0.027866020162], [0.047322978767, 0.012035081181, -0.04362120023], [0.021755443328, 0.007575238354, -0.04158913474], [0.009031003704, -0.005890084729, -0.023300010452], [0.018731422464, -0.018221225144, -0.002525910987]] },
    { name = "r_foot2", link = "r_foot", polygon = [[0.076411023865, -0.032081272398, -0.024847618672], [0.063467886858, -0.018456907781, 0.00499566036], [0.028992032258, -0.012703991654, 0.000295786345], [0.020627919331, -0.022772858569, -0.03245217457], [0.049934467856, -0.034748676678, -0.047991653463]] },
]
"#;

#[test]
fn a_time_limit_ends_a_search_for_contact_states() {
    let place = Place::new();
    let robot = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    let start = "base = { position = [0, 0, 0.25] }";
    let text =
        format!("stop.sunk_link = \"ignore\"\n[robot]\nmodel = {robot:?}\ncontact = \"soles\"\n{start}{SUNK_SOLES}");
    place.write("sunk.toml", text);
    let done = place.runner(&["sunk.toml", "--timeout", "0.2"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["timed-out"], "{}", done.stderr);
    assert_eq!(summary.numbers("duration_s"), [0.0], "the first choice of states");
}

#[test]
fn an_empty_selection_exits_with_4() {
    let place = Place::new();
    place.write("empty/read.me", "no scenario");
    for arguments in [&["empty"][..], &["run", "empty"], &["check", "empty"], &["list", "empty"]] {
        let done = place.runner(arguments).exits(4);
        assert!(done.stderr.contains("nothing selected"), "{}", done.stderr);
    }
    assert!(!place.path("results").exists());
}

#[test]
fn fail_fast_starts_no_run_after_the_first_failure() {
    let place = Place::new();
    place.block(
        "sweep.toml",
        "[[expect]]\nmetric = \"duration_s\"\nmax = 0.15\n[sweep]\ngrid = { duration = [0.1, 0.2, 0.3, 0.4] }\n",
    );
    let done = place.runner(&["sweep.toml", "--fail-fast", "-j", "1"]).exits(1);
    assert_eq!(place.summary("results").column("outcome"), ["passed", "failed"]);
    assert!(done.stdout.contains("2 runs not started"), "{}", done.stdout);
}

#[test]
fn max_fail_stops_after_that_many_failures() {
    let place = Place::new();
    place.block(
        "sweep.toml",
        "[[expect]]\nmetric = \"duration_s\"\nmax = 0.01\n[sweep]\ngrid = { duration = [0.02, 0.005, 0.03, 0.04, 0.05] }\n",
    );
    let outcomes = |max_fail: &str| {
        let done = place.runner(&["sweep.toml", "--max-fail", max_fail, "-j", "1", "-o", max_fail]).exits(1);
        let outcomes: Vec<String> = place.summary(max_fail).column("outcome").into_iter().map(str::to_owned).collect();
        (outcomes, done.stdout.lines().find(|line| line.ends_with("not started")).map(str::to_owned))
    };
    let some = |text: &str| Some(text.to_owned());
    assert_eq!(outcomes("1"), (vec!["failed".into()], some("4 runs not started")));
    assert_eq!(
        outcomes("3"),
        (["failed", "passed", "failed", "failed"].map(String::from).into(), some("1 run not started"))
    );
    assert_eq!(outcomes("4").1, None, "the last run had started already");
    place.runner(&["sweep.toml", "--max-fail", "0"]).exits(2);
    place.runner(&["sweep.toml", "--max-fail", "2", "--fail-fast"]).exits(2);
}

#[test]
fn strict_treats_warnings_as_errors() {
    let place = Place::new();
    // A push that begins after the end of the run is valid, but probably unintended.
    place.block(
        "warned.toml",
        "[[force]]\ntype = \"push\"\nlink = \"block\"\nforce = [1, 0, 0]\nstart = 9.0\nduration = 0.1\n",
    );
    let lenient = place.runner(&["check", "warned.toml"]).exits(0);
    assert!(lenient.stderr.contains("warning"), "{}", lenient.stderr);
    place.runner(&["check", "--strict", "warned.toml"]).exits(2);
    place.runner(&["run", "--strict", "warned.toml"]).exits(2);
    assert!(!place.path("results").exists());

    // The same holds if only the reference ends before the push.
    place.block(
        "shorter.toml",
        "[[force]]\ntype = \"push\"\nlink = \"block\"\nforce = [1, 0, 0]\nstart = 2.0\nduration = 0.1\n\
         [compare]\nreference = { duration = 1.0 }\n",
    );
    let lenient = place.runner(&["check", "shorter.toml"]).exits(0);
    assert!(lenient.stderr.contains("starts at 2 s, but the run ends at 1 s"), "{}", lenient.stderr);
    assert!(lenient.stderr.contains("this concerns the reference run"), "{}", lenient.stderr);
    place.runner(&["check", "--strict", "shorter.toml"]).exits(2);

    // A robot's warnings count as well.
    let urdf = std::fs::read_to_string(place.path("block/block.urdf")).unwrap();
    let no_mesh = urdf.replacen("<box size=\"0.2 0.2 0.1\"/>", "<mesh filename=\"none.stl\"/>", 1);
    place.block("rest.toml", "").write("block/block.urdf", no_mesh);
    let lenient = place.runner(&["check", "rest.toml"]).exits(0);
    assert!(lenient.stderr.contains("block/block.urdf:"), "{}", lenient.stderr);
    place.runner(&["check", "--strict", "rest.toml"]).exits(2);
}

#[test]
fn a_stalled_run_exits_with_3_and_a_reason() {
    let place = Place::new();
    // Twenty nanometres above the floor and without loss, one bounce takes 0.13 ms.
    place.block(
        "bounce.toml",
        "base = { position = [0, 0, 0.05000002] }\n[contact]\nrestitution = 1.0\nvelocity_tolerance = 1e-9\n",
    );
    place.runner(&["--set", "duration=1.0", "bounce.toml"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["stalled"]);
    assert!(
        summary.column("message")[0].contains("contact events within one second"),
        "{:?}",
        summary.column("message")
    );
    // With a matching expectation the batch passes.
    place.block(
        "expected.toml",
        "base = { position = [0, 0, 0.05000002] }\n[contact]\nrestitution = 1.0\nvelocity_tolerance = 1e-9
        [[expect]]\noutcome = \"stalled\"\n",
    );
    place.runner(&["--set", "duration=1.0", "expected.toml"]).exits(0);
}
