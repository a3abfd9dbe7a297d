//! What stands below the plot: one of several views behind a strip of tabs.

use super::action::{Action, Tab, ViewOptions};
use super::view_state::ViewState;
use super::{accuracy, branches, energy_well, event_list, paper, stability};
use egui::{Role, Ui, WidgetInfo};

/// The tabs in order.
pub const TABS: [(Tab, &str, &str); 6] = [
    (Tab::Events, "Events", "every jump so far"),
    (
        Tab::Stability,
        "Stability",
        "how far the next jump is, and which time steps GFMD survives",
    ),
    (
        Tab::Branches,
        "Branches",
        "every state of equilibrium, stable and unstable: why there are jumps",
    ),
    (
        Tab::EnergyWell,
        "Energy well",
        "the energy along the softest mode",
    ),
    (
        Tab::Accuracy,
        "Speed and accuracy",
        "what every method costs, and how far off it is",
    ),
    (
        Tab::Paper,
        "Paper",
        "the paper's figures beside their theory, and what the print got wrong",
    ),
];

/// The strip, and the chosen view in the rest of the space.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let narrow = ui.available_width() < 480.0;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (tab, name, what) in TABS {
            let chosen = state.view.tab == tab;
            let short = match tab {
                Tab::Accuracy if narrow => "Accuracy",
                Tab::EnergyWell if narrow => "Well",
                _ => name,
            };
            let response = ui.selectable_label(chosen, short).on_hover_text(what);
            response.widget_info(|| {
                WidgetInfo::selected(Role::Tab, true, chosen, format!("{name} tab"))
            });
            if response.clicked() && !chosen {
                actions.push(Action::SetView(ViewOptions { tab, ..state.view }));
            }
        }
    });
    match state.view.tab {
        Tab::Events => event_list::show(ui, state, actions),
        Tab::Stability => stability::show(ui, state, actions),
        Tab::Branches => branches::show(ui, state, actions),
        Tab::EnergyWell => energy_well::show(ui, state),
        Tab::Accuracy => accuracy::show(ui, state, actions),
        Tab::Paper => paper::show(ui, state, actions),
    }
}
