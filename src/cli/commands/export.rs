//! `runner export`: writes a log's time series as CSV, Parquet or columns of text, or the log as a
//! ROS 2 bag.

use crate::files::names;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::export::bag::{self, BagLog};
use crate::export::{self, DataTable, ExportError, HeaderStyle, NumberFormat};
use crate::export::{Selection, TableFormat, TextFormat, TimeUnit};
use crate::log::{LogError, Trajectory, read_bytes};
use crate::text::visible::visible_path;
use clap::{Args, ValueEnum};

use crate::cli::Exit;
use crate::cli::arguments::numbers;
use crate::cli::terminal::{complain, complain_of, plural, print};

/// Options that only tables have.
const TABLE_OPTIONS: [&str; 12] = [
    "format",
    "rate",
    "columns",
    "events",
    "list_columns",
    "separator",
    "numbers",
    "header",
    "comment",
    "missing",
    "time_unit",
    "blocks",
];

/// Arguments of `export`.
#[derive(Args, Debug)]
pub struct Export {
    /// A log, or the folder of a run
    #[arg(value_name = "LOG|FOLDER")]
    log: PathBuf,
    /// File to write, or folder of a bag [default: standard output; the bag SCENARIO_KEY]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format [default: by the extension of the file]
    #[arg(long, value_enum)]
    format: Option<Kind>,
    /// Rows per simulated second, Hz [default: the instants of the log]
    #[arg(long, value_name = "HZ", value_parser = numbers::positive, allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Columns by name, with `*` and `?` as wildcards; separated by commas, may be repeated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// First instant, s
    #[arg(long, value_name = "S", value_parser = numbers::finite, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last instant, s
    #[arg(long, value_name = "S", value_parser = numbers::finite, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Export events (touchdown, slip, impact, ...) instead of time series
    #[arg(long, conflicts_with_all = ["columns", "rate", "list_columns"])]
    events: bool,
    /// Write a ROS 2 bag (MCAP) instead, a folder with all topics
    #[arg(long, conflicts_with_all = TABLE_OPTIONS)]
    bag: bool,
    /// Print the names of the columns only
    #[arg(long, conflicts_with = "output")]
    list_columns: bool,
    #[command(flatten)]
    text: Text,
}

/// Format of text for gnuplot.
#[derive(Args, Debug)]
#[command(next_help_heading = "Text for gnuplot")]
struct Text {
    /// Separator of cells: `space`, `tab`, `comma`, `semicolon` or the characters themselves
    /// [default: space]
    #[arg(long, value_name = "WORD", value_parser = export::separator)]
    separator: Option<String>,
    /// Format of numbers: `exact`, or a printf format such as `%.9g` [default: exact]
    #[arg(long, value_name = "FORMAT")]
    numbers: Option<NumberFormat>,
    /// Row of column names: plain, as a comment, or none [default: plain]
    #[arg(long, value_enum)]
    header: Option<HeaderKind>,
    /// Start of comment lines [default: #]
    #[arg(long, value_name = "SIGN", value_parser = export::visible)]
    comment: Option<String>,
    /// Text of missing values [default: NaN]
    #[arg(long, value_name = "WORD", value_parser = export::visible)]
    missing: Option<String>,
    /// Unit of the time [default: s]
    #[arg(long, value_enum)]
    time_unit: Option<Unit>,
    /// Start a new block (gnuplot's `index`) whenever this column changes
    #[arg(long, value_name = "COLUMN")]
    blocks: Option<String>,
}

/// Format of a table.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Comma-separated values (.csv)
    Csv,
    /// Parquet (.parquet)
    Parquet,
    /// Columns of text (.dat, .txt)
    Gnuplot,
}

/// Row of column names above columns of text.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum HeaderKind {
    Plain,
    Comment,
    None,
}

/// A unit of time.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Unit {
    S,
    Ms,
    Min,
}

impl Export {
    /// Reads the log and writes the selected data.
    pub fn execute(self) -> Result<Exit, Exit> {
        if self.bag {
            return self.write_bag();
        }
        let format = self.format()?;
        let log = self.read(Trajectory::from_bytes)?;
        if self.list_columns {
            print(&export::column_names(&log).iter().map(|name| format!("{name}\n")).collect::<String>())?;
            return Ok(Exit::Success);
        }
        let table = self.table(&log).map_err(refuse)?;
        warn_if_incomplete(&log);
        match &self.output {
            Some(path) => {
                export::write(&table, &format, path).map_err(not_written)?;
                complain(&format!("{}: {} columns, {} rows", path.display(), table.columns().len(), table.rows()));
            }
            None => {
                let bytes = export::to_bytes(&table, &format).map_err(refuse)?;
                print(&String::from_utf8_lossy(&bytes))?;
            }
        }
        Ok(Exit::Success)
    }

    fn write_bag(&self) -> Result<Exit, Exit> {
        let log = self.read(BagLog::from_bytes)?;
        let Some(folder) = self.output.clone().or_else(|| log.default_folder()) else {
            return Err(refuse("the log's scenario and key are no name of a folder: name one with `--output`"));
        };
        let written = bag::write(&log, &self.selection(), &folder).map_err(not_written)?;
        warn_if_incomplete(&log.trajectory);
        let (topics, messages) = (plural(written.topics, "topic"), written.messages);
        complain(&format!("{}: {topics}, {messages} messages", visible_path(&folder)));
        Ok(Exit::Success)
    }

    fn selection(&self) -> Selection {
        Selection { columns: self.columns.clone(), rate: self.rate, from: self.from, to: self.to }
    }

    fn table(&self, log: &Trajectory) -> Result<DataTable, ExportError> {
        let selection = self.selection();
        if self.events { Ok(export::events(log, &selection)) } else { export::series(log, &selection) }
    }

    /// Reads the log by `parse`, which receives its path and bytes.
    fn read<T>(&self, parse: impl FnOnce(&Path, &[u8]) -> Result<T, LogError>) -> Result<T, Exit> {
        let path = if self.log.is_dir() { self.log.join(names::LOG) } else { self.log.clone() };
        if let Some(output) = &self.output
            && same_file(output, &path)
        {
            return Err(refuse(format!("{} is the log itself: choose another file to write", output.display())));
        }
        read_bytes(&path).and_then(|bytes| parse(&path, &bytes)).map_err(|error| match &error {
            LogError::Io { .. } if self.log.is_dir() && !path.exists() => {
                refuse(format!("{}: no run's folder with a log: there is no log.mcap in it", self.log.display()))
            }
            _ => refuse(error),
        })
    }

    fn format(&self) -> Result<TableFormat, Exit> {
        let kind = match (self.format, &self.output) {
            (Some(kind), _) => kind,
            (None, None) => {
                if self.text.is_given() {
                    Kind::Gnuplot
                } else {
                    Kind::Csv
                }
            }
            (None, Some(path)) => by_ending(path)?,
        };
        if kind != Kind::Gnuplot && self.text.is_given() {
            return Err(refuse(
                "separator, numbers, header, comment, missing, time-unit and blocks are of `--format gnuplot`",
            ));
        }
        match kind {
            Kind::Csv => Ok(TableFormat::Csv),
            Kind::Parquet if self.output.is_none() && !self.list_columns => {
                Err(refuse("Parquet is no text: name a file with `--output`"))
            }
            Kind::Parquet => Ok(TableFormat::Parquet),
            Kind::Gnuplot => Ok(TableFormat::Text(self.text.format())),
        }
    }
}

impl Text {
    fn is_given(&self) -> bool {
        let Text { separator, numbers, header, comment, missing, time_unit, blocks } = self;
        separator.is_some()
            || numbers.is_some()
            || header.is_some()
            || comment.is_some()
            || missing.is_some()
            || time_unit.is_some()
            || blocks.is_some()
    }

    fn format(&self) -> TextFormat {
        let plain = TextFormat::default();
        TextFormat {
            separator: self.separator.clone().unwrap_or(plain.separator),
            numbers: self.numbers.unwrap_or(plain.numbers),
            header: self.header.map_or(plain.header, |h| match h {
                HeaderKind::Comment => HeaderStyle::Comment,
                HeaderKind::Plain => HeaderStyle::Plain,
                HeaderKind::None => HeaderStyle::None,
            }),
            comment: self.comment.clone().unwrap_or(plain.comment),
            missing: self.missing.clone().unwrap_or(plain.missing),
            time: self.time_unit.map_or(plain.time, |t| match t {
                Unit::S => TimeUnit::Seconds,
                Unit::Ms => TimeUnit::Milliseconds,
                Unit::Min => TimeUnit::Minutes,
            }),
            blocks: self.blocks.clone(),
        }
    }
}

fn by_ending(path: &Path) -> Result<Kind, Exit> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match ending.as_str() {
        "csv" => Ok(Kind::Csv),
        "parquet" => Ok(Kind::Parquet),
        "dat" | "txt" => Ok(Kind::Gnuplot),
        _ => Err(refuse(format!(
            "{}: unknown file extension: use .csv, .parquet, .dat or .txt, or give `--format`",
            path.display()
        ))),
    }
}

/// Do both paths name the same existing file?
fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn warn_if_incomplete(log: &Trajectory) {
    if !log.complete {
        complain("warning: the run did not end by itself; its log ends early");
    }
}

/// The exit code of an export that could not be written, or that the log does not allow.
fn not_written(error: ExportError) -> Exit {
    refuse(&error);
    match &error {
        ExportError::Record(cause) => Exit::of_writing(cause),
        ExportError::Bag { source, .. } => Exit::of_writing(source),
        _ => Exit::Invalid,
    }
}

fn refuse(why: impl Display) -> Exit {
    complain_of(why);
    Exit::Invalid
}
