//! Films: the surface along a path as an animated GIF or PNG, in the colours of the map, with a bar
//! beneath that says how far the drive is.

use super::picture::SIDE_MIN;
use super::{Failure, files};
use crate::plot::style::Colours;
use ndarray::Array2;
use std::borrow::Cow;
use std::io::{Error, ErrorKind, Write};
use std::path::Path;

/// In what file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmKind {
    /// An animated GIF.
    Gif,
    /// An animated PNG.
    Apng,
}

/// A picture of a film.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Gap (length), shape (ny, nx).
    pub gap: Array2<f64>,
    /// Where the control is in its drive, 0 to 1.
    pub place: f64,
}

/// Hundredths of a second for which a picture is shown.
const DELAY: u16 = 5;
/// Colours of the gap; after them those of the bar: its ground, and its mark.
const COLOURS: usize = 254;
const GROUND: [u8; 3] = [60, 60, 60];
const MARK: [u8; 3] = [255, 255, 255];
/// Height of the bar and half the width of its mark, in pixels.
const BAR: usize = 8;
const HALF: usize = 3;

/// Writes a film of so many pictures, whose last colour is a gap of `top` (length). `goes_on`
/// hears after each picture which share is done, and ends it by a no: nothing is left of it then.
///
/// # Errors
/// A file that cannot be written, or one that was given up.
pub fn write_film(
    path: &Path,
    kind: FilmKind,
    (shots, count): (impl Iterator<Item = Shot>, usize),
    (top, colours): (f64, Colours),
    goes_on: &mut dyn FnMut(f64) -> bool,
) -> Result<(), Failure> {
    files::write_by(path, |file| {
        let mut writer: Option<Film<&mut std::fs::File>> = None;
        let mut file = Some(file);
        for (index, shot) in shots.enumerate() {
            let image = Image::of(&shot, top);
            if let Some(file) = file.take() {
                writer = Some(Film::begin((kind, colours), file, &image, count)?);
            }
            if let Some(writer) = &mut writer {
                writer.add(&image)?;
            }
            if !goes_on((index + 1) as f64 / count as f64) {
                return Err(Error::new(ErrorKind::Interrupted, "it was given up"));
            }
        }
        writer.map_or_else(|| Err(Error::other("there is nothing to show")), Film::end)
    })
}

/// A picture as numbers of colours.
struct Image {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Image {
    /// Each point a square of equal pixels, y upwards; a line cell becomes a band.
    fn of(shot: &Shot, top: f64) -> Self {
        let (rows, columns) = shot.gap.dim();
        let across = SIDE_MIN.div_ceil(columns.max(1));
        let up = if rows == 1 {
            (across * columns).div_ceil(4)
        } else {
            across
        };
        let (width, map) = (columns * across, rows * up);
        let mut pixels = Vec::with_capacity(width * (map + BAR));
        for y in 0..map {
            for x in 0..width {
                let gap = shot.gap[[rows - 1 - y / up, x / across]];
                let share = (gap / top).clamp(0.0, 1.0);
                pixels.push((share * (COLOURS - 1) as f64).round() as u8);
            }
        }
        let mark = (shot.place.clamp(0.0, 1.0) * (width - 1) as f64) as usize;
        for _ in 0..BAR {
            pixels.extend((0..width).map(|x| COLOURS as u8 + u8::from(x.abs_diff(mark) <= HALF)));
        }
        Self {
            width,
            height: map + BAR,
            pixels,
        }
    }
}

/// Red, green and blue of every colour.
fn palette(colours: Colours) -> Vec<u8> {
    let gaps = (0..COLOURS).flat_map(|k| colours.at(k as f64 / (COLOURS - 1) as f64));
    gaps.chain(GROUND).chain(MARK).collect()
}

/// A film that is being written.
enum Film<W: Write> {
    Gif(gif::Encoder<W>),
    Apng(png::Writer<W>),
}

impl<W: Write> Film<W> {
    fn begin(
        (kind, colours): (FilmKind, Colours),
        file: W,
        first: &Image,
        count: usize,
    ) -> Result<Self, Error> {
        let (width, height) = (first.width, first.height);
        Ok(match kind {
            FilmKind::Gif => {
                let side = |n: usize| u16::try_from(n).map_err(Error::other);
                let (width, height) = (side(width)?, side(height)?);
                let encoder = gif::Encoder::new(file, width, height, &palette(colours));
                let mut encoder = encoder.map_err(Error::other)?;
                let repeats = encoder.set_repeat(gif::Repeat::Infinite);
                repeats.map_err(Error::other)?;
                Self::Gif(encoder)
            }
            FilmKind::Apng => {
                let mut encoder = png::Encoder::new(file, width as u32, height as u32);
                encoder.set_color(png::ColorType::Indexed);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_palette(palette(colours));
                encoder
                    .set_animated(count as u32, 0)
                    .map_err(Error::other)?;
                encoder.set_frame_delay(DELAY, 100).map_err(Error::other)?;
                Self::Apng(encoder.write_header().map_err(Error::other)?)
            }
        })
    }

    fn add(&mut self, image: &Image) -> Result<(), Error> {
        match self {
            Self::Gif(encoder) => {
                let frame = gif::Frame {
                    width: image.width as u16,
                    height: image.height as u16,
                    delay: DELAY,
                    buffer: Cow::Borrowed(&image.pixels),
                    ..gif::Frame::default()
                };
                encoder.write_frame(&frame).map_err(Error::other)
            }
            Self::Apng(writer) => writer.write_image_data(&image.pixels).map_err(Error::other),
        }
    }

    fn end(self) -> Result<(), Error> {
        match self {
            Self::Gif(encoder) => encoder.into_inner().map_err(Error::other).map(drop),
            Self::Apng(writer) => writer.finish().map_err(Error::other),
        }
    }
}
