//! The chart of speed against accuracy as files: `chart.csv`, `chart.json`, `chart.svg`, `chart.png`.

mod json;
mod legend;
mod marks;
mod plot;
mod table;
#[cfg(test)]
mod tests;
mod words;

pub use json::write_chart_json;
pub use plot::{write_chart_png, write_chart_svg};
pub use table::{CHART_COLUMNS, write_chart_csv};
