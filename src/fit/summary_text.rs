//! The result of a fit as text for a terminal.

use crate::fit::results::{Agreement, DataResult, Estimate, ParameterResult, Status};
use crate::text::plural::plural;
use crate::text::text_table::{Alignment, TextTable};

/// Tables of the parameters, correlations and data, and the warnings.
pub fn summary(estimate: &Estimate, width: usize) -> String {
    let status = match estimate.status {
        Status::Converged => "converged",
        Status::Stalled => "stalled",
        Status::MaxIterations => "not converged",
    };
    let mut text = format!(
        "{}: {status} after {} and {}\n\n",
        estimate.fit,
        plural(estimate.iterations as usize, "iteration"),
        plural(estimate.runs, "run")
    );
    text += &parameters(estimate).render(width);
    if estimate.parameters.len() > 1 {
        text += "\ncorrelation\n";
        text += &correlation(estimate).render(width);
    }
    text += "\n";
    text += &data(estimate).render(width);
    let noise = if estimate.noise_given { "given noise" } else { "estimated noise" };
    text += &format!(
        "\nchi-square {:.6} with {} degrees of freedom, reduced {:.6}; {noise}{}\n",
        estimate.chi_square,
        estimate.degrees_of_freedom,
        estimate.reduced_chi_square,
        estimate.p_value.map_or_else(String::new, |p| format!(", p {p:.4}: {}", verdict(estimate.agreement)))
    );
    for warning in &estimate.warnings {
        text += &format!("warning: {warning}\n");
    }
    text
}

/// Whether data agree, as a word.
pub fn verdict(agreement: Agreement) -> &'static str {
    match agreement {
        Agreement::Agrees => "agrees",
        Agreement::Differs => "differs",
        Agreement::Untested => "-",
    }
}

/// A number with the digits that its standard error supports, and two more.
pub fn rounded(value: f64, error: Option<f64>) -> String {
    let digits = match error {
        Some(error) if error > 0.0 && value != 0.0 => {
            (crate::math::log10(value.abs() / error).floor() + 3.0).clamp(3.0, 15.0)
        }
        _ => 7.0,
    };
    let digits = digits as usize;
    let exponent = if value == 0.0 { 0 } else { crate::math::log10(value.abs()).floor() as i32 };
    match exponent {
        -4..=5 => format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize),
        _ => format!("{value:.*e}", digits - 1),
    }
}

/// A note on a parameter: at a bound, not determined.
pub fn note(parameter: &ParameterResult) -> String {
    match (parameter.at_bound, parameter.determined) {
        (Some(bound), _) => format!("at {bound}"),
        (None, false) => "not determined".to_owned(),
        (None, true) => String::new(),
    }
}

fn parameters(estimate: &Estimate) -> TextTable {
    use Alignment::{Left, Right};
    let level = format!("{} % from", 100.0 * estimate.confidence);
    let mut table = TextTable::new([
        ("parameter", Left),
        ("unit", Left),
        ("start", Right),
        ("estimate", Right),
        ("standard error", Right),
        (&level, Right),
        ("to", Right),
        ("", Left),
    ]);
    for p in &estimate.parameters {
        let end = |k: usize| p.interval.map_or_else(|| "-".to_owned(), |i| rounded(i[k], p.standard_error));
        table.push(vec![
            p.name.clone(),
            p.unit.clone(),
            p.start.to_string(),
            rounded(p.estimate, p.standard_error),
            p.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}")),
            end(0),
            end(1),
            note(p),
        ]);
    }
    table
}

fn correlation(estimate: &Estimate) -> TextTable {
    let numbers = (1..=estimate.parameters.len()).map(|k| (k.to_string(), Alignment::Right));
    let mut table = TextTable::new([("".to_owned(), Alignment::Left)].into_iter().chain(numbers));
    for (k, (parameter, row)) in estimate.parameters.iter().zip(&estimate.correlation).enumerate() {
        let cell = |c: &Option<f64>| c.map_or_else(|| "-".to_owned(), |c| format!("{c:.3}"));
        let mut cells = vec![format!("{} {}", k + 1, parameter.name)];
        cells.extend(row.iter().map(cell));
        table.push(cells);
    }
    table
}

fn data(estimate: &Estimate) -> TextTable {
    use Alignment::{Left, Right};
    let mut table = TextTable::new([
        ("data", Left),
        ("use", Left),
        ("signal", Left),
        ("values", Right),
        ("rms", Right),
        ("sigma", Right),
        ("rms/sigma", Right),
        ("p", Right),
        ("verdict", Left),
    ]);
    for data in &estimate.data {
        let DataResult { name, hold_out, values, rms, p_value, agreement, .. } = data;
        let role = if *hold_out { "held out" } else { "fitted" };
        let p = p_value.map_or_else(|| "-".to_owned(), |p| format!("{p:.4}"));
        let mut cells = vec![name.clone(), role.to_owned(), "all".to_owned(), values.to_string()];
        cells.extend(["".into(), "".into(), format!("{rms:.4}"), p, verdict(*agreement).to_owned()]);
        table.push(cells);
        for signal in &data.signals {
            let mut cells = vec![String::new(), String::new(), signal.column.clone(), signal.values.to_string()];
            let ratio = signal.rms / signal.sigma;
            cells.extend([format!("{:.3e}", signal.rms), format!("{:.3e}", signal.sigma), format!("{ratio:.4}")]);
            table.push(cells);
        }
    }
    table
}
