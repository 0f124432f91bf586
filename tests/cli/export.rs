//! Tests of `export`: tables of a log, read back with other libraries where possible.

use std::fs;
use std::path::PathBuf;

use polars::prelude::DataFrame;
use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;
use stiction::log::Trajectory;

use super::{Done, Place, Table};

/// The block falls flat, slides and comes to rest.
const FALL: &str =
    "base = { position = [0, 0, 0.2], linear_velocity = [1, 0, 0] }\n[floor]\nfriction = 0.3\n[log]\nrate = 100\n";

/// A finished run and its relative folder.
fn finished_run(duration: f64) -> (Place, String) {
    let place = Place::new();
    place.write("fall.toml", format!("duration = {duration}\n[robot]\nmodel = \"block/block.toml\"\n{FALL}"));
    place.runner(&["fall.toml"]).exits(0);
    let key = fs::read_dir(place.path("results/fall")).unwrap().next().unwrap().unwrap().file_name();
    let folder = format!("results/fall/{}", key.to_str().unwrap());
    (place, folder)
}

fn log(place: &Place, folder: &str) -> Trajectory {
    Trajectory::read(&place.path(folder).join("log.mcap")).unwrap()
}

fn frame(path: PathBuf) -> DataFrame {
    ParquetReader::new(fs::File::open(path).unwrap()).finish().unwrap()
}

#[test]
fn csv_contains_the_log_to_the_last_bit() {
    let (place, folder) = finished_run(0.6);
    let done = place.runner(&["export", &folder, "-o", "out/all.csv"]).exits(0);
    assert_eq!(done.stdout, "");
    let table = Table::read(&place.path("out/all.csv"));
    assert!(done.stderr.contains(&format!("{} columns, 61 rows", table.header.len())), "{}", done.stderr);
    let log = log(&place, &folder);
    let (motion, sole) = (log.motion.unwrap(), &log.soles.unwrap()[0]);
    let same = |name: &str, expected: Vec<f64>| {
        let found: Vec<u64> = table.numbers(name).iter().map(|x| x.to_bits()).collect();
        assert_eq!(found, expected.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), "{name}");
    };
    same("time_s", log.times.clone());
    same("base_x_m", motion.base_position.iter().map(|p| p.x).collect());
    same("base_vz_m_s", motion.base_linear_velocity.iter().map(|p| p.z).collect());
    same("base_qy", motion.base_orientation.iter().map(|q| q.j).collect());
    same("com_z_m", motion.com.iter().map(|p| p.z).collect());
    same(&format!("sole.{}.force_z_N", sole.name), sole.force.iter().map(|f| f.z).collect());
    same(&format!("sole.{}.vertex3.vx_m_s", sole.name), sole.vertices[3].velocity.iter().map(|v| v.x).collect());
    let residuals = log.residuals.unwrap();
    same("residual.penetration_m", residuals.iter().map(|r| r.penetration).collect());
    same("energy.friction_loss_J", residuals.iter().map(|r| r.friction_loss).collect());
    assert_eq!(table.column(&format!("sole.{}.state", sole.name)), sole.state);
    let clamped: Vec<String> = sole.vertices[0].clamped.iter().map(bool::to_string).collect();
    assert_eq!(table.column(&format!("sole.{}.vertex0.clamped", sole.name)), clamped);
    // In flight there is no centre of pressure, and the cell is empty.
    let empty: Vec<bool> = table.column("cop_x_m").iter().map(|c| c.is_empty()).collect();
    assert_eq!(empty, motion.cop.iter().map(Option::is_none).collect::<Vec<_>>());
    assert!(empty[0] && !empty[60], "the block falls and lands");
    // Without a file the table goes to standard output.
    assert_eq!(
        place.runner(&["export", &folder]).exits(0).stdout,
        fs::read_to_string(place.path("out/all.csv")).unwrap()
    );
}

#[test]
fn parquet_contains_the_same_table() {
    let (place, folder) = finished_run(0.3);
    place.runner(&["export", &format!("{folder}/log.mcap"), "-o", "all.parquet"]).exits(0);
    place.runner(&["export", &folder, "-o", "all.csv"]).exits(0);
    let (csv, parquet) = (Table::read(&place.path("all.csv")), frame(place.path("all.parquet")));
    let names: Vec<&str> = parquet.get_column_names().into_iter().map(|n| n.as_str()).collect();
    assert_eq!(names, csv.header);
    for (name, column) in names.iter().zip(parquet.columns()) {
        let cells = csv.column(name);
        if let Ok(numbers) = column.f64() {
            let bits = |x: Option<f64>| x.map(f64::to_bits);
            let found: Vec<_> = numbers.iter().map(bits).collect();
            let written: Vec<_> = cells.iter().map(|c| bits(c.parse().ok())).collect();
            assert_eq!(found, written, "{name}");
        } else if let Ok(words) = column.str() {
            assert_eq!(words.iter().map(Option::unwrap).collect::<Vec<_>>(), cells, "{name}");
        } else {
            let flags: Vec<String> = column.bool().unwrap().iter().map(|f| f.unwrap().to_string()).collect();
            assert_eq!(flags, cells, "{name}");
        }
    }
    assert!(names.iter().any(|n| n.ends_with(".state")) && names.iter().any(|n| n.ends_with(".clamped")));
}

#[test]
fn resampling_interpolates_numbers_and_holds_text() {
    let (place, folder) = finished_run(0.6);
    let log = log(&place, &folder);
    let (motion, sole) = (log.motion.unwrap(), &log.soles.unwrap()[0]);
    let columns = "base_z_m,sole.*.state,cop_x_m";
    let at = |rate: &str| {
        Table::parse(&place.runner(&["export", &folder, "--rate", rate, "--columns", columns]).exits(0).stdout)
    };
    // Half the log's rate: every other tick, to the last bit.
    let half = at("50");
    assert_eq!(half.rows.len(), 31);
    let expected: Vec<f64> = motion.base_position.iter().step_by(2).map(|p| p.z).collect();
    assert_eq!(half.numbers("base_z_m"), expected);
    // Four times the rate: linear interpolation between ticks, and text from the preceding tick.
    let fourfold = at("400");
    assert_eq!(fourfold.rows.len(), 241);
    let (z, state) = (fourfold.numbers("base_z_m"), fourfold.column(&format!("sole.{}.state", sole.name)));
    for (k, z) in z.iter().enumerate() {
        let (i, s) = (k / 4, (k % 4) as f64 / 4.0);
        let (a, b) = (motion.base_position[i].z, motion.base_position.get(i + 1).map_or(0.0, |p| p.z));
        // Error: the time of a tick and k / rate differ by a rounding, 1e-16 of 0.01 s in the
        // fraction.
        let expected = if s == 0.0 { a } else { a + s * (b - a) };
        assert!((z - expected).abs() < 1e-13, "{k}");
        assert!(s != 0.0 || *z == a, "at a tick the value of the log");
        assert_eq!(state[k], sole.state[i], "{k}");
    }
    let times = fourfold.numbers("time_s");
    assert!(times.iter().enumerate().all(|(k, t)| *t == k as f64 / 400.0));
}

#[test]
fn orientations_are_interpolated_on_the_shortest_arc() {
    let place = Place::new();
    // Free spin about z at 40 rad/s, far from the floor. At 100 Hz a tick is 0.4 rad, and the yaw
    // crosses +-pi.
    let spin = "base = { position = [0, 0, 9], angular_velocity = [0, 0, 40] }\n[log]\nrate = 100\n";
    place.write(
        "spin.toml",
        format!("duration = 0.3\ngravity = [0, 0, 0]\n[robot]\nmodel = \"block/block.toml\"\n{spin}"),
    );
    place.runner(&["spin.toml"]).exits(0);
    let key = fs::read_dir(place.path("results/spin")).unwrap().next().unwrap().unwrap().file_name();
    let folder = format!("results/spin/{}", key.to_str().unwrap());
    let out = place.runner(&["export", &folder, "--rate", "1000", "--columns", "base_yaw_rad,base_q?"]).exits(0).stdout;
    let table = Table::parse(&out);
    assert_eq!(table.header, ["time_s", "base_yaw_rad", "base_qw", "base_qx", "base_qy", "base_qz"]);
    let columns = ["base_qw", "base_qx", "base_qy", "base_qz"].map(|c| table.numbers(c));
    for (k, (t, yaw)) in table.numbers("time_s").iter().zip(table.numbers("base_yaw_rad")).enumerate() {
        let turn = 40.0 * t;
        let error = (yaw - turn + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        // A steady rotation follows the arc. The remaining error is that of the integration, 1e-6
        // of 12 rad.
        assert!(error.abs() < 2e-5, "{t}: {yaw} for {turn}");
        let norm: f64 = columns.iter().map(|c| c[k] * c[k]).sum();
        assert!((norm - 1.0).abs() < 1e-12, "{norm}");
    }
}

#[test]
fn columns_are_selected_in_the_given_order_and_listed() {
    let (place, folder) = finished_run(0.1);
    let listed = place.runner(&["export", &folder, "--list-columns"]).exits(0).stdout;
    let listed: Vec<&str> = listed.lines().collect();
    let all = Table::parse(&place.runner(&["export", &folder]).exits(0).stdout);
    assert_eq!(listed, all.header);
    let header = |columns: &[&str]| {
        let mut arguments = vec!["export", &folder];
        columns.iter().for_each(|c| arguments.extend(["--columns", c]));
        Table::parse(&place.runner(&arguments).exits(0).stdout).header
    };
    assert_eq!(header(&["com_z_m,base_x_m"]), ["time_s", "com_z_m", "base_x_m"]);
    assert_eq!(header(&["base_z_m", "base_?_m"]), ["time_s", "base_z_m", "base_x_m", "base_y_m"], "each once");
    assert_eq!(header(&["time_s"]), ["time_s"]);
    assert_eq!(header(&["*"]), listed);
}

#[test]
fn time_limits_are_inclusive() {
    let (place, folder) = finished_run(0.6);
    let times = |arguments: &[&str]| {
        let all = [&["export", &folder, "--columns", "base_z_m"], arguments].concat();
        Table::parse(&place.runner(&all).exits(0).stdout).numbers("time_s")
    };
    let log = log(&place, &folder);
    let between: Vec<f64> = log.times.iter().copied().filter(|t| (0.195..=0.305).contains(t)).collect();
    assert_eq!(between.len(), 11);
    assert_eq!(times(&["--from", "0.195", "--to", "0.305"]), between);
    assert_eq!(times(&["--from", "0.5", "--to", "0.55", "--rate", "40"]), [0.5, 0.525, 0.55]);
    assert_eq!(times(&["--from", "-1", "--to", "0"]), [0.0]);
    assert_eq!(times(&["--rate", "2"]), [0.0, 0.5]);
}

#[test]
fn gnuplot_text_follows_its_options() {
    let (place, folder) = finished_run(0.6);
    let text = |arguments: &[&str]| {
        let all = [&["export", &folder, "--format", "gnuplot", "--columns", "base_z_m,cop_x_m"], arguments].concat();
        place.runner(&all).exits(0).stdout
    };
    let (motion, times) = (log(&place, &folder).motion.unwrap(), log(&place, &folder).times);
    let plain = text(&[]);
    let lines: Vec<&str> = plain.lines().collect();
    assert_eq!(lines[0], "time_s base_z_m cop_x_m");
    assert_eq!(lines.len(), 62);
    assert_eq!(lines[1], format!("{:?} {:?} NaN", times[0], motion.base_position[0].z));
    assert_eq!(lines[61], format!("{:?} {:?} {:?}", times[60], motion.base_position[60].z, motion.cop[60].unwrap().x));
    let formatted = text(&[
        "--separator",
        "semicolon",
        "--numbers",
        "%+.3e",
        "--header",
        "comment",
        "--comment",
        "%",
        "--missing",
        "?",
    ]);
    let lines: Vec<&str> = formatted.lines().collect();
    assert_eq!(lines[..2], ["% time_s;base_z_m;cop_x_m", "+0.000e+00;+2.000e-01;?"]);
    let bare =
        text(&["--header", "none", "--separator", "tab", "--time-unit", "ms", "--to", "0.02", "--numbers", "%.0f"]);
    assert_eq!(bare, "0\t0\tNaN\n10\t0\tNaN\n20\t0\tNaN\n");
    assert!(text(&["--time-unit", "ms"]).starts_with("time_ms base_z_m"));
    assert!(text(&["--time-unit", "min", "--header", "none", "--from", "0.6"]).starts_with("0.01 "));
    // The format follows from the file extension or from an option of this format.
    place.runner(&["export", &folder, "-o", "fall.dat", "--columns", "base_z_m,cop_x_m"]).exits(0);
    assert_eq!(fs::read_to_string(place.path("fall.dat")).unwrap(), plain);
    let by_option = place.runner(&["export", &folder, "--columns", "base_z_m,cop_x_m", "--header", "plain"]).exits(0);
    assert_eq!(by_option.stdout, plain);
}

#[test]
fn a_gnuplot_block_begins_where_its_column_changes() {
    let (place, folder) = finished_run(0.6);
    let states = log(&place, &folder).soles.unwrap()[0].state.clone();
    let state =
        Table::parse(&place.runner(&["export", &folder, "--columns", "*.state"]).exits(0).stdout).header[1].clone();
    let text = place.runner(&["export", &folder, "--columns", "base_z_m,*.state", "--blocks", &state]).exits(0).stdout;
    let blocks: Vec<Vec<&str>> = text.split("\n\n\n").map(|b| b.lines().collect()).collect();
    let mut runs = states.clone();
    runs.dedup();
    assert!(runs.len() >= 2 && runs[0] == "free", "{runs:?}");
    assert_eq!(blocks.len(), runs.len());
    let mut row = 0;
    for (i, (block, run)) in blocks.iter().zip(&runs).enumerate() {
        assert_eq!(block[0], format!("# index {i}: {state} = {run}"));
        assert_eq!(block[1], format!("time_s base_z_m {state}"));
        for line in &block[2..] {
            assert!(line.ends_with(&format!(" {run}")) && states[row] == *run, "{line}");
            row += 1;
        }
    }
    assert_eq!(row, states.len());
}

#[test]
fn events_are_exported_as_a_table() {
    let (place, folder) = finished_run(0.6);
    let events = log(&place, &folder).events;
    let table = Table::parse(&place.runner(&["export", &folder, "--events"]).exits(0).stdout);
    assert_eq!(table.header, ["time_s", "kind", "subject", "message"]);
    assert_eq!(table.numbers("time_s"), events.iter().map(|e| e.time).collect::<Vec<_>>());
    assert_eq!(table.column("kind"), events.iter().map(|e| e.kind.as_str()).collect::<Vec<_>>());
    assert!(table.column("kind").contains(&"touchdown"));
    let early = place.runner(&["export", &folder, "--events", "--to", "0.01"]).exits(0).stdout;
    assert_eq!(early, "time_s,kind,subject,message\n", "no events before the landing");
}

/// Asserts that the arguments are refused with exit code 2 and this text.
#[track_caller]
fn refused(place: &Place, arguments: &[&str], text: &str) -> Done {
    let done = place.runner(&[&["export"], arguments].concat()).exits(2);
    assert!(done.stderr.contains(text), "{text:?} in\n{}", done.stderr);
    assert_eq!(done.stdout, "");
    done
}

#[test]
fn invalid_exports_are_refused_with_a_reason() {
    let (place, folder) = finished_run(0.1);
    let f = folder.as_str();
    place.write("text.mcap", "time,x\n");
    refused(&place, &["none.mcap"], "none.mcap: No such file");
    refused(&place, &["text.mcap"], "text.mcap: not a log of this program: it does not begin as an MCAP file does");
    refused(&place, &["."], "there is no log.mcap in it");
    let bytes = fs::read(place.path(f).join("log.mcap")).unwrap();
    place.write("cut.mcap", &bytes[..bytes.len() / 2]);
    refused(&place, &["cut.mcap"], "cut.mcap: cut short");
    refused(&place, &[f, "--columns", "base_zz_m"], "unknown column `base_zz_m`: did you mean `base_z_m`?");
    refused(&place, &[f, "--columns", "joint.*"], "unknown column `joint.*`: no column matches");
    refused(&place, &[f, "--blocks", "base_q"], "unknown column `base_q`: did you mean `base_q");
    refused(&place, &[f, "-o", "x.xlsx"], "x.xlsx: unknown file extension: use .csv, .parquet, .dat or .txt");
    refused(&place, &[f, "-o", "noending"], "unknown file extension");
    refused(&place, &[f, "--format", "parquet"], "Parquet is no text: name a file");
    refused(&place, &[f, "-o", "x.csv", "--separator", "tab"], "are of `--format gnuplot`");
    refused(&place, &[f, "--from", "7"], "nothing to export from 7 s to 0.1 s: the log reaches from 0 s to 0.1 s");
    refused(&place, &[f, "--rate", "0"], "expected a number greater than 0");
    refused(&place, &[f, "--rate", "fast"], "expected a number greater than 0");
    refused(&place, &[f, "--rate", "1e15"], "is too high");
    refused(&place, &[f, "--to", "inf"], "expected a finite number");
    refused(&place, &[f, "--numbers", "%d"], "`%d` is not a number format");
    refused(&place, &[f, "--separator", "1"], "could be part of a cell");
    refused(&place, &[f, "--comment", " "], "must not be empty and must not contain blanks");
    refused(&place, &[f, "--events", "--rate", "3"], "cannot be used with");
    let own = format!("{f}/log.mcap");
    refused(&place, &[f, "-o", &own, "--format", "csv"], "is the log itself");
    assert_eq!(fs::read(place.path(&own)).unwrap(), bytes);
    for file in ["x.xlsx", "noending", "x.csv"] {
        assert!(!place.path(file).exists(), "{file}");
    }
}

#[test]
fn a_failed_export_leaves_no_partial_file() {
    let (place, folder) = finished_run(0.1);
    place.write("out/kept.csv", "old");
    refused(&place, &[&folder, "-o", "out/kept.csv", "--columns", "nothing"], "unknown column");
    assert_eq!(fs::read_to_string(place.path("out/kept.csv")).unwrap(), "old");
    // A folder has the path of the output file.
    fs::create_dir(place.path("out/folder.csv")).unwrap();
    refused(&place, &[&folder, "-o", "out/folder.csv"], "folder.csv");
    let mut left: Vec<_> = fs::read_dir(place.path("out")).unwrap().map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["folder.csv", "kept.csv"]);
    place.runner(&["export", &folder, "-o", "out/kept.csv"]).exits(0);
    assert!(fs::read_to_string(place.path("out/kept.csv")).unwrap().starts_with("time_s,"));
}

#[test]
fn a_log_without_time_series_exports_events_only() {
    let place = Place::new();
    place.write("s.toml", format!("duration = 0.3\n[robot]\nmodel = \"block/block.toml\"\n{FALL}topics = []\n"));
    place.runner(&["s.toml"]).exits(0);
    let key = fs::read_dir(place.path("results/s")).unwrap().next().unwrap().unwrap().file_name();
    let folder = format!("results/s/{}", key.to_str().unwrap());
    refused(&place, &[&folder], "the log holds no time series");
    let events = place.runner(&["export", &folder, "--events"]).exits(0).stdout;
    assert!(events.contains("touchdown"), "{events}");
}
