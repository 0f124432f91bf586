//! `runner list`: lists the runs that scenarios expand to.

use crate::batch::{Job, Plan};
use crate::results::ParamValue;
use crate::text::csv_line::csv_line;
use crate::text::text_table::limited;
use crate::text::visible::visible;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use crate::cli::Exit;
use crate::cli::arguments::message_format::MessageFormat;
use crate::cli::arguments::selection::Scenarios;
use crate::cli::terminal::{complain, counted, print};

/// Arguments of `list`.
#[derive(Args, Debug)]
pub struct List {
    #[command(flatten)]
    scenarios: Scenarios,
    /// Format of the list
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Format of a list.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Format {
    /// Aligned columns, for people
    Text,
    /// An array of objects
    Json,
    /// One line per run below a header
    Csv,
}

impl List {
    /// Prints the runs in the order in which they would start.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(0, MessageFormat::Human)?;
        if plan.references() > 0 {
            complain(&counted(plan.runs(), plan.references()));
        }
        print(&match self.format {
            Format::Text => text(&plan),
            Format::Json => json(&plan),
            Format::Csv => csv(&plan),
        })?;
        Ok(Exit::Success)
    }
}

/// The runs; of a search, one for each combination of values, without the searched key.
fn listed(plan: &Plan) -> impl Iterator<Item = Job> {
    (0..plan.runs()).filter(|index| plan.is_first(*index)).map(|index| {
        let mut job = plan.job(index);
        let searched = plan.searched_keys(index);
        job.run.parameters.retain(|(name, _)| !searched.contains(&name.as_str()));
        job
    })
}

fn text(plan: &Plan) -> String {
    let names = (0..plan.runs()).map(|run| visible(plan.scenario(run)).chars().count()).max().unwrap_or(0);
    let lines = listed(plan).map(|job| {
        let (key, label) = match plan.search_of(job.index) {
            Some(search) => ("-".repeat(job.key.len()), search),
            None => (job.key.clone(), job.label.clone()),
        };
        let line = format!("{:names$}  {key}  {}", visible(&job.run.name), limited(visible(&label).into_owned()));
        format!("{}\n", line.trim_end())
    });
    lines.collect()
}

fn json(plan: &Plan) -> String {
    let runs = listed(plan).map(|job| {
        let search = plan.search_of(job.index);
        let parameters: Map<String, Value> =
            job.parameters().into_iter().map(|(name, value)| (name, json!(value))).collect();
        json!({
            "scenario": job.run.name,
            "file": job.run.file.display().to_string(),
            "key": if search.is_none() { Some(&job.key) } else { None },
            "search": search,
            "seed": job.run.scenario.seed,
            "reference": job.reference().map(|i| plan.reference_key(i)),
            "parameters": parameters,
        })
    });
    format!("{:#}\n", Value::Array(runs.collect()))
}

/// One column per swept parameter, empty where a run lacks it.
fn csv(plan: &Plan) -> String {
    let rows: Vec<Vec<(String, ParamValue)>> = listed(plan).map(|job| job.parameters()).collect();
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in rows.iter().flatten() {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let header = ["scenario", "key", "seed"].into_iter().chain(names.iter().copied()).map(String::from);
    let mut out = csv_line(header);
    for (job, parameters) in listed(plan).zip(&rows) {
        let key = if plan.search_of(job.index).is_some() { String::new() } else { job.key.clone() };
        let own = [job.run.name.clone(), key, job.run.scenario.seed.to_string()];
        let value =
            |name: &&str| parameters.iter().find(|(n, _)| n == name).map_or(String::new(), |(_, v)| v.to_string());
        out += &csv_line(own.into_iter().chain(names.iter().map(value)));
    }
    out
}
