//! Table 1: the mesh number mu_rho that other models of cohesive zones use without saying so.

use super::TableEntry;
use super::figure::{Finding, Table};
use super::task::{Stopped, Task};
use crate::physics::mesh_rule;
use std::f64::consts::{FRAC_1_PI, PI};

pub(super) const ENTRY: TableEntry =
    TableEntry { number: 1, title: "Values of mu_rho implied by models of the cohesive zone", compute };

/// M of each model's length of the cohesive zone, l_cz = M E* gamma/sigma_max^2, in the order of the table.
const ZONES: [(&str, f64); 6] = [
    ("pi/8", PI / 8.0),
    ("1", 1.0),
    ("1/pi", FRAC_1_PI),
    ("9 pi/32", 9.0 * PI / 32.0),
    ("2/(3 pi)", 2.0 / 3.0 * FRAC_1_PI),
    ("0.47", 0.47),
];

fn compute(task: &mut Task<'_>) -> Result<Table, Stopped> {
    task.tell(0.0, "Table 1")?;
    let models = || mesh_rule::TABLE_1.iter().zip(ZONES);
    let row = |((model, year, printed), (word, zone)): (&(&str, u16, f64), (&str, f64))| {
        vec![
            (*model).to_owned(),
            year.to_string(),
            word.to_owned(),
            format!("{:.4}", mesh_rule::mu_rho_of_zone(zone)),
            printed.to_string(),
        ]
    };
    let finding = |((model, _, printed), (word, zone)): (&(&str, u16, f64), (&str, f64))| Finding {
        quantity: format!("mu_rho of {model}, 1/(2 sqrt(M)) with M = {word}"),
        found: mesh_rule::mu_rho_of_zone(zone),
        expected: *printed,
        source: "printed in Table 1".to_owned(),
        tolerance: Some(half_digit(*printed)),
    };
    Ok(Table {
        number: 1,
        title: ENTRY.title.to_owned(),
        columns: ["model", "year", "M", "mu_rho = 1/(2 sqrt(M))", "printed"].map(str::to_owned).to_vec(),
        rows: models().map(row).collect(),
        words: "Each model sets the length of its cohesive zone to M E* γ/σ_max². For the Morse law that is a range \
                ρ = sqrt(M γ Δa/E*) on a mesh of spacing Δa, and so μ_ρ = 1/(2 sqrt(M)). All six values of the print follow from the \
                published M."
            .to_owned(),
        findings: models().map(finding).collect(),
    })
}

/// Half a unit of the last digit that is printed: what rounding leaves open.
fn half_digit(printed: f64) -> f64 {
    let decimals = printed.to_string().split_once('.').map_or(0, |(_, digits)| digits.len());
    0.5 * 0.1f64.powi(decimals as i32)
}
