//! The chart of speed against accuracy as data: `chart.csv` and `chart.json`.

mod json;
mod table;
#[cfg(test)]
pub(super) mod tests;

pub use json::write_chart_json;
pub use table::{CHART_COLUMNS, write_chart_csv};
