//! The table of searches for a terminal.

use crate::results::searches::search_result::{SearchResult, SearchVerdict};
use crate::text::text_table::{Alignment, TextTable};
use crate::text::visible::visible;

/// A line per search: verdict, number of runs, what was found, over which keys, and scenario with swept
/// values; then a line for each without a result. Empty without searches.
pub fn search_table(searches: &[SearchResult], width: usize) -> String {
    if searches.is_empty() {
        return String::new();
    }
    let columns = [
        ("search", Alignment::Right),
        ("runs", Alignment::Right),
        ("found", Alignment::Left),
        ("over", Alignment::Left),
        ("of", Alignment::Left),
        ("at", Alignment::Left),
    ];
    let mut table = TextTable::new(columns);
    for search in searches {
        let side = match search.interval.as_ref().map(|interval| interval.holds_above) {
            Some(true) => " above",
            Some(false) => " below",
            None => "",
        };
        table.push(vec![
            search.verdict.name().to_owned(),
            search.runs.to_string(),
            visible(&search.found()).into_owned(),
            visible(&search.keys.join(", ")).into_owned(),
            visible(&format!("{}{side}", search.goal())).into_owned(),
            visible(format!("{} {}", search.scenario, search.label).trim_end()).into_owned(),
        ]);
    }
    let mut out = table.render(width);
    for search in searches.iter().filter(|search| search.verdict != SearchVerdict::Found) {
        let name = format!("{} {}", search.scenario, search.label);
        out += &format!("{}: {}\n", visible(name.trim_end()), visible(&search.summary()));
    }
    out
}
