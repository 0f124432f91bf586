//! `report.html`: complete, inert, well-formed, and bounded.

use super::pareto::run;
use stiction::report::{Pictured, ReportRun, write_report};
use stiction::results::{Machine, SummaryRow, Verdict};
use stiction::sim::Outcome;

/// The report page for rows.
fn page(rows: &[SummaryRow]) -> String {
    page_with(rows, &[])
}

fn page_with(rows: &[SummaryRow], notes: &[String]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let machine = Machine { os: "linux".into(), arch: "x86_64".into(), cpus: 2 };
    let runs: Vec<ReportRun> = rows
        .iter()
        .map(|row| ReportRun { row, origin: Some(("stiction 0.1.0", &machine)), notes, files: &[] })
        .collect();
    let path = folder.path().join("report.html");
    write_report(&path, folder.path(), &runs, &[], &Pictured::Few).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no other files");
    std::fs::read_to_string(path).unwrap()
}

/// All SVG pictures of a page.
fn pictures(html: &str) -> Vec<&str> {
    html.match_indices("<svg").map(|(at, _)| &html[at..at + html[at..].find("</svg>").unwrap() + 6]).collect()
}

/// Asserts that the page loads and executes nothing, and that every picture is valid XML.
fn assert_inert(html: &str) {
    let rest = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in
        ["http", "src=", "<script", "<link", "<iframe", "@import", "url(", "javascript:", "onload", "onerror=\""]
    {
        assert!(!rest.contains(word), "{word} at {}", &rest[rest.find(word).unwrap()..][..80.min(rest.len())]);
    }
    for (at, _) in rest.match_indices("href=") {
        assert!(rest[at..].starts_with("href=\"#"), "only within the page: {}", &rest[at..at + 40]);
    }
    for svg in pictures(html) {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e}: {svg}"));
        // Browsers silently omit shapes with NaN in a coordinate.
        let attributes = document.descendants().flat_map(|n| n.attributes().collect::<Vec<_>>());
        let bad = attributes
            .filter(|a| a.name() != "aria-label")
            .find(|a| ["NaN", "inf"].iter().any(|w| a.value().contains(w)));
        assert!(bad.is_none(), "{bad:?}");
    }
}

/// Positions of the marks of a picture, their titles, and whether they are filled.
fn marks(svg: &str) -> Vec<(f64, f64, String, bool)> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let paths = document.descendants().filter(|n| n.has_tag_name("path"));
    paths
        .map(|path| {
            let start = path.attribute("d").unwrap()[1..].split(['h', 'l', 'a']).next().unwrap();
            let (x, y) = start.split_once(' ').unwrap();
            let title =
                path.children().find(|n| n.has_tag_name("title")).and_then(|t| t.text()).unwrap_or("").to_owned();
            (x.parse().unwrap(), y.parse().unwrap(), title, path.attribute("fill") == path.attribute("stroke"))
        })
        .collect()
}

fn step(method: &str, h: f64, cost: f64, error: f64) -> SummaryRow {
    run(method, &[("contact.method", method.into()), ("integrator.step", h.into())], cost, Some(error))
}

#[test]
fn axes_are_logarithmic_and_front_marks_are_full() {
    // Errors differ by a factor of 100, costs by 10. The last run is worse than the one before it.
    let rows = [
        step("lcp", 1e-2, 1e-3, 1e-2),
        step("lcp", 1e-3, 1e-2, 1e-4),
        step("lcp", 1e-4, 1e-1, 1e-6),
        step("lcp", 1e-5, 1.0, 1e-5),
    ];
    let html = page(&rows);
    assert_inert(&html);
    let plots: Vec<&str> = pictures(&html).into_iter().filter(|svg| svg.contains("class=\"plot\"")).collect();
    assert_eq!(plots.len(), 1, "one picture per error");
    let mut marks = marks(plots[0]);
    marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(marks.iter().map(|m| m.3).collect::<Vec<_>>(), [true, true, true, false]);
    let [(x0, y0, first, _), (x1, y1, ..), (x2, y2, ..), (x3, y3, last, _)] = &marks[..] else { panic!("{marks:?}") };
    // Coordinates are rounded to whole units.
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1.0, "{a} {b}");
    near(x1 - x0, x2 - x1);
    near(x2 - x1, x3 - x2);
    near(y1 - y0, y2 - y1);
    assert!(y1 > y0, "smaller errors are lower");
    near((y2 - y3) * 2.0, y1 - y0);
    assert_eq!(
        first,
        "lcp semi-implicit\nintegrator.step = 0.01\nerror_position_rms_m: 1.000e-2 m\ncost: 1.000e-3 s per s, 666.7 x real time\nlcp-lcp-0.01, on the Pareto front"
    );
    assert!(last.ends_with("lcp-lcp-1e-5"), "{last}");
    assert!(html.contains(">error, m<") || plots[0].contains("error, m"), "the axis has the unit");
}

#[test]
fn zero_errors_have_their_own_line() {
    let rows = [step("exact", 1e-2, 0.1, 0.0), step("lcp", 1e-2, 0.01, 1e-3), step("lcp", 1e-3, 0.5, 1e-4)];
    let html = page(&rows);
    assert_inert(&html);
    let plot = pictures(&html).into_iter().find(|svg| svg.contains("class=\"plot\"")).unwrap();
    assert!(plot.contains("<title>no error at all</title>"), "{plot}");
    let marks = marks(plot);
    assert_eq!(marks.len(), 3);
    let zero = marks.iter().find(|m| m.2.contains("error_position_rms_m: 0.000e0 m")).unwrap();
    assert!(marks.iter().all(|m| m.1 <= zero.1), "below all others: {marks:?}");
    // Only zero errors, and a single run.
    for rows in [&[step("exact", 1e-2, 0.1, 0.0), step("exact", 1e-3, 0.2, 0.0)][..], &[step("exact", 1e-2, 0.1, 0.5)]]
    {
        let html = page(rows);
        assert_inert(&html);
        assert!(html.contains("on the Pareto front\n") || html.contains(", on the Pareto front"), "{html}");
    }
}

#[test]
fn runs_without_a_point_are_named_with_the_reason() {
    let mut lost = step("penalty", 1e-2, 0.1, 1.0);
    lost.comparison.error_position_rms_m = None;
    lost.outcome = Outcome::Diverged;
    let mut never = step("penalty", 1e-5, 0.1, 1.0);
    never.metrics.duration_s = 0.0;
    let rows = [
        step("lcp", 1e-2, 0.1, 1e-3),
        lost,
        step("ncp", 1e-3, 0.1, f64::NAN),
        step("ncp", 1e-4, 0.1, f64::INFINITY),
        never,
    ];
    let html = page(&rows);
    assert_inert(&html);
    for reason in [
        "error_position_rms_m: it ended as diverged (1 run): penalty semi-implicit integrator.step=0.01",
        "error_position_rms_m: the error is NaN (1 run): ncp semi-implicit integrator.step=0.001",
        "error_position_rms_m: the error is inf (1 run): ncp semi-implicit integrator.step=0.0001",
        "error_position_rms_m: it has no cost: nothing was simulated (1 run): penalty semi-implicit integrator.step=1e-5",
    ] {
        assert!(html.contains(reason), "{reason}\n{html}");
    }
}

#[test]
fn untrusted_text_is_escaped() {
    const EVIL: &str = "<script>alert('1')</script>\"&<img src=x onerror=\"y\">";
    let mut row = run(EVIL, &[(EVIL, EVIL.into()), ("integrator.step", 1e-3.into())], 1.0, Some(1e-3));
    (row.scenario, row.key, row.integrator, row.message) = (EVIL.into(), EVIL.into(), EVIL.into(), EVIL.into());
    row.outcome = Outcome::Failed;
    row.verdicts = vec![Verdict { metric: EVIL.into(), message: EVIL.into(), ..Verdict::default() }];
    let html = page_with(&[row], &[EVIL.to_owned()]);
    let rest = html.replace("&lt;img src=x onerror=", "");
    assert_inert(&rest);
    assert!(!html.contains("<img") && html.matches("&lt;script&gt;").count() > 10, "shown as text everywhere");
}

#[test]
fn every_run_is_listed_and_nan_is_marked() {
    let mut rows: Vec<SummaryRow> = (0..20).map(|i| step("lcp", f64::from(i), 0.1, 1e-3)).collect();
    rows[3].metrics.max_penetration_m = f64::NAN;
    rows[4].metrics.max_penetration_m = f64::NEG_INFINITY;
    rows[5].metrics.max_penetration_m = 0.25;
    rows[6].message = "reason of the failure".into();
    rows[6].outcome = Outcome::Stalled;
    let html = page(&rows);
    assert_inert(&html);
    for row in &rows {
        assert!(html.contains(&format!("<td class=\"key\">{}</td>", row.key)), "{}", row.key);
    }
    for cell in [
        "<td class=\"n bad\">NaN</td>",
        "<td class=\"n bad\">-inf</td>",
        "<td class=\"n worst\">0.25</td>",
        "<td class=\"bad\">stalled</td>",
        "<td class=\"good\">passed</td>",
        "<td>reason of the failure</td>",
    ] {
        assert!(html.contains(cell), "{cell}");
    }
    assert!(html.contains("20 runs of 1 scenario<") && html.contains("19 passed") && html.contains("1 stalled"));
}

#[test]
fn expectations_show_all_digits_and_failures_first() {
    let mut row = step("lcp", 1e-3, 0.1, 1e-3);
    let verdict = Verdict {
        metric: "final_base_x".into(),
        measured: Some(0.123_456_789_012_345_68),
        truth: Some(0.125),
        allowed: Some(1e-3),
        error: Some(0.123_456_789_012_345_68 - 0.125),
        held: false,
        message: "final_base_x is too small".into(),
        ..Verdict::default()
    };
    let limit =
        Verdict { metric: "jams".into(), max: Some(0.0), measured: Some(0.0), held: true, ..Verdict::default() };
    row.verdicts = vec![limit, verdict];
    let html = page(&[row]);
    assert_inert(&html);
    for text in [
        "0.12345678901234568",
        ">0.125<",
        "-0.00154",
        "0.0123",
        ">no<",
        "1 of 2 expectations held",
        "1 more not shown that held",
    ] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn a_page_without_runs_is_valid() {
    let html = page(&[]);
    assert_inert(&html);
    assert!(html.contains("0 runs of 0 scenarios"));
}

#[test]
fn the_size_of_a_page_is_bounded() {
    // 40 problems of 25 steps each, all with an error.
    let sweep_rows = |problems: i64| -> Vec<SummaryRow> {
        let cell = |mu: i64, i: i64| {
            let parameters = [("floor.friction", mu.into()), ("integrator.step", i.into())];
            run("lcp", &parameters, 1.0 / (1.0 + i as f64), Some(1e-3 * (1.0 + i as f64)))
        };
        (0..problems).flat_map(|mu| (0..25).map(move |i| cell(mu, i))).collect()
    };
    let rows = sweep_rows(40);
    let thousand = page(&rows);
    assert_inert(&thousand);
    assert!(rows.iter().all(|row| thousand.contains(&format!(">{}</td>", row.key))), "a thousand runs are all listed");
    assert!(thousand.contains("16 groups more without pictures here"), "24 groups are drawn");
    let mut rows = sweep_rows(200);
    rows[4321].outcome = Outcome::Diverged;
    let five_thousand = page(&rows);
    assert!(five_thousand.contains(&format!(">{}</td>", rows[4321].key)), "failed runs are listed");
    assert!(five_thousand.contains("4000 more runs are in summary.csv"));
    assert!(thousand.len() < 2_000_000, "{}", thousand.len());
    // The larger page is longer only by some digits.
    assert!(five_thousand.len() < thousand.len() + thousand.len() / 20, "{} {}", five_thousand.len(), thousand.len());
}
