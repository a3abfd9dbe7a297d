//! Fig. 13: pull-off force and dissipated energy of a Hertzian tip against the mesh.

use super::scenes::{self, Order, TIP, Tip, TipDrive};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};
use crate::scene::Part;

pub(super) const ENTRY: Entry = Entry {
    number: 13,
    title: "A Hertzian tip: how fast force and loss converge",
    look_for: "The pull-off force is right within a few per cent on every mesh with mu_rho up to \
        0.7, the loss on none: it comes with the cube root of the mesh. From mu_rho = 1.5 on finer \
        meshes hardly help, since the range shrinks along with them.",
    scene: || scenes::tip(64, 0.7),
    compute,
};

/// The pull-off force under a load, which the paper does not show.
pub(super) const UNDER_LOAD: Entry = Entry {
    title: "A Hertzian tip under a load: how fast the pull-off force converges",
    look_for: "A load pulls the tip off where the loop driven by displacement has its largest \
        tension. On every mesh the two forces are one.",
    scene: || scenes::by_load(scenes::tip(64, 0.7)),
    compute: under_load,
    ..ENTRY
};

/// The loops at full size, or quick ones: mu_rho and meshes.
pub(super) fn list(task: &Task<'_>) -> [(f64, &'static [usize]); 5] {
    let fine: &[usize] = task.choose(&[32, 64], &[32, 64, 128, 256, 512]);
    let coarse: &[usize] = task.choose(&[32], &[32, 64, 128]);
    [
        (0.5, fine),
        (0.7, fine),
        (1.0, coarse),
        (1.5, coarse),
        (2.0, coarse),
    ]
}

const MARKS: [(Colour, Symbol); 5] = [
    (Colour::Blue, Symbol::Circle),
    (Colour::Teal, Symbol::Square),
    (Colour::Green, Symbol::Diamond),
    (Colour::Orange, Symbol::Triangle),
    (Colour::Red, Symbol::Cross),
];

/// The mesh on which the loops are also run otherwise.
const VARIED: usize = 64;

/// The source of the numbers that the meshes converge to.
const IMAGES: &str = "periodic JKR, in closed form";

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let orders = scenes::orders(&list(task), TipDrive::ToZeroLoad);
    let varied: &[f64] = task.choose(&[], &[0.5, 1.0, 1.5, 2.0]);
    let others = varied.iter().flat_map(|mu| otherwise(*mu));
    let all: Vec<Order> = orders.iter().copied().chain(others).collect();
    let mut live = scenes::run_all(&all, task)?;
    let others = live.split_off(orders.len());
    // Live where there is time for it, and kept elsewhere.
    let tips: Vec<Tip> = scenes::kept()
        .into_iter()
        .map(|kept| {
            live.iter()
                .find(|tip| same(tip, &kept))
                .cloned()
                .unwrap_or(kept)
        })
        .collect();
    let periodic = scenes::periodic();
    let references = [
        periodic.pull_off().force / TIP.pull_off_force(),
        periodic.dissipation() / TIP.dissipation(),
    ];
    let panels = vec![
        panel(
            "(a) pull-off force",
            "F_pull/F_{pull,JKR}",
            references[0],
            &tips,
            |tip| tip.pull_off,
        ),
        panel(
            "(b) dissipated energy",
            "V_hys/V_{hys,JKR}",
            references[1],
            &tips,
            |tip| tip.released,
        ),
    ];
    let mut findings = findings(&tips, references);
    findings.push(Finding::new(
        "largest deviation of a loop computed now from the one kept, in V_hys,JKR",
        deviation(&live),
        0.0,
        "assets/tips.csv",
        Some(0.01),
    ));
    for (mu, others) in varied.iter().zip(others.chunks_exact(2)) {
        let plain = live
            .iter()
            .find(|tip| (tip.mu_rho, tip.points) == (*mu, VARIED));
        findings.extend(
            plain
                .into_iter()
                .flat_map(|plain| differences(plain, others)),
        );
    }
    Ok(ENTRY.figure(panels, words(references, live.len(), tips.len()), findings))
}

/// The pull-off force alone: under a load the loss depends on how far the body is let fly.
fn under_load(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let tips = scenes::run_all(&scenes::orders(&list(task), TipDrive::Load), task)?;
    let reference = scenes::periodic().pull_off().force / TIP.pull_off_force();
    let panels = vec![panel(
        "pull-off force under a load",
        "F_pull/F_{pull,JKR}",
        reference,
        &tips,
        |tip| tip.pull_off,
    )];
    let words = format!(
        "The load that a tip bears before it lets go, over that of JKR, (3/2)πγR, against the mesh \
         over the critical contact radius a_c = {:.4} R. Black: JKR; grey: JKR with the cell's \
         periodic images ({reference:.4}). It is the largest tension of the same tip driven by \
         displacement, which then still holds on; what is lost under a load depends on how far \
         the body is let fly, and is not shown.",
        TIP.end_of_displacement().radius
    );
    Ok(UNDER_LOAD.figure(panels, words, pull_offs(&tips)))
}

/// Pull-off under a load against the largest tension of the loops driven by displacement, which
/// know it up to their increments.
pub(super) fn pull_offs(tips: &[Tip]) -> Vec<Finding> {
    let kept = scenes::kept();
    let driven = |tip: &Tip| kept.iter().find(|kept| same(tip, kept)).cloned();
    let finding = |tip: &Tip| {
        let what = format!(
            "F_pull under a load/F_pull,JKR at mu_rho = {}, n = {}",
            tip.mu_rho, tip.points
        );
        let largest = driven(tip)?.pull_off;
        let source = "largest tension of the loop driven by displacement";
        Some(Finding::new(
            what,
            tip.pull_off,
            largest,
            source,
            Some(1e-3),
        ))
    };
    tips.iter().filter_map(finding).collect()
}

/// The loop on that mesh otherwise: driven to u0 = 0, and on the whole cell.
fn otherwise(mu: f64) -> [Order; 2] {
    let plain = Order::new(mu, VARIED);
    [
        Order {
            drive: TipDrive::To(0.0),
            ..plain
        },
        Order {
            part: Part::Whole,
            ..plain
        },
    ]
}

/// True for loops with the same mu_rho on the same mesh.
fn same(a: &Tip, b: &Tip) -> bool {
    (a.mu_rho, a.points) == (b.mu_rho, b.points)
}

/// Largest deviation of the loss of a loop computed now from the one kept.
fn deviation(live: &[Tip]) -> f64 {
    scenes::kept()
        .iter()
        .flat_map(|kept| {
            live.iter()
                .filter(|tip| same(tip, kept))
                .map(|tip| (tip.released - kept.released).abs())
        })
        .fold(0.0, f64::max)
}

/// `live` of `all` loops were computed now.
fn words(references: [f64; 2], live: usize, all: usize) -> String {
    format!(
        "Largest tensile force and energy lost in a loop to zero load and back, over those of JKR, \
         against the mesh over the critical contact radius a_c = {:.4} R. Black: JKR; grey: JKR \
         with the cell's periodic images, which the meshes converge to ({:.4} and {:.4}). The loss \
         is the sum of the releases at the jumps. It depends on the range of the law and hardly on \
         the mesh as long as mu_rho is at most 0.7, and grows as slowly as the cube root of the \
         mesh. Computed now: {} of the {} loops. The others take more than an hour and are kept \
         with the program (assets/tips.csv, with the command that computes them). What is solved \
         on which mesh, and what that does, is said in Fig. 12.",
        TIP.end_of_displacement().radius,
        references[0],
        references[1],
        live,
        all,
    )
}

/// What the same loop loses otherwise: driven to u0 = 0 in place of zero load, and on the whole
/// cell.
fn differences(plain: &Tip, others: &[Tip]) -> Vec<Finding> {
    let ways = [
        ("driven to u0 = 0", "driven to zero load"),
        (
            "whole cell, apex on a point",
            "even quarter, apex between points",
        ),
    ];
    let finding = |(tip, (what, than)): (&Tip, (&str, &str))| {
        let quantity = format!(
            "V_hys/V_hys,JKR at mu_rho = {}, n = {VARIED}, {what}",
            plain.mu_rho
        );
        Finding::new(quantity, tip.released, plain.released, than, None)
    };
    others.iter().zip(ways).map(finding).collect()
}

fn panel(title: &str, y: &str, reference: f64, tips: &[Tip], pick: fn(&Tip) -> f64) -> Panel {
    let radius = TIP.end_of_displacement().radius;
    let line = |name: &str, colour, value: f64| {
        Series::line(
            name,
            Role::Theory,
            colour,
            [0.02, 1.0].map(|x| [x, value]).to_vec(),
        )
    };
    let mut series = vec![
        line("JKR", Colour::Ink, 1.0),
        line("JKR, periodic", Colour::Grey, reference),
    ];
    for (mu, (colour, symbol)) in [0.5, 0.7, 1.0, 1.5, 2.0].into_iter().zip(MARKS) {
        let mine = tips.iter().filter(|tip| tip.mu_rho == mu);
        let points = mine
            .map(|tip| [1.0 / (tip.points as f64 * radius), pick(tip)])
            .collect();
        series.push(Series::symbols(
            &format!("mu_rho = {mu}"),
            symbol,
            colour,
            points,
        ));
    }
    Panel {
        title: title.to_owned(),
        x: Axis::logarithmic("Δa/a_c"),
        y: Axis::linear(y),
        series,
        ..Panel::default()
    }
}

fn findings(tips: &[Tip], references: [f64; 2]) -> Vec<Finding> {
    let mut list = closed_form(references);
    list.extend(energy(tips));
    for mu in [0.5, 0.7, 1.0] {
        list.extend(convergence(tips, mu, references));
    }
    list.extend(jumps_of_the_mesh(tips));
    list.extend(twins(tips));
    list
}

/// JKR in the cell, in closed form against boundary elements.
fn closed_form([force, loss]: [f64; 2]) -> Vec<Finding> {
    vec![
        Finding::new(
            "F_pull of JKR in the cell over that without images",
            force,
            1.0041178,
            "boundary elements",
            Some(1e-6),
        ),
        Finding::new(
            "V_hys of JKR in the cell over that without images",
            loss,
            0.8210066,
            "boundary elements",
            Some(1e-6),
        ),
    ]
}

/// Whether the loops and their jumps conserve energy.
fn energy(tips: &[Tip]) -> Vec<Finding> {
    let worst = tips
        .iter()
        .map(|tip| (tip.integral - tip.released).abs())
        .fold(0.0, f64::max);
    let least = tips
        .iter()
        .flat_map(|tip| &tip.jumps)
        .fold(0.0, |least: f64, jump| least.min(*jump));
    vec![
        Finding::new(
            "largest |loop integral - sum of releases|/V_{hys,JKR}",
            worst,
            0.0,
            "energy ledger",
            Some(1e-3),
        ),
        Finding::new(
            "most negative release/V_{hys,JKR}",
            least,
            0.0,
            "no jump gains energy",
            Some(0.0),
        ),
    ]
}

fn with_mu_rho(tips: &[Tip], mu: f64) -> Vec<&Tip> {
    tips.iter().filter(|tip| tip.mu_rho == mu).collect()
}

/// Force and loss at one mu_rho: on the finest mesh, and how they converge to `references`.
fn convergence(tips: &[Tip], mu: f64, references: [f64; 2]) -> Vec<Finding> {
    let [force, loss] = references;
    let mine = with_mu_rho(tips, mu);
    let Some(finest) = mine.last() else {
        return Vec::new();
    };
    let at = format!("at mu_rho = {mu}, n = {}", finest.points);
    let mut list = vec![
        Finding::new(
            format!("F_pull/F_pull,JKR {at}"),
            finest.pull_off,
            force,
            IMAGES,
            None,
        ),
        Finding::new(
            format!("V_hys/V_hys,JKR {at}"),
            finest.released,
            loss,
            IMAGES,
            None,
        ),
    ];
    if let [.., a, b, c] = mine[..] {
        list.extend(orders([a, b, c], references, &at));
    }
    list
}

/// Orders of convergence and the loss at zero range, from the three finest meshes.
fn orders(tips: [&Tip; 3], [force, loss]: [f64; 2], at: &str) -> Vec<Finding> {
    let [_, b, c] = tips;
    let order =
        |pick: fn(&Tip) -> f64, limit: f64| ((limit - pick(b)) / (limit - pick(c))).abs().log2();
    let [straight, bent] = extrapolated(tips);
    vec![
        Finding::new(
            format!("order of F_pull in the mesh {at}"),
            order(|tip| tip.pull_off, force),
            1.0,
            "linear, as the abstract says",
            None,
        ),
        Finding::new(
            format!("order of V_hys in the mesh {at}"),
            order(|tip| tip.released, loss),
            1.0 / 3.0,
            "cube root, as in Eq. 30d",
            None,
        ),
        Finding::new(
            format!("V_hys/V_hys,JKR, linear in range^(2/3) {at}"),
            straight,
            loss,
            IMAGES,
            None,
        ),
        Finding::new(
            format!("V_hys/V_hys,JKR, quadratic in range^(2/3) {at}"),
            bent,
            loss,
            IMAGES,
            None,
        ),
    ]
}

fn jumps_of_the_mesh(tips: &[Tip]) -> Vec<Finding> {
    let mut list = Vec::new();
    for tip in tips {
        let (mu, n) = (tip.mu_rho, tip.points);
        let jumps = tip.mesh_jumps();
        let (expected, tolerance) = (0.0, (mu == 0.5).then_some(0.0));
        list.push(Finding::new(
            format!("jumps of the mesh at mu_rho = {mu}, n = {n}"),
            jumps.len() as f64,
            expected,
            "continuum",
            tolerance,
        ));
        if mu > 0.5 {
            list.push(Finding::new(
                format!("their share of V_hys,JKR at mu_rho = {mu}, n = {n}"),
                jumps.iter().sum(),
                expected,
                "continuum",
                None,
            ));
        }
    }
    list
}

/// The loss at mu_rho = 0.5 and 0.7 where the ranges are nearly the same.
fn twins(tips: &[Tip]) -> Vec<Finding> {
    let mut list = Vec::new();
    let twins = with_mu_rho(tips, 0.5)
        .into_iter()
        .flat_map(|a| with_mu_rho(tips, 0.7).into_iter().map(move |b| (a, b)));
    for (a, b) in twins.filter(|(a, b)| (a.range / b.range - 1.0).abs() < 0.03 && a.released > 0.0)
    {
        let quantity = format!("V_hys/V_hys,JKR at mu_rho = 0.5, n = {}", a.points);
        list.push(Finding::new(
            quantity,
            a.released,
            b.released,
            format!("mu_rho = 0.7, n = {}: nearly the same range", b.points),
            Some(0.01),
        ));
    }
    list
}

/// The loss at zero range by the line through the last two and the parabola through all three, in
/// range^(2/3).
fn extrapolated(tips: [&Tip; 3]) -> [f64; 2] {
    let [[x0, v0], [x1, v1], [x2, v2]] = tips.map(|tip| [tip.range.powf(2.0 / 3.0), tip.released]);
    let (slope, before) = ((v2 - v1) / (x2 - x1), (v1 - v0) / (x1 - x0));
    let bend = (slope - before) / (x2 - x0);
    [v2 - slope * x2, v2 - slope * x2 + bend * x1 * x2]
}
