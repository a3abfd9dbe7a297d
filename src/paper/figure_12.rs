//! Fig. 12: force against displacement of a Hertzian tip.

use super::figure_13;
use super::scenes::{self, TIP, Tip, TipDrive};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::physics::theory::jkr::Contact;
use crate::physics::theory::tabor_of_mesh;
use crate::plot::panel::{Axis, Colour, Panel, Role, Series};
use crate::plot::scale::steps;

pub(super) const ENTRY: Entry = Entry {
    number: 12,
    title: "A Hertzian tip: force against displacement",
    look_for: "At mu_rho = 0.5 there are two jumps, into contact and out of it, and finer meshes \
        let the tip come closer before it is pulled in. From mu_rho = 1 on the edge of the contact \
        moves point by point, and at 1.5 and 2 the sawtooth is all there is.",
    scene: || scenes::tip(128, 0.5),
    compute: |task| driven(&ENTRY, task, TipDrive::ToZeroLoad),
};

/// The same under a load, which the paper does not show.
pub(super) const UNDER_LOAD: Entry = Entry {
    title: "A Hertzian tip under a load: force against displacement",
    look_for: "Two jumps at a constant force: into contact at hardly any load, and off where the \
        driven loop has its largest tension. Between the two ends of the load's branch the driven \
        tip still holds on.",
    scene: || scenes::by_load(scenes::tip(128, 0.5)),
    compute: |task| driven(&UNDER_LOAD, task, TipDrive::Load),
    ..ENTRY
};

/// u0 of a tip that is far off (R).
const FAR: f64 = 0.05;
/// Of each diagram.
const MU_RHO: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
/// Points of a theory line.
const POINTS: usize = 200;

const COLOURS: [Colour; 5] = [
    Colour::Orange,
    Colour::Green,
    Colour::Blue,
    Colour::Red,
    Colour::Teal,
];

fn driven(entry: &Entry, task: &mut Task<'_>, drive: TipDrive) -> Result<Figure, Stopped> {
    let all = figure_13::list(task).into_iter();
    let list: Vec<_> = all.filter(|(mu, _)| MU_RHO.contains(mu)).collect();
    let tips = scenes::run_all(&scenes::orders(&list, drive), task)?;
    let panels = MU_RHO.iter().zip("abcd".chars()).map(|(mu, letter)| {
        let loops: Vec<&Tip> = tips.iter().filter(|tip| tip.mu_rho == *mu).collect();
        panel(&format!("({letter}) mu_rho = {mu}"), &loops, drive)
    });
    let by = match drive {
        TipDrive::Load => {
            "by a load, from pull-off to a little compression and back: into contact and out of it \
             the body jumps at a constant force"
        }
        _ => "by displacement to zero load and back",
    };
    let words = format!(
        "Force over the pull-off force of JKR, positive in compression, against the height \
        u₀ of the undeformed surface above the apex, driven {by} \
        (L = R, γ = 0.5859e-3 E*R). Black: JKR; grey: the same with the periodic images of the \
        cell, in closed form. Up to mu_rho = 0.7 an even quarter of the cell is solved, with all \
        other modes watched; above, the quarter is held mirror-symmetric, so that single points \
        jump in fours or eights, and their jumps are located within a fortieth of the range. At \
        mu_rho = 1.5 and 2 the loops also depend on that, and on how far the tip is driven, as the \
        paper says: Fig. 13 lists by how much."
    );
    let findings = match drive {
        TipDrive::Load => figure_13::pull_offs(&tips),
        _ => findings(&tips),
    };
    Ok(entry.figure(panels.collect(), words, findings))
}

fn panel(title: &str, loops: &[&Tip], drive: TipDrive) -> Panel {
    let (jkr, images) = theory(drive);
    let mut series = vec![
        Series::line("JKR", Role::Theory, Colour::Ink, jkr),
        Series::line("JKR, periodic", Role::Theory, Colour::Grey, images),
    ];
    for (tip, colour) in loops.iter().zip(COLOURS) {
        let line = |name: String, points: &[[f64; 2]]| {
            Series::line(&name, Role::Simulation, colour, points.to_vec())
        };
        series.push(line(format!("n = {}", tip.points), &tip.approach));
        series.push(line(String::new(), &tip.retraction));
    }
    // Under a load the body flies far off.
    let held = |p: &&[f64; 2]| p[1] < -0.1 && drive != TipDrive::Load;
    let curves = loops.iter().flat_map(|tip| &tip.retraction).filter(held);
    let end = curves.fold(0.013, |most: f64, p| most.max(p[0]));
    let mut y = Axis::linear("force F/F_{pull,JKR}");
    if drive == TipDrive::Load {
        let largest = loops
            .iter()
            .fold(1.0, |most: f64, tip| most.max(tip.pull_off));
        y = y.from_to(-1.1 * largest, 0.15);
    }
    Panel {
        title: title.to_owned(),
        x: Axis::linear("displacement u₀/R").from_to(-0.0145, end + 0.002),
        y,
        series,
        ..Panel::default()
    }
}

/// The two loops without range, the second with images: away from contact, the touch, the branch in
/// contact, the snap-off.
fn theory(drive: TipDrive) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let (far, pull, by_load) = (FAR, TIP.pull_off_force(), drive == TipDrive::Load);
    let path = |[touch, end]: [f64; 2], contact: &dyn Fn(f64) -> [f64; 2]| {
        // A little into compression.
        let last = 0.206;
        let branch = steps(end, last, POINTS).map(contact);
        let away = [
            [far, 0.0],
            [if by_load { far } else { 0.0 }, 0.0],
            contact(touch),
            [f64::NAN; 2],
            if by_load {
                [far, contact(end)[1]]
            } else {
                [contact(end)[0], 0.0]
            },
        ];
        away.into_iter().chain(branch).collect::<Vec<_>>()
    };
    let periodic = scenes::periodic();
    let drawn = |state: Contact| [state.mean_displacement, -state.force / pull];
    let ends = if by_load {
        [
            [TIP.zero_load().radius, TIP.end_under_force().radius],
            [periodic.zero_load().radius, periodic.pull_off().radius],
        ]
    } else {
        [
            [TIP.touch().radius, TIP.end_of_displacement().radius],
            [
                periodic.touch().radius,
                periodic.end_of_displacement().radius,
            ],
        ]
    };
    (
        path(ends[0], &|a| drawn(TIP.contact(a))),
        path(ends[1], &|a| drawn(periodic.contact(a))),
    )
}

fn findings(tips: &[Tip]) -> Vec<Finding> {
    let mut list = vec![Finding::new(
        "mu_T/(mu_rho sqrt n)",
        tabor_of_mesh(1.0, TIP.radius, TIP.surface_energy, 1.0),
        0.579,
        "printed after Eq. 32",
        Some(5e-4),
    )];
    for tip in tips.iter().filter(|tip| tip.mu_rho == 0.5) {
        list.push(Finding::new(
            format!("jumps at mu_rho = 0.5, n = {}", tip.points),
            tip.jumps.len() as f64,
            if tip.points < 64 { 0.0 } else { 2.0 },
            "collective jumps only, none on the coarsest mesh",
            Some(0.0),
        ));
    }
    for tip in tips {
        list.push(Finding::new(
            format!(
                "loop integral over V_hys of JKR at mu_rho = {}, n = {}",
                tip.mu_rho, tip.points
            ),
            tip.integral,
            tip.released,
            "sum of the releases",
            Some(1e-3),
        ));
    }
    list
}
