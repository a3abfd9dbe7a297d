//! The textures of the maps, made anew only where what they show has changed.

use super::action::ViewOptions;
use super::gap_picture::{self, GapPicture, ModeLines};
use super::view_state::ViewState;
use crate::physics::indenter::Indenter;
use crate::plot::colours::Colours;
use crate::plot::scale;
use crate::scene::Model;
use crate::worker::protocol::{Frame, Play};
use egui::{Color32, Rect, Shape, Stroke, TextureHandle, Ui, pos2};
use std::sync::Arc;

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
        let centred = view.centred && model.indenter == Indenter::Flat;
        let drawn = (centred, view.smooth, view.soft_mode, view.colours, top);
        let made_from = self.made_from.as_ref();
        if made_from.is_some_and(|(of, so)| Arc::ptr_eq(of, frame) && *so == drawn) {
            return;
        }
        let contact = model.law.contact_gap();
        let before = self.picture.as_ref().map(|picture| picture.island);
        let island = gap_picture::island(frame, contact, before);
        let picture = if let Some(roll) = roll {
            GapPicture::rolled(&frame.gap, contact, island, roll)
        } else if centred {
            GapPicture::centred(&frame.gap, contact, island)
        } else {
            GapPicture::new(&frame.gap, contact, island)
        };
        let options = gap_picture::texture_options(&view);
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
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture.id(), band, all, Color32::WHITE);
        let painter = ui.painter().with_clip_rect(band.intersect(ui.clip_rect()));
        for line in &picture.contour {
            let line = line.iter().map(|at| picture.to_screen(band, *at));
            let white = Stroke::new(1.6, Color32::WHITE);
            painter.add(Shape::line(line.collect(), white));
        }
        true
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
