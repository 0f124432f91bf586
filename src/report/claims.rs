//! The section on claims: their results, and a picture of each.

use crate::files::RecordError;
use crate::report::claim_plot::claim_plot;
use crate::report::table::{Cell, Head, MAX_ROWS, Part, Table};
use crate::results::claims::{ClaimVerdict, Judgement};
use crate::text::plural::plural;
use serde::Serialize;

/// Largest number of pictures.
const MAX_PICTURES: usize = 24;

/// The section.
#[derive(Debug, Default, Serialize)]
pub(super) struct Section {
    pub table: Table,
    pub pictures: Vec<Picture>,
    /// Note on omitted pictures.
    pub more: String,
}

/// The picture of a claim.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub name: String,
    pub verdict: &'static str,
    pub summary: String,
    pub svg: String,
}

pub(super) fn section(claims: &[ClaimVerdict]) -> Result<Section, RecordError> {
    if claims.is_empty() {
        return Ok(Section::default());
    }
    // Claims that do not hold take precedence where not all are drawn.
    let mut drawn: Vec<&ClaimVerdict> = claims.iter().filter(|claim| !claim.trace.is_empty()).collect();
    let all = drawn.len();
    drawn.sort_by_key(|claim| claim.verdict == Judgement::Holds);
    drawn.truncate(MAX_PICTURES);
    drawn.sort_by_key(|claim| claims.iter().position(|other| std::ptr::eq(*claim, other)));
    let picture = |claim: &ClaimVerdict| {
        Ok::<_, RecordError>(Picture {
            name: format!("{}: {}", claim.scenario, claim.name()),
            verdict: claim.verdict.name(),
            summary: claim.summary(),
            svg: claim_plot(claim)?,
        })
    };
    let pictures = drawn.into_iter().map(picture).collect::<Result<Vec<_>, _>>()?;
    let more = match all - pictures.len() {
        0 => String::new(),
        n => format!("{} without a picture here", plural(n, "more claim")),
    };
    Ok(Section { table: table(claims), pictures, more })
}

fn table(claims: &[ClaimVerdict]) -> Table {
    let head = vec![
        Head::text("verdict"),
        Head::text("scenario"),
        Head::text("claim"),
        Head::text("statement"),
        Head::number("measured", ""),
        Head::number("from", ""),
        Head::number("to", ""),
        Head::number("confidence", ""),
        Head::number("counted", ""),
        Head::number("without value", ""),
    ];
    let hidden = claims.len().saturating_sub(MAX_ROWS);
    Table {
        head,
        parts: vec![Part { title: String::new(), rows: claims.iter().take(MAX_ROWS).map(row).collect() }],
        more: if hidden == 0 { String::new() } else { format!("{} in claims.json", plural(hidden, "more claim")) },
    }
}

fn row(claim: &ClaimVerdict) -> Vec<Cell> {
    let class = if claim.verdict == Judgement::Fails { "bad" } else { "" };
    vec![
        Cell { text: claim.verdict.name().into(), class },
        Cell::text(claim.scenario.clone()),
        Cell::text(claim.name()),
        Cell::text(claim.statement.clone()),
        Cell::number(claim.estimate),
        Cell::number(claim.lower),
        Cell::number(claim.upper),
        Cell { text: claim.confidence.to_string(), class: "n" },
        Cell { text: claim.units(), class: "n" },
        Cell::count(claim.without_value as u64),
    ]
}
