//! Logs as `view`, `export`, `salvage` and the console read them.

use std::cell::RefCell;

use stiction::console::Session;
use stiction::export::bag::{self, BagLog};
use stiction::export::{self, Selection, TableFormat, TextFormat};
use stiction::log::{Trajectory, salvage};
use stiction::view::{DrawnRun, pack};

use super::{console, scratch};

/// Queries of a loaded recording.
const QUERIES: [&str; 14] = [
    "status",
    "columns",
    "value *",
    "joints",
    "base",
    "com",
    "zmp",
    "contact",
    "frame block",
    "events",
    "jump next",
    "jump end",
    "play free",
    "now",
];

thread_local! {
    static SESSION: RefCell<Session> = RefCell::new(console::session());
}

/// Reads the bytes of a log.
pub fn take(data: &[u8]) {
    let path = scratch::folder("log").join("log.mcap");
    scratch::write(&path, data);
    match Trajectory::from_bytes(&path, data) {
        Ok(log) => export_all(&log),
        Err(error) => drop(error.to_string()),
    }
    if let Ok(log) = BagLog::from_bytes(&path, data) {
        let _ = bag::to_bytes(&log, &Selection::default()).map_err(|error| error.to_string());
    }
    if let Ok(drawn) = DrawnRun::read(&path) {
        let _ = (drawn.world(), pack(&drawn, None), pack(&drawn, Some(100.0)));
    }
    let salvaged = path.with_file_name("salvaged.mcap");
    let _ = std::fs::remove_file(&salvaged);
    if salvage(&path, &salvaged).is_ok() {
        let bytes = std::fs::read(&salvaged).expect("the recovered log");
        let _ = Trajectory::from_bytes(&salvaged, &bytes).map_err(|error| error.to_string());
    }
    SESSION.with_borrow_mut(|session| {
        if session.execute(&format!("load {}", path.display())).is_ok() {
            QUERIES.iter().for_each(|line| console::execute(session, line));
        }
    });
}

fn export_all(log: &Trajectory) {
    let _ = export::column_names(log);
    let end = log.times.last().copied().unwrap_or_default();
    let selections = [
        Selection::default(),
        Selection { columns: vec!["base_*".into(), "event*".into()], rate: Some(50.0), ..Selection::default() },
        Selection { from: Some(0.0), to: Some(end / 2.0), ..Selection::default() },
    ];
    for selection in selections {
        let tables = [export::series(log, &selection).ok(), Some(export::events(log, &selection))];
        for table in tables.into_iter().flatten() {
            for format in [TableFormat::Csv, TableFormat::Parquet, TableFormat::Text(TextFormat::default())] {
                let _ = export::to_bytes(&table, &format);
            }
        }
    }
}
