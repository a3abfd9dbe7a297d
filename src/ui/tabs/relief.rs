//! The surface of the body in three dimensions over the ground, turned by a drag.

use super::{Tab, Title};
use crate::physics::pattern::rolled;
use crate::plot::scale;
use crate::ui::action::Action;
use crate::ui::gap_picture;
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::described;
use crate::worker::protocol::Frame;
use egui::{
    Color32, CursorIcon, Id, Mesh, Painter, Pos2, Rect, RichText, Sense, Ui, Vec2, pos2, vec2,
};
use ndarray::Array2;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// Most squares along a side: more are not seen, and take long to draw.
const SQUARES: usize = 64;
/// How high the last colour of the map stands, in sides of the cell.
const HEIGHT: f64 = 0.4;
/// Radians for each point of a drag, and for each command.
const DRAG: f32 = 0.01;
const TURN: f32 = FRAC_PI_2 / 6.0;
/// Least angle above the horizon: from below there is nothing to be seen.
const LEAST: f32 = 0.1;
/// Where the light comes from (along x, along y, from above), and what shade is left without it.
const LIGHT: [f32; 3] = [-0.48, -0.6, 0.64];
const SHADE: f32 = 0.45;

/// The tab.
#[derive(Default)]
pub struct Relief {
    view: View,
    shown: Option<Shown>,
}

/// From where the cell is seen (radians): how far it is turned, and how high the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct View {
    turn: f32,
    lift: f32,
}

impl Default for View {
    fn default() -> Self {
        Self {
            turn: 0.5,
            lift: 0.6,
        }
    }
}

impl View {
    fn turned(self, [turn, lift]: [f32; 2]) -> Self {
        Self {
            turn: self.turn + turn,
            lift: (self.lift + lift).clamp(LEAST, FRAC_PI_2),
        }
    }

    /// Where a place of the cell (from its middle, in sides of it) is seen: to the right, upwards,
    /// and how far away.
    fn seen(self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let ((s, c), (up, along)) = (self.turn.sin_cos(), self.lift.sin_cos());
        let (across, away) = (x * c - y * s, x * s + y * c);
        [across, z * along + away * up, away * along - z * up]
    }
}

/// A picture of the surface with the pattern in its middle where the map has it there.
struct Shown {
    frame: Arc<Frame>,
    centred: bool,
    gap: Array2<f64>,
}

/// A surface over the squares of the cell: how many of them along y and x, and the height (sides of
/// the cell) and the colour at the corners.
struct Sheet<Z, C> {
    squares: [usize; 2],
    height: Z,
    colour: C,
}

impl<Z: Fn(usize, usize) -> f32, C: Fn(usize, usize) -> Color32> Sheet<Z, C> {
    /// Draws it, what is farther away first, with the middle of the cell at `middle` and its sides so
    /// long.
    fn draw(&self, painter: &Painter, view: View, (middle, side): (Pos2, f32)) {
        let [rows, columns] = self.squares;
        let place = |j: usize, i: usize| {
            let share = |k: usize, n: usize| k as f32 / n as f32 - 0.5;
            let z = (self.height)(j, i);
            view.seen([share(i, columns), share(j, rows), z])
        };
        let mut mesh = Mesh::default();
        let mut away = Vec::new();
        for j in 0..=rows {
            for i in 0..=columns {
                let [right, up, far] = place(j, i);
                let shade = 1.0 - self.lit(j, i);
                let ink = (self.colour)(j, i).lerp_to_gamma(Color32::BLACK, shade);
                mesh.colored_vertex(middle + side * vec2(right, -up), ink);
                away.push(far);
            }
        }
        let corner = |j: usize, i: usize| j * (columns + 1) + i;
        let mut squares: Vec<[usize; 2]> = (0..rows)
            .flat_map(|j| (0..columns).map(move |i| [j, i]))
            .collect();
        let far = |[j, i]: &[usize; 2]| away[corner(*j, *i)] + away[corner(j + 1, i + 1)];
        squares.sort_by(|a, b| far(b).total_cmp(&far(a)));
        for [j, i] in squares {
            let [a, b] = [corner(j, i), corner(j, i + 1)].map(|k| k as u32);
            let [c, d] = [corner(j + 1, i), corner(j + 1, i + 1)].map(|k| k as u32);
            mesh.add_triangle(a, b, c);
            mesh.add_triangle(b, c, d);
        }
        painter.add(mesh);
    }

    /// How much light falls on a corner, 0 to 1.
    fn lit(&self, j: usize, i: usize) -> f32 {
        let [rows, columns] = self.squares;
        let slope = |a: [usize; 2], b: [usize; 2], n: usize, steps: usize| {
            ((self.height)(b[0], b[1]) - (self.height)(a[0], a[1])) * n as f32 / steps as f32
        };
        let (left, right) = (i.saturating_sub(1), (i + 1).min(columns));
        let (below, above) = (j.saturating_sub(1), (j + 1).min(rows));
        let x = slope([j, left], [j, right], columns, right - left);
        let y = slope([below, i], [above, i], rows, above - below);
        let length = (x * x + y * y + 1.0).sqrt();
        let light = (LIGHT[2] - LIGHT[0] * x - LIGHT[1] * y) / length;
        SHADE + (1.0 - SHADE) * light.clamp(0.0, 1.0)
    }
}

impl Tab for Relief {
    fn title(&self) -> Title {
        Title {
            tall: true,
            ..Title::new("3D", "the surface in three dimensions")
        }
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        self.take(state);
        let Some(shown) = self.shown.as_ref().filter(|_| !state.is_waiting()) else {
            ui.label("Waiting for the solver.");
            return;
        };
        let top = scale::gap_scale(&state.scene, &state.model);
        let stretch = HEIGHT * state.model.grid.length / top;
        let words = format!("Heights are stretched {stretch:.0} times. A drag turns the cell.");
        ui.label(RichText::new(words).small());
        let (_, area) = ui.allocate_space(ui.available_size() - vec2(0.0, 4.0));
        let response = ui.interact(area, Id::unique("relief"), Sense::drag());
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        // The way to the cell turns nothing.
        let moved = if ui.input(|input| input.pointer.any_pressed()) {
            Vec2::ZERO
        } else {
            response.drag_delta()
        };
        self.view = self.view.turned([DRAG * moved.x, DRAG * moved.y]);
        let View { turn, lift } = self.view;
        let sentence = format!(
            "The surface in three dimensions, turned by {:.0} degrees, seen from {:.0} above",
            turn.to_degrees().rem_euclid(360.0),
            lift.to_degrees()
        );
        described(&response, &sentence);
        let painter = ui.painter().with_clip_rect(area);
        draw(&painter, state, shown, (self.view, area));
    }

    fn commands(&self) -> Vec<String> {
        TURNS.map(|(name, _)| format!("3D: {name}")).to_vec()
    }

    fn command(&mut self, index: usize) {
        if let Some((_, by)) = TURNS.get(index) {
            self.view = self.view.turned(*by);
        }
    }

    fn restore(&mut self) {
        self.view = View::default();
    }
}

/// The commands, with what they turn.
const TURNS: [(&str, [f32; 2]); 4] = [
    ("turn left", [-TURN, 0.0]),
    ("turn right", [TURN, 0.0]),
    ("look from higher up", [0.0, TURN]),
    ("look from lower down", [0.0, -TURN]),
];

impl Relief {
    /// Takes the picture that map and profile show.
    fn take(&mut self, state: &ViewState) {
        let centred = state.view.centred;
        let Some(frame) = state.pictured() else {
            self.shown = None;
            return;
        };
        let same = |shown: &Shown| Arc::ptr_eq(&shown.frame, frame) && shown.centred == centred;
        if self.shown.as_ref().is_some_and(same) {
            return;
        }
        let island = gap_picture::island(frame, state.model.law.contact_gap(), None);
        let (dy, dx) = gap_picture::roll(&state.view, &state.model, &frame.gap, island);
        self.shown = Some(Shown {
            frame: frame.clone(),
            centred,
            gap: rolled(&frame.gap, dy, dx),
        });
    }
}

/// Draws ground and surface.
fn draw(painter: &Painter, state: &ViewState, shown: &Shown, (view, area): (View, Rect)) {
    let (gap, colours) = (&shown.gap, state.view.colours);
    let (ny, nx) = gap.dim();
    let squares = [ny, nx].map(|n| if n == 1 { SQUARES } else { n.min(SQUARES) });
    // Periodic: the first point comes again at the other edge.
    let index = |k: usize, squares: usize, n: usize| k * n / squares % n;
    let at = |j: usize, i: usize| (index(j, squares[0], ny), index(i, squares[1], nx));
    let top = scale::gap_scale(&state.scene, &state.model);
    let high = |z: f64| (HEIGHT * z / top) as f32;
    let ready = state.run.ready.as_ref();
    let ground = ready.and_then(|ready| ready.height.as_ref());
    let ground = ground.filter(|height| height.dim() == gap.dim());
    let rigid = |j: usize, i: usize| ground.map_or(0.0, |height| height[at(j, i)]);
    // As large as fits, however it is turned.
    let (up, along) = view.lift.sin_cos();
    let wide = std::f32::consts::SQRT_2;
    let tall = wide * up + HEIGHT as f32 * along;
    let side = (area.width() / wide).min(area.height() / tall);
    let middle = pos2(
        area.center().x,
        area.center().y + 0.5 * HEIGHT as f32 * along * side,
    );
    let grey = theme::palette_on(crate::plot::style::Ground::Light).indenter;
    Sheet {
        squares,
        height: |j: usize, i: usize| high(rigid(j, i)),
        colour: |_: usize, _: usize| grey,
    }
    .draw(painter, view, (middle, side));
    Sheet {
        squares,
        height: |j: usize, i: usize| high(gap[at(j, i)] + rigid(j, i)),
        colour: |j: usize, i: usize| theme::rgb(colours.at(gap[at(j, i)] / top)),
    }
    .draw(painter, view, (middle, side));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_straight_above_the_cell_is_seen_as_on_the_map() {
        let view = View {
            turn: 0.0,
            lift: FRAC_PI_2,
        };
        for place in [[0.3, -0.2, 0.1], [-0.5, 0.5, 0.4]] {
            let [right, up, away] = view.seen(place);
            let [x, y, z] = place;
            assert!((right - x).abs() + (up - y).abs() < 1e-6);
            assert!((away + z).abs() < 1e-6, "what is higher is nearer");
        }
    }

    #[test]
    fn a_turn_keeps_distances_and_a_full_one_everything() {
        let view = View {
            turn: 0.7,
            lift: 0.4,
        };
        let place = [0.3, -0.2, 0.1];
        let length = |p: [f32; 3]| p.iter().map(|x| x * x).sum::<f32>();
        assert!((length(view.seen(place)) - length(place)).abs() < 1e-6);
        let round = view.turned([std::f32::consts::TAU, 0.0]).seen(place);
        let off = round
            .iter()
            .zip(view.seen(place))
            .map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f32::max) < 1e-5);
        assert_eq!(view.turned([0.0, 9.0]).lift, FRAC_PI_2);
        assert_eq!(view.turned([0.0, -9.0]).lift, LEAST);
    }

    #[test]
    fn what_faces_the_light_is_brighter_than_what_turns_away_from_it() {
        let valley = Sheet {
            squares: [8, 8],
            height: |_: usize, i: usize| 0.1 * (i as f32 - 4.0).abs(),
            colour: |_: usize, _: usize| Color32::WHITE,
        };
        // A valley: its right side faces the left, from where the light comes.
        assert!(valley.lit(4, 6) > valley.lit(4, 2));
        assert!(valley.lit(4, 6) <= 1.0 && valley.lit(4, 2) >= SHADE);
    }
}
