//! A sheet as pixels: drawn larger, then made smaller, which smooths the edges.

use super::sheet::{LINE_HEIGHT, Mark, Place, SMALLER, Sheet, Stroke, drop_of, spacing, width_of};
use crate::paper::typeset::{Run, Script};
use crate::storage::picture::register_font;
use image::RgbImage;
use image::imageops::{self, FilterType};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::error::Error;

/// Pixels drawn for each of the picture's along a side.
const OVERSAMPLING: u32 = 3;
/// Least pixels of the picture across, and for each unit.
const WIDTH_MIN: f64 = 1800.0;
const PIXELS_MIN: f64 = 1.5;

type Drawn = Result<(), Box<dyn Error>>;
type Ground<'a, 'b> = DrawingArea<BitMapBackend<'a>, Shift>;

/// The picture, at least 1800 pixels wide.
pub(super) fn pixels(sheet: &Sheet) -> Result<RgbImage, Box<dyn Error>> {
    register_font();
    let scale = (WIDTH_MIN / sheet.width).max(PIXELS_MIN);
    let (width, height) = ((sheet.width * scale).round() as u32, (sheet.height * scale).round() as u32);
    let mut large = RgbImage::new(width * OVERSAMPLING, height * OVERSAMPLING);
    let backend = BitMapBackend::with_buffer(&mut large, (width * OVERSAMPLING, height * OVERSAMPLING));
    let ground = backend.into_drawing_area();
    let paint = Paint { scale: scale * f64::from(OVERSAMPLING) };
    ground.fill(&WHITE)?;
    for mark in &sheet.marks {
        paint.mark(&ground, mark)?;
    }
    ground.present()?;
    drop(ground);
    Ok(imageops::thumbnail(&large, width, height))
}

struct Paint {
    scale: f64,
}

impl Paint {
    fn px(&self, units: f64) -> i32 {
        (units * self.scale).round() as i32
    }

    /// Pixels of the places, each once.
    fn places(&self, points: &[Place]) -> Vec<(i32, i32)> {
        let mut list: Vec<_> = points.iter().map(|p| (self.px(p[0]), self.px(p[1]))).collect();
        list.dedup();
        list
    }

    fn mark(&self, ground: &Ground<'_, '_>, mark: &Mark) -> Drawn {
        match mark {
            Mark::Line { points, stroke } => self.line(ground, points, stroke),
            Mark::Fill { points, colour, opacity } => {
                ground.draw(&Polygon::new(self.places(points), colour.mix(*opacity).filled()))?;
                Ok(())
            }
            Mark::Words { at, runs, size, colour, upright } => self.words(ground, *at, runs, *size, *colour, *upright),
            Mark::Picture { place: [x, y, width, height], image } => {
                let size = (self.px(*width).max(1) as u32, self.px(*height).max(1) as u32);
                let image = imageops::resize(image, size.0, size.1, FilterType::Triangle);
                let corner = (self.px(*x), self.px(*y));
                ground.draw(&BitMapElement::<_>::with_owned_buffer(corner, size, image.into_raw()).ok_or("no picture")?)?;
                Ok(())
            }
        }
    }

    fn line(&self, ground: &Ground<'_, '_>, points: &[Place], stroke: &Stroke) -> Drawn {
        let style = stroke.colour.stroke_width(self.px(stroke.width).max(1) as u32);
        let points = self.places(points);
        match stroke.dash {
            None => {
                // Plotters lengthens sharp corners without a limit: they are drawn as two strokes and a round joint.
                for piece in blunt(&points) {
                    ground.draw(&PathElement::new(piece, style))?;
                    ground.draw(&Circle::new(piece[0], self.px(0.5 * stroke.width), stroke.colour.filled()))?;
                }
            }
            Some([on, off]) => ground.draw(&DashedPathElement::new(points, self.px(on), self.px(off), style))?,
        }
        Ok(())
    }

    fn words(&self, ground: &Ground<'_, '_>, at: Place, runs: &[Run], size: f64, colour: RGBColor, upright: bool) -> Drawn {
        let mut along = 0.0;
        for run in runs {
            let small = if run.script == Script::Base { size } else { SMALLER * size };
            // The base line is half a line below the place of a text (plotters' reader of fonts).
            let across = drop_of(run.script) * size - 0.5 * LINE_HEIGHT * small;
            let draw = |text: &str, along: f64| {
                let font = ("sans-serif", small * LINE_HEIGHT * self.scale).into_font();
                let (font, place) = if upright {
                    (font.transform(FontTransform::Rotate270), [at[0] + across, at[1] - along])
                } else {
                    (font, [at[0] + along, at[1] + across])
                };
                ground.draw_text(text, &TextStyle::from(font).color(&colour), (self.px(place[0]), self.px(place[1])))
            };
            // Plotters does not put accents onto letters.
            let mut text = String::new();
            for c in run.text.chars() {
                let wide = |text: &str| width_of(&Run { text: text.to_owned(), script: run.script }, size);
                let (Some(accent), Some(letter)) = (spacing(c), text.chars().last()) else {
                    text.push(c);
                    continue;
                };
                let (accent, letter) = (accent.to_string(), letter.to_string());
                draw(&accent, along + wide(&text) - 0.5 * (wide(&letter) + wide(&accent)))?;
            }
            draw(&text, along)?;
            along += width_of(run, size);
        }
        Ok(())
    }
}

/// The pieces of a line between its sharp corners, each with both its ends.
fn blunt(points: &[(i32, i32)]) -> Vec<&[(i32, i32)]> {
    /// Cosine of the largest turn that is no sharp corner.
    const BLUNT: f64 = 0.3;
    let step = |i: usize| (f64::from(points[i].0 - points[i - 1].0), f64::from(points[i].1 - points[i - 1].1));
    let sharp = |i: &usize| {
        let ((ax, ay), (bx, by)) = (step(*i), step(i + 1));
        ax * bx + ay * by < BLUNT * ax.hypot(ay) * bx.hypot(by)
    };
    let corners = (1..points.len().saturating_sub(1)).filter(sharp);
    let ends: Vec<usize> = std::iter::once(0).chain(corners).chain([points.len().saturating_sub(1)]).collect();
    ends.windows(2).filter(|pair| pair[1] > pair[0]).map(|pair| &points[pair[0]..=pair[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::figure::marks::INK;

    #[test]
    fn a_sharp_corner_stays_where_it_is() {
        let mut sheet = Sheet::new(900.0, 200.0);
        // A needle that points upwards: without a limit its corner would lie far above.
        sheet.line([[448.0, 180.0], [450.0, 100.0], [452.0, 180.0]], Stroke::solid(INK, 4.0));
        let picture = pixels(&sheet).expect("a picture");
        let dark = picture.enumerate_pixels().filter(|(.., p)| p.0[0] < 128).map(|(_, y, _)| y).min().expect("a line");
        // Two pixels a unit: the corner, and half the width of the line.
        assert!((190..=200).contains(&dark), "{dark}");
    }

    #[test]
    fn a_line_falls_apart_at_its_sharp_corners_only() {
        let points = [(0, 0), (10, 0), (20, 4), (10, 4), (10, 4 + 9)];
        let lengths: Vec<usize> = blunt(&points).iter().map(|piece| piece.len()).collect();
        assert_eq!(lengths, [3, 2, 2]);
        assert!(blunt(&[]).is_empty() && blunt(&[(1, 1)]).is_empty());
    }
}
