//! The section of the report on a history.

use std::fs;

use crate::cli::Place;

/// A run whose distance depends on the friction.
fn place() -> Place {
    let place = Place::new();
    place.block("s.toml", "base = { linear_velocity = [1, 0, 0] }\n");
    for (i, friction) in ["0.5", "0.5", "0.4"].into_iter().enumerate() {
        let (set, output) = (format!("floor.friction={friction}"), format!("r{i}"));
        place.runner(&["s.toml", "--set", "duration=0.5", "--set", &set, "--no-log", "-o", &output]).exits(0);
    }
    place
}

fn section(page: &str) -> Option<&str> {
    let from = page.find("<section id=\"history\">")?;
    Some(&page[from..from + page[from..].find("</section>").unwrap()])
}

#[test]
fn metrics_that_changed_are_drawn_with_labels_and_values() {
    let place = place();
    for (i, label) in ["v1", "<b>&\"", ""].into_iter().enumerate() {
        let results = format!("r{i}");
        let done = place.runner(&["compare", "--baseline", "h", "--append", "--label", label, &results]);
        done.exits(i32::from(i == 2));
    }
    let page = |arguments: &[&str], output: &str| {
        place.runner(&[&["report", "r2"], arguments].concat()).exits(0);
        fs::read_to_string(place.path(output)).unwrap()
    };
    let without = page(&[], "r2/report.html");
    assert!(section(&without).is_none());
    let with = page(&["--history", "h/history.parquet"], "r2/report.html");
    let found = section(&with).unwrap();
    assert!(found.contains("s: final_base_x over the results of the history\""), "{found}");
    assert!(!found.contains("over the results of the history\" width=\"560\" height=\"0"));
    assert!(found.contains("&lt;b&gt;&amp;") && !found.contains("<b>"), "labels are text");
    // A mark per result, with its value.
    for results in ["r0", "r1", "r2"] {
        let x = place.summary(results).column("final_base_x")[0].to_owned();
        assert!(found.contains(&format!("<title>{x} in ")), "{x}");
    }
    assert!(!found.contains("s: duration_s over") && !found.contains("s: wall_s over"), "constant, and a time");
    // All but the section is as without.
    assert_eq!(with.replace(found, "").len() + found.len(), with.len());
    // Next to the results it is found, and for a table too.
    fs::copy(place.path("h/history.parquet"), place.path("r2/history.parquet")).unwrap();
    assert_eq!(page(&[], "r2/report.html"), with);
    place.runner(&["report", "r2/summary.csv", "-o", "table.html"]).exits(0);
    assert!(section(&fs::read_to_string(place.path("table.html")).unwrap()).is_some());
    // A new batch keeps the history of its folder.
    place.runner(&["s.toml", "--set", "duration=0.1", "--no-log", "-o", "r2"]).exits(0);
    assert!(place.path("r2/history.parquet").exists());
    place.write("none.parquet", "none");
    let done = place.runner(&["report", "r2", "--history", "none.parquet"]).exits(2);
    assert!(done.stderr.contains("none.parquet: "), "{}", done.stderr);
}

#[test]
fn metrics_of_claims_are_drawn_though_they_are_constant() {
    let place = place();
    let claim = "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nat_most = 0.0\n\
                 [[claim]]\nname = \"d\"\nquantile = 0.5\nmetric = \"steps\"\nat_most = 99\n";
    place.block("s.toml", &format!("base = {{ linear_velocity = [1, 0, 0] }}\n[sweep]\nrepeat = 5\n{claim}"));
    place.runner(&["s.toml", "--set", "duration=0.1", "--no-log", "-o", "a"]).exits(0);
    place.runner(&["compare", "--baseline", "a", "--append", "a"]).exits(0);
    place.runner(&["report", "a"]).exits(0);
    let page = fs::read_to_string(place.path("a/report.html")).unwrap();
    let found = section(&page).unwrap();
    assert_eq!(found.matches("over the results of the history").count(), 2, "{found}");
    assert!(found.contains("s: impacts over") && found.contains("s: steps over"), "{found}");
}
