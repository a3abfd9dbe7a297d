//! The gap field made ready to draw: rolled so that the pattern stands in the middle, coloured,
//! with its contact line. No egui widgets.

use super::action::ViewOptions;
use super::theme::rgb;
use super::view_state::ViewState;
use crate::physics::indenter::Indenter;
use crate::physics::mesh::Grid;
use crate::physics::pattern::{Island, Pattern, rolled, shift_to_middle};
use crate::plot::scale::{self, ends};
use crate::plot::style::Colours;
use crate::scene::Model;
use crate::worker::protocol::{Frame, Play};
use egui::{
    Color32, ColorImage, Pos2, Rect, Shape, Stroke, TextureHandle, TextureOptions, Ui, pos2,
};
use ndarray::Array2;
use std::collections::HashMap;
use std::sync::Arc;

/// A field as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct GapPicture {
    /// The gap, rolled; row 0 is at the bottom.
    pub gap: Array2<f64>,
    /// Smallest gap.
    pub min: f64,
    /// Largest gap.
    pub max: f64,
    /// What stands in the middle.
    pub island: Island,
    /// Contact lines, in units of points; (0, 0) is the lower left corner of the first point's
    /// square.
    pub contour: Vec<Vec<[f32; 2]>>,
    /// Rows and columns by which it was rolled.
    pub roll: (usize, usize),
}

/// What stands in the middle of a picture of the surface. A pattern keeps its place along its whole
/// branch; the film of a jump keeps that of the pattern `before`.
pub fn island(frame: &Frame, contact_gap: f64, before: Option<Island>) -> Island {
    let known = match frame.state.as_ref().map(|state| state.pattern) {
        Some(Pattern::Dimple) => Some(Island::Hole),
        Some(Pattern::Bulge | Pattern::Ridge) => Some(Island::Contact),
        None => before,
        Some(_) => None,
    };
    known.unwrap_or_else(|| Island::of(&frame.gap, contact_gap))
}

/// By how many rows and columns a field is rolled: its island into the middle, if that is wanted and the
/// ground lets it.
pub fn roll(
    view: &ViewOptions,
    model: &Model,
    gap: &Array2<f64>,
    island: Island,
) -> (usize, usize) {
    if view.centred && model.indenter == Indenter::Flat {
        shift_to_middle(gap, island)
    } else {
        (0, 0)
    }
}

/// How a texture of a field is drawn.
pub fn texture_options(view: &ViewOptions) -> TextureOptions {
    if view.smooth {
        TextureOptions::LINEAR
    } else {
        TextureOptions::NEAREST
    }
}

/// A piece of a line on the map.
pub type Segment = [[f32; 2]; 2];

/// Contours of the soft mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeLines {
    /// Where the mode lifts the surface.
    pub up: Vec<Segment>,
    /// Where it lowers it.
    pub down: Vec<Segment>,
}

/// Levels of the soft mode's contours, in shares of its largest magnitude.
const MODE_LEVELS: [f64; 3] = [0.25, 0.5, 0.75];

impl GapPicture {
    /// Prepares a field, rolled by so many rows and columns. `contact_gap` is the level of the contact
    /// line.
    pub fn new(gap: &Array2<f64>, contact_gap: f64, island: Island, roll: (usize, usize)) -> Self {
        let (dy, dx) = roll;
        let gap = rolled(gap, dy, dx);
        let (min, max) = ends(gap.iter().copied());
        let contour = joined(&contour(&gap, contact_gap));
        Self {
            gap,
            min,
            max,
            island,
            contour,
            roll,
        }
    }

    /// Where a place of the field, in units of points, lies on the screen where it fills `band`.
    pub fn to_screen(&self, band: Rect, at: [f32; 2]) -> Pos2 {
        let (ny, nx) = self.gap.dim();
        pos2(
            band.left() + at[0] / nx as f32 * band.width(),
            band.bottom() - at[1] / ny as f32 * band.height(),
        )
    }

    /// The place of the cell (length) under a place of the screen.
    pub fn place_of(&self, band: Rect, at: Pos2, grid: &Grid) -> [f64; 2] {
        let (ny, nx) = self.gap.dim();
        let share = [
            f64::from((at.x - band.left()) / band.width()),
            f64::from((band.bottom() - at.y) / band.height()),
        ];
        let (dy, dx) = self.roll;
        let one = |share: f64, n: usize, roll: usize| {
            (share * n as f64 - 0.5 - roll as f64).rem_euclid(n as f64) * grid.spacing()
        };
        [one(share[0], nx, dx), one(share[1], ny, dy)]
    }

    /// The contours of a mode of this field.
    fn mode_lines(&self, mode: &Array2<f64>) -> ModeLines {
        let mode = rolled(mode, self.roll.0, self.roll.1);
        let largest = mode.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let lines = |sign: f64| {
            MODE_LEVELS
                .iter()
                .flat_map(|level| contour(&mode, sign * level * largest))
                .collect()
        };
        ModeLines {
            up: lines(1.0),
            down: lines(-1.0),
        }
    }

    /// The coloured picture; `top` is the gap of the last colour, contact is dark.
    pub fn image(&self, top: f64, colours: Colours) -> ColorImage {
        image(&self.gap, |share| rgb(colours.at(share)), |gap| gap / top)
    }

    /// A mode of this field in signed colours: orange where it lifts the surface, purple where it
    /// lowers it.
    pub fn mode_image(&self, mode: &Array2<f64>) -> ColorImage {
        let mode = rolled(mode, self.roll.0, self.roll.1);
        let largest = mode.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        image(&mode, signed_colour, |v| 0.5 + 0.5 * v / largest)
    }

    /// Row and column of the middle of the island (smallest gap, or largest in a hole), and whether
    /// the gap varies more along x (true) than along y.
    pub fn middle(&self) -> (usize, usize, bool) {
        let (ny, nx) = self.gap.dim();
        let sign = -self.island.sign();
        let mut low = (ny / 2, nx / 2);
        // The middle wins where it is as low as anything: a ridge is then cut in its middle.
        for (at, &g) in self.gap.indexed_iter() {
            if sign * g < sign * self.gap[low] - 1e-3 * (self.max - self.min) {
                low = at;
            }
        }
        let spread = |line: ndarray::ArrayView1<'_, f64>| {
            line.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b))
                - line.iter().fold(f64::INFINITY, |a, &b| a.min(b))
        };
        let along_x = spread(self.gap.row(low.0)) >= 0.999 * spread(self.gap.column(low.1));
        (low.0, low.1, along_x || ny == 1)
    }
}

/// The colour of a share 0 (lowers) over 0.5 (neither) to 1 (lifts).
fn signed_colour(share: f64) -> Color32 {
    let c = colorous::PURPLE_ORANGE.eval_continuous(share);
    Color32::from_rgb(c.r, c.g, c.b)
}

/// A field of heights, dark where it is lowest.
pub fn heights(field: &Array2<f64>) -> ColorImage {
    let ends = |[low, high]: [f64; 2], h: &f64| [low.min(*h), high.max(*h)];
    let [low, high] = field.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let colour = |share| rgb(Colours::Uniform.at(share));
    image(field, colour, |h| (h - low) / (high - low))
}

/// A field as pixels, row 0 at the bottom; `share` is the place of a value on the scale of colours.
fn image(
    field: &Array2<f64>,
    colour: impl Fn(f64) -> Color32,
    share: impl Fn(f64) -> f64,
) -> ColorImage {
    let (ny, nx) = field.dim();
    let table: Vec<Color32> = (0..256).map(|i| colour(f64::from(i) / 255.0)).collect();
    let pixels = (0..ny)
        .rev()
        .flat_map(|j| (0..nx).map(move |i| (j, i)))
        .map(|at| table[(share(field[at]) * 255.0).clamp(0.0, 255.0) as usize])
        .collect();
    ColorImage::new([nx, ny], pixels)
}

/// Marching squares between the mesh points, and beyond the outermost ones: the field goes on there
/// as it begins on the other side.
fn contour(gap: &Array2<f64>, level: f64) -> Vec<Segment> {
    let (ny, nx) = gap.dim();
    let mut segments = Vec::new();
    for j in 0..=ny {
        for i in 0..=nx {
            let (low, high) = ((j + ny - 1) % ny, j % ny);
            let (left, right) = ((i + nx - 1) % nx, i % nx);
            let corners = [
                gap[(low, left)],
                gap[(low, right)],
                gap[(high, right)],
                gap[(high, left)],
            ];
            let below = corners.map(|g| g < level);
            if below.iter().all(|&b| b) || below.iter().all(|&b| !b) {
                continue;
            }
            let at = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let mut cuts: Vec<[f32; 2]> = Vec::with_capacity(4);
            for k in 0..4 {
                let m = (k + 1) % 4;
                if below[k] != below[m] {
                    let t = (level - corners[k]) / (corners[m] - corners[k]);
                    let x = i as f64 - 0.5 + at[k][0] + t * (at[m][0] - at[k][0]);
                    let y = j as f64 - 0.5 + at[k][1] + t * (at[m][1] - at[k][1]);
                    cuts.push([x as f32, y as f32]);
                }
            }
            segments.extend(cuts.chunks_exact(2).map(|c| [c[0], c[1]]));
        }
    }
    segments
}

/// Pieces of lines that meet, as lines: drawn one by one they would be brighter where they meet.
fn joined(pieces: &[Segment]) -> Vec<Vec<[f32; 2]>> {
    // What one point is to two mesh squares differs by rounding.
    let key = |point: [f32; 2]| point.map(|x| (1024.0 * x).round() as i64);
    let mut meeting: HashMap<_, Vec<usize>> = HashMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        for end in piece {
            meeting.entry(key(*end)).or_default().push(i);
        }
    }
    let mut left = vec![true; pieces.len()];
    let mut onwards = |line: &mut Vec<[f32; 2]>| {
        while let Some(last) = line.last().map(|last| key(*last))
            && let Some(&i) = meeting[&last].iter().find(|i| left[**i])
        {
            left[i] = false;
            let [a, b] = pieces[i];
            line.push(if key(a) == last { b } else { a });
        }
    };
    let mut lines = Vec::new();
    for piece in pieces {
        let mut line = vec![piece[0]];
        onwards(&mut line);
        line.reverse();
        onwards(&mut line);
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// How a field is drawn: centred, smooth, with its soft mode, in which colours up to which gap.
type Drawn = (bool, bool, bool, Colours, f64);

/// The texture and what it was made from, so that nothing is made twice.
#[derive(Default)]
pub struct MapCache {
    made_from: Option<(Arc<Frame>, Drawn)>,
    texture: Option<TextureHandle>,
    /// The field as drawn.
    pub picture: Option<GapPicture>,
    /// The soft mode's contours, if they are wanted and there is one.
    pub mode: Option<ModeLines>,
}

impl MapCache {
    /// Brings texture and picture up to date with the newest frame.
    pub fn update(&mut self, ctx: &egui::Context, state: &ViewState) {
        let top = scale::gap_scale(&state.scene, &state.model);
        // What is pressed keeps its place under the hand.
        let held = matches!(state.run.play, Play::Pressed(_) | Play::LetGo(_));
        let roll = self.picture.as_ref().filter(|_| held).map(|p| p.roll);
        self.picture_of(
            ctx,
            state.pictured(),
            (&state.model, top),
            (state.view, roll),
        );
    }

    /// The same with the surface of the scene beside, in the same colours.
    pub fn update_beside(&mut self, ctx: &egui::Context, state: &ViewState) {
        let Some((beside, kept)) = state.beside() else {
            return;
        };
        let top = scale::gap_scale(&state.scene, &state.model);
        let top = top / state.rho() * state.units_of(kept)[0];
        self.picture_of(
            ctx,
            beside.shown.as_ref().ok(),
            (&kept.model, top),
            (state.view, None),
        );
    }

    fn picture_of(
        &mut self,
        ctx: &egui::Context,
        frame: Option<&Arc<Frame>>,
        (model, top): (&Model, f64),
        (view, roll): (ViewOptions, Option<(usize, usize)>),
    ) {
        let Some(frame) = frame else {
            self.picture = None;
            self.mode = None;
            self.made_from = None;
            return;
        };
        let drawn = (view.centred, view.smooth, view.soft_mode, view.colours, top);
        let made_from = self.made_from.as_ref();
        if made_from.is_some_and(|(of, so)| Arc::ptr_eq(of, frame) && *so == drawn) {
            return;
        }
        let contact = model.law.contact_gap();
        let before = self.picture.as_ref().map(|picture| picture.island);
        let island = island(frame, contact, before);
        let roll = roll.unwrap_or_else(|| self::roll(&view, model, &frame.gap, island));
        let picture = GapPicture::new(&frame.gap, contact, island, roll);
        let options = texture_options(&view);
        let image = picture.image(top, view.colours);
        match &mut self.texture {
            Some(texture) => texture.set(image, options),
            None => self.texture = Some(ctx.load_texture("gap", image, options)),
        }
        self.mode = frame
            .soft_mode
            .as_ref()
            .filter(|_| view.soft_mode || frame.is_of_a_branch())
            .map(|mode| picture.mode_lines(mode));
        self.picture = Some(picture);
        self.made_from = Some((frame.clone(), drawn));
    }

    /// Draws the field with its contact line; false where there is none.
    pub fn draw(&self, ui: &Ui, band: Rect) -> bool {
        let (Some(texture), Some(picture)) = (&self.texture, &self.picture) else {
            return false;
        };
        draw(ui, texture, (band, 1.6), Some(picture));
        true
    }
}

/// Draws a texture in its place, with the contact lines of a picture of this width.
pub fn draw(ui: &Ui, texture: &TextureHandle, (band, width): (Rect, f32), of: Option<&GapPicture>) {
    let painter = ui.painter().with_clip_rect(band.intersect(ui.clip_rect()));
    let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), band, all, Color32::WHITE);
    let lines = of.map(|picture| picture.contour.iter().map(move |line| (picture, line)));
    for (picture, line) in lines.into_iter().flatten() {
        let line = line.iter().map(|at| picture.to_screen(band, *at));
        let white = Stroke::new(width, Color32::WHITE);
        painter.add(Shape::line(line.collect(), white));
    }
}

/// The maps of the present scene and of the one beside it.
#[derive(Default)]
pub struct Maps {
    /// That of the present scene.
    pub a: MapCache,
    /// That of the scene beside it.
    pub b: MapCache,
}

impl Maps {
    /// Brings both up to date.
    pub fn update(&mut self, ctx: &egui::Context, state: &ViewState) {
        self.a.update(ctx, state);
        self.b.update_beside(ctx, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn island(ny: usize, nx: usize, cy: f64, cx: f64) -> Array2<f64> {
        Array2::from_shape_fn((ny, nx), |(j, i)| {
            4.0 - (TAU * (j as f64 - cy) / ny as f64).cos()
                - (TAU * (i as f64 - cx) / nx as f64).cos()
        })
    }

    fn on_its_own(gap: &Array2<f64>, contact_gap: f64) -> GapPicture {
        let island = Island::of(gap, contact_gap);
        centred(gap, contact_gap, island)
    }

    fn centred(gap: &Array2<f64>, contact_gap: f64, island: Island) -> GapPicture {
        GapPicture::new(gap, contact_gap, island, shift_to_middle(gap, island))
    }

    #[test]
    fn an_island_is_rolled_to_the_middle() {
        let picture = on_its_own(&island(32, 32, 3.0, 29.0), 2.5);
        assert_eq!(picture.middle().0, 16);
        assert_eq!(picture.gap[(16, 16)], picture.min);
    }

    #[test]
    fn a_hole_in_the_contact_is_rolled_to_the_middle_and_cut_there() {
        let picture = on_its_own(&(island(32, 32, 3.0, 29.0) * -1.0 + 6.0), 3.0);
        assert_eq!(picture.island, Island::Hole);
        assert_eq!(picture.middle(), (16, 16, true));
        assert_eq!(picture.gap[(16, 16)], picture.max);
    }

    #[test]
    fn a_hole_larger_than_the_contact_around_it_is_in_the_middle_where_it_is_known_to_be_one() {
        let field = island(32, 32, 3.0, 29.0) * -1.0 + 6.0;
        assert_eq!(on_its_own(&field, 1.0).island, Island::Contact);
        let picture = centred(&field, 1.0, Island::Hole);
        assert_eq!(picture.gap[(16, 16)], picture.max);
    }

    #[test]
    fn a_flat_field_stays_where_it_is_and_has_no_contact_line() {
        let picture = on_its_own(&Array2::from_elem((8, 8), 3.0), 0.7);
        assert_eq!(
            (picture.min, picture.max, picture.contour.len()),
            (3.0, 3.0, 0)
        );
    }

    #[test]
    fn the_contact_line_of_an_island_is_a_closed_ring_of_its_radius() {
        let picture = GapPicture::new(&island(64, 64, 32.0, 32.0), 2.3, Island::Contact, (0, 0));
        let [ring] = &picture.contour[..] else {
            panic!("{} lines", picture.contour.len())
        };
        let [first, last] = [ring[0], ring[ring.len() - 1]];
        assert!(ring.len() > 20 && (first[0] - last[0]).hypot(first[1] - last[1]) < 1e-3);
        let radius = |p: [f32; 2]| f64::from((p[0] - 32.5).hypot(p[1] - 32.5));
        let expected = (0.85f64).acos() / TAU * 64.0 * (2.0f64).sqrt();
        for p in ring {
            assert!(
                (radius(*p) / expected - 1.0).abs() < 0.1,
                "{} {expected}",
                radius(*p)
            );
        }
    }

    #[test]
    fn the_contact_line_of_a_ridge_goes_to_both_borders() {
        let ridge = Array2::from_shape_fn((16, 32), |(_, i)| {
            3.0 - (TAU * (i as f64 - 16.0) / 32.0).cos()
        });
        let picture = GapPicture::new(&ridge, 2.5, Island::Contact, (0, 0));
        assert_eq!(picture.contour.len(), 2);
        for line in &picture.contour {
            let rows = || line.iter().map(|p| p[1]);
            let (low, high) = (rows().fold(16.0, f32::min), rows().fold(0.0, f32::max));
            assert!(low <= 0.0 && high >= 16.0, "{low} {high}");
            // The gap is 2.5 a sixth of the wave from its crest.
            let off = (line[0][0] - 16.5).abs();
            assert!((off - 32.0 / 6.0).abs() < 0.1, "{off}");
        }
    }

    #[test]
    fn the_soft_mode_is_rolled_with_the_gap_and_drawn_on_both_sides_of_zero() {
        let picture = on_its_own(&island(32, 32, 16.0, 8.0), 2.3);
        let mode = Array2::from_shape_fn((32, 32), |(_, i)| (TAU * (i as f64 - 8.0) / 32.0).cos());
        let lines = picture.mode_lines(&mode);
        let columns = |segments: &[Segment]| {
            segments
                .iter()
                .map(|s| s[0][0])
                .fold((f32::MAX, f32::MIN), |(a, b), x| (a.min(x), b.max(x)))
        };
        let (low, high) = columns(&lines.up);
        // The crest stands in the middle, where the pattern was rolled to.
        assert!(
            low > 8.0 && high < 25.0 && (low + high - 33.0).abs() < 1.0,
            "{low} {high}"
        );
        assert_eq!(lines.up.len(), lines.down.len());
    }

    #[test]
    fn a_line_cell_is_rolled_too_and_cut_along_x() {
        let field = Array2::from_shape_fn((1, 32), |(_, i)| {
            3.0 - (TAU * (i as f64 - 5.0) / 32.0).cos()
        });
        let picture = on_its_own(&field, 1.0);
        assert_eq!(picture.gap[(0, 16)], picture.min);
        assert!(picture.middle().2);
    }
}
