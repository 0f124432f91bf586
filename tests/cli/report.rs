//! Tests of `runner report` and of the report page of a batch.

use super::Place;
use std::fs;

const SWEEP: &str = "base = { position = [0, 0, 0.2] }\n[sweep]\ngrid = { \"floor.friction\" = [0.9, 0.25], \
    \"contact.method\" = [\"one-step\", \"exact\"] }\nrepeat = 2\n[[expect]]\nmetric = \"final_base_z\"\nvalue = 0.05\ntolerance = 1e-2\n";

#[test]
fn report_reproduces_summary_and_page() {
    let place = Place::new();
    place.block("drop.toml", SWEEP).block("rest.toml", "");
    let done = place.runner(&["rest.toml", "drop.toml", "--set", "duration=0.5", "-j", "2"]).exits(0);
    assert!(done.stdout.contains("results/report.html"), "{}", done.stdout);
    let names = ["summary.csv", "summary.parquet", "report.html"];
    let read = || names.map(|name| fs::read(place.path("results").join(name)).unwrap());
    let first = read();
    let done = place.runner(&["report", "results"]).exits(0);
    assert!(done.stderr.contains("9 records read, 0 passed over"), "{}", done.stderr);
    for (name, (before, after)) in names.iter().zip(first.iter().zip(read())) {
        assert!(*before == after, "{name} differs");
        assert!(done.stdout.contains(&format!("results/{name}")), "{}", done.stdout);
    }
    // Without the earlier summary, rows are in the order of names and values. No run is missing.
    fs::remove_file(place.path("results/summary.csv")).unwrap();
    place.runner(&["report", "results"]).exits(0);
    let table = place.summary("results");
    assert_eq!(table.column("scenario")[8], "rest");
    assert_eq!(table.column("floor.friction"), ["0.25", "0.25", "0.25", "0.25", "0.9", "0.9", "0.9", "0.9", ""]);
    assert_eq!(table.column("method")[..4], ["exact", "exact", "one-step", "one-step"]);
    assert_eq!(table.column("seed")[..4], ["1", "2", "1", "2"]);
}

#[test]
fn failed_runs_are_drawn_before_passed_runs() {
    let place = Place::new();
    place.block(
        "drop.toml",
        "base = { position = [0, 0, 0.1] }\n[[expect]]\nmetric = \"final_base_z\"\nvalue = 0.06\ntolerance = 1e-3\n",
    );
    let good: String = (1..9).map(|i| format!("{i}, ")).collect();
    place.block("rest.toml", &format!("[sweep]\ngrid = {{ seed = [{good}] }}\n"));
    place.runner(&["rest.toml", "drop.toml", "--set", "duration=0.3"]).exits(1);
    let page = || fs::read_to_string(place.path("results/report.html")).unwrap();
    let html = page();
    // A fall of 0.05 m takes 0.1 s. From then on the block's sole is on the floor.
    assert!(html.contains("<title>bottom: face-static, 0.10"), "{html}");
    let drawn = |html: &str| -> Vec<String> {
        html.match_indices("over time\"")
            .map(|(at, _)| html[..at].rsplit('"').next().unwrap().trim().to_owned())
            .collect()
    };
    let names = drawn(&html);
    assert_eq!(names.len(), 6, "{names:?}");
    assert_eq!(names[5], "drop exact dopri5", "the failed run is drawn, in the order of the plan");
    assert!(html.contains("3 runs more with logs"), "8 + 1 - 6 runs are not drawn");

    let keys = place.summary("results").column("key").iter().map(|k| (*k).to_owned()).collect::<Vec<_>>();
    place.runner(&["report", "results", "--runs", &keys[2][..8], &keys[7], "-o", "chosen/page.html"]).exits(0);
    let chosen = fs::read_to_string(place.path("chosen/page.html")).unwrap();
    assert_eq!(drawn(&chosen).len(), 2);
    assert_eq!(page(), html, "the page of the results is unchanged");
    let refused = place.runner(&["report", "results", "--runs", "nosuchkey"]).exits(2);
    assert!(refused.stderr.contains("no run has a key that begins with `nosuchkey`"), "{}", refused.stderr);
}

#[test]
fn invalid_records_are_reported_and_skipped() {
    let place = Place::new();
    place.block("rest.toml", "");
    place.runner(&["rest.toml", "--set", "duration=0.1", "--no-log", "-o", "all/deep/shard"]).exits(0);
    let key = place.summary("all/deep/shard").column("key")[0].to_owned();
    let record = fs::read_to_string(place.path("all/deep/shard/rest").join(&key).join("run.json")).unwrap();
    place.write("all/foreign/run.json", "{\"name\": \"of another program\"}");
    place.write("all/torn/run.json", &record[..record.len() / 2]);
    place.write("all/newer/run.json", record.replacen("\"schema\": 1", "\"schema\": 99", 1));
    place.write("all/twice/run.json", &record);
    place.write("all/.hidden/run.json", "not looked at");
    place.write("all/note.txt", "no record");
    let done = place.runner(&["report", "all"]).exits(0);
    assert!(done.stderr.contains("1 record read, 4 passed over"), "{}", done.stderr);
    for text in [
        "warning: passed over: all/foreign/run.json: missing field `schema`",
        "warning: passed over: all/torn/run.json: EOF",
        "warning: passed over: all/newer/run.json: record format 99",
        "warning: passed over: all/twice/run.json: the same run as all/deep/shard/rest/",
    ] {
        assert!(done.stderr.contains(text), "{text}\n{}", done.stderr);
    }
    assert_eq!(place.summary("all").column("key"), [key.as_str()]);
    let named = place.runner(&["report", "all", "--runs", &key]).exits(0);
    assert!(named.stderr.contains("left no log: there is nothing to show"), "{}", named.stderr);
}

#[test]
fn a_folder_without_records_is_an_error() {
    let place = Place::new();
    place.write("empty/foreign/run.json", "[]");
    let done = place.runner(&["report", "empty"]).exits(2);
    assert!(done.stderr.contains("error: no record of a run below empty"), "{}", done.stderr);
    assert!(!place.path("empty/summary.csv").exists() && !place.path("empty/report.html").exists());
    let done = place.runner(&["report", "nowhere"]).exits(2);
    assert!(done.stderr.contains("error: nowhere: "), "{}", done.stderr);
}

#[test]
fn references_have_no_rows_and_errors_have_a_pareto_table() {
    let place = Place::new();
    place.block(
        "slide.toml",
        "base = { linear_velocity = [1, 0, 0] }\n[integrator]\nmethod = \"semi-implicit\"\n[compare]\nreference = \
         { \"contact.method\" = \"exact\", \"integrator.method\" = \"dopri5\", \"integrator.step\" = 1e-3 }\ntiming_repeats = 2\n[sweep]\ngrid = \
         { \"floor.friction\" = [0.5, 0.9], \"integrator.step\" = [1e-2, 1e-3] }\n",
    );
    let done = place.runner(&["slide.toml", "--set", "duration=0.3", "-v"]).exits(0);
    for group in ["slide  floor.friction=0.5\n", "slide  floor.friction=0.9\n"] {
        assert!(done.stdout.contains(group), "{}", done.stdout);
    }
    let header = "method  integrator     parameters  error_position_rms_m";
    assert_eq!(done.stdout.lines().filter(|l| l.starts_with(header)).count(), 2, "{}", done.stdout);
    let names = ["summary.csv", "report.html"];
    let read = || names.map(|name| fs::read(place.path("results").join(name)).unwrap());
    let first = read();
    let again = place.runner(&["report", "results"]).exits(0);
    assert!(again.stderr.contains("6 records read, 0 passed over"), "four runs, two references: {}", again.stderr);
    assert!(first == read(), "a file differs");
    assert_eq!(place.summary("results").rows.len(), 4);
    let table = |text: &str| text.split("\nslide  floor").nth(1).unwrap().split("\nwritten").next().unwrap().to_owned();
    assert_eq!(table(&format!("\n{}", again.stdout)), table(&done.stdout), "the same table");
    let html = String::from_utf8(read()[1].clone()).unwrap();
    assert!(
        html.contains("<h3>References</h3>") && html.contains("slide&#x2f;references&#x2f;"),
        "references are listed"
    );
    // One plot per error and friction: position, force, final position and final rotation. The
    // block has no joints.
    assert_eq!(html.matches("over cost, slide").count(), 8);
}

#[test]
fn a_table_of_another_program_has_a_page_and_can_be_compared() {
    let place = Place::new();
    let header = "scenario,key,outcome,message,method,integrator,seed,integrator.step,duration_s,cpu_s,steps,error_stop_distance\n";
    let rows = |error: &str| {
        format!(
            "{header}slide,a1,passed,,peer,default,1,0.001,0.5,0.02,500,{error}\n\
             slide,a2,passed,,peer,default,1,0.004,0.5,0.005,125,4e-3\n\
             slide,a3,passed,,other,default,1,0.001,0.5,0.05,500,2e-5\n\
             slide,a4,unsupported,no slopes,third,default,1,0.001,,,,\n"
        )
    };
    place.write("peers/summary.csv", rows("1e-3"));
    place.write("newer.csv", rows("2e-3"));
    let done = place.runner(&["report", "peers/summary.csv"]).exits(0);
    assert!(done.stderr.contains("1 row with the outcome `unsupported` passed over\n3 rows read"), "{}", done.stderr);
    let row = |method: &str, step: &str| {
        let is_row = |line: &&str| line.starts_with(method) && line.contains(step);
        done.stdout.lines().find(is_row).unwrap_or_else(|| panic!("{}", done.stdout)).to_owned()
    };
    // Costs per simulated second: 0.04, 0.01 and 0.1. All are on the front.
    for (method, step, error, cost) in [
        ("peer", "0.001", "1.00e-3", "4.00e-2"),
        ("peer", "0.004", "4.00e-3", "1.00e-2"),
        ("other", "", "2.00e-5", "1.00e-1"),
    ] {
        let row = row(method, step);
        assert!(row.contains(error) && row.contains(cost) && row.contains('*'), "{row}");
    }
    let page = fs::read_to_string(place.path("peers/report.html")).unwrap();
    assert_eq!(page.matches("over cost, slide").count(), 1, "one plot");
    place.runner(&["report", "newer.csv", "-o", "page.html"]).exits(0);
    assert!(place.path("page.html").exists() && !place.path("report.html").exists());

    let compared = place.runner(&["compare", "peers/summary.csv", "newer.csv"]).exits(1);
    assert!(compared.stdout.contains("error_stop_distance"), "{}", compared.stdout);
    place.runner(&["compare", "peers", "peers/summary.csv"]).exits(0);

    let refused = place.runner(&["report", "newer.csv", "--runs", "a1"]).exits(2);
    assert!(
        refused.stderr.contains("--runs draws logs, which the table newer.csv does not have"),
        "{}",
        refused.stderr
    );
    place.write("none.csv", header);
    let refused = place.runner(&["report", "none.csv"]).exits(2);
    assert!(refused.stderr.contains("error: no row of a run in none.csv"), "{}", refused.stderr);
    place.write("other.csv", "a,b\n1,2\n");
    let refused = place.runner(&["report", "other.csv"]).exits(2);
    assert!(refused.stderr.contains("not a summary of runs: it has no column `scenario`"), "{}", refused.stderr);
}
