//! Columns of a history. Further ones are metrics, under the names of the summary, as 64-bit reals.

/// Format version of a history. Further columns do not raise it.
pub const HISTORY_SCHEMA: u32 = 1;

/// Format version.
pub(super) const SCHEMA: &str = "schema";
/// Digest of the result that a row belongs to.
pub(super) const RESULT: &str = "result";
/// When the result was written, s since 1970.
pub(super) const RECORDED: &str = "recorded_unix_s";
/// Label that the user gave the result.
pub(super) const LABEL: &str = "label";
/// Program and version.
pub(super) const PROGRAM: &str = "program";
/// Swept parameters: a JSON object of texts.
pub(super) const PARAMETERS: &str = "parameters";
/// Results of the claims of the scenario as JSON, in the first row of a scenario.
pub(super) const CLAIMS: &str = "claims";

/// Columns of text, in their order.
pub(super) const TEXTS: [&str; 11] =
    [RESULT, LABEL, PROGRAM, "scenario", "key", "outcome", "method", "integrator", "seed", PARAMETERS, CLAIMS];

/// Columns that the summary has too, and a comparison needs.
pub(super) const IDENTITY: [&str; 6] = ["scenario", "key", "outcome", "method", "integrator", "seed"];
