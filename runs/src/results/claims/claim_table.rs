//! The table of claims for a terminal.

use crate::results::claims::verdict::ClaimVerdict;
use crate::text::text_table::{Alignment, TextTable};
use crate::text::visible::visible;

/// A line per claim: verdict, name, statement, estimate with bounds, and runs. Empty without claims.
pub fn claim_table(claims: &[ClaimVerdict], width: usize) -> String {
    if claims.is_empty() {
        return String::new();
    }
    let columns = [
        ("verdict", Alignment::Right),
        ("claim", Alignment::Left),
        ("statement", Alignment::Left),
        ("measured (bounds)", Alignment::Right),
        ("counted", Alignment::Right),
    ];
    let mut table = TextTable::new(columns);
    for claim in claims {
        table.push(vec![
            claim.verdict.name().to_owned(),
            visible(&format!("{}: {}", claim.scenario, claim.name())).into_owned(),
            visible(&claim.statement).into_owned(),
            claim.interval(),
            claim.units(),
        ]);
    }
    table.render(width)
}
