//! What a surface looks and sounds like. The gap field as an image (contact dark), and the scene
//! inside a PNG, so that a picture opens again as what it shows; films, the surface along a path as
//! an animated GIF or PNG, in the colours of the map, with a bar beneath that says how far the drive
//! is; the click of a jump, as a file that programs which play sounds take.
//!
//! A PNG is a signature and a row of chunks: length, name, data, checksum. The scene is one more,
//! uncompressed text (iTXt) under a keyword of its own, right after the header.

use super::{Failure, files, scene_file};
use crate::plot::scale::ends;
use crate::plot::style::Colours;
use crate::scene::Scene;
use image::{ImageFormat, Rgb, RgbImage};
use ndarray::Array2;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::io::{Cursor, Error, ErrorKind, Write};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// Encodes as PNG and writes the file whole.
pub(super) fn write_png(path: &Path, image: &RgbImage) -> Result<(), Failure> {
    files::write_whole(
        path,
        &encode_png(image).map_err(|error| Failure::write(path, error))?,
    )
}

/// The bytes of a PNG.
pub(super) fn encode_png(image: &RgbImage) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Least width and height of the image, in pixels.
pub(super) const SIDE_MIN: usize = 256;

/// Contrast below this share of the largest gap is not shown: it is the tolerance of the solver,
/// not a pattern.
const CONTRAST_MIN: f64 = 1e-3;

/// Smallest and largest gap of a picture's colours.
pub type Scale = (f64, f64);

/// The scale that shows all these gaps in the same colours.
pub fn common_scale<'a>(gaps: impl IntoIterator<Item = &'a Array2<f64>>) -> Scale {
    let all = gaps.into_iter().flat_map(|gap| gap.iter().copied());
    ends(all.filter(|g| g.is_finite()))
}

/// Writes the gap as a PNG on a scale of its own, from the smallest gap to the largest; y points up.
///
/// # Errors
/// A file that cannot be written.
pub fn write_gap_png(path: &Path, gap: &Array2<f64>, colours: Colours) -> Result<(), Failure> {
    write_png(path, &gap_image(gap, common_scale([gap]), colours))
}

/// The gap as an image in the colours of a scale: each point a square of equal pixels, at least 256
/// pixels a side. A line cell becomes a band; values that are not finite are red.
pub fn gap_image(gap: &Array2<f64>, (low, high): Scale, colours: Colours) -> RgbImage {
    let (rows, columns) = gap.dim();
    let across = SIDE_MIN.div_ceil(columns.max(1)) as u32;
    let up = if rows == 1 {
        (across * columns as u32).div_ceil(4)
    } else {
        across
    };
    let points = gap_pixels(gap, (low, high), colours);
    RgbImage::from_fn(columns as u32 * across, rows as u32 * up, |x, y| {
        *points.get_pixel(x / across, y / up)
    })
}

/// The same with one pixel for each point.
pub(in crate::storage) fn gap_pixels(
    gap: &Array2<f64>,
    (low, high): Scale,
    colours: Colours,
) -> RgbImage {
    let (rows, columns) = gap.dim();
    // Without contrast there is no pattern to show: dark, as contact is.
    let span = if high - low > CONTRAST_MIN * low.abs().max(high.abs()) {
        high - low
    } else {
        f64::INFINITY
    };
    RgbImage::from_fn(columns as u32, rows as u32, |x, y| {
        let g = gap[[rows - 1 - y as usize, x as usize]];
        if !g.is_finite() {
            return Rgb([255, 0, 0]);
        }
        Rgb(colours.at((g - low) / span))
    })
}

/// Keyword of the chunk.
const KEYWORD: &[u8] = b"tackscope-scene";
/// The chunk of a session: private, safe to copy, and no picture needs it.
const SESSION: &[u8; 4] = b"tkSs";
/// Largest session that a picture carries, in bytes: pictures are sent about.
const SESSION_MAX: usize = 1 << 22;
/// What every PNG begins with.
const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// Signature and header chunk, which every PNG has at the same length.
const HEADER: usize = 8 + 12 + 13;
/// Largest picture that is read, in bytes.
const BYTES_MAX: u64 = 1 << 26;

/// Puts the scene into a PNG that has been written, and the bytes of a session where they are few
/// enough.
///
/// # Errors
/// A file that cannot be read, is no PNG, or cannot be written.
pub fn attach(path: &Path, scene: &Scene, session: Option<&[u8]>) -> Result<(), Failure> {
    files::write_whole(path, &carrying(read(path)?, scene, session))
}

/// Writes an image as a PNG with the scene in it.
///
/// # Errors
/// A file that cannot be written.
pub fn write_with_scene(path: &Path, image: &RgbImage, scene: &Scene) -> Result<(), Failure> {
    let bytes = encode_png(image).map_err(|error| Failure::write(path, error))?;
    files::write_whole(path, &carrying(bytes, scene, None))
}

/// The bytes of a PNG with the scene in it, and those of a session where they are few enough.
fn carrying(mut bytes: Vec<u8>, scene: &Scene, session: Option<&[u8]>) -> Vec<u8> {
    let mut data = KEYWORD.to_vec();
    // End of keyword; not compressed, method 0; no language; no translated keyword.
    data.extend([0, 0, 0, 0, 0]);
    data.extend(scene_file::to_text(scene).bytes());
    let mut chunks = chunk(b"iTXt", &data);
    if let Some(session) = session.filter(|session| session.len() <= SESSION_MAX) {
        chunks.extend(chunk(SESSION, session));
    }
    bytes.splice(HEADER..HEADER, chunks);
    bytes
}

/// True if this is the beginning of a PNG.
pub(super) fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE)
}

/// The session inside the bytes of a PNG.
pub(super) fn session_in(bytes: &[u8]) -> Option<&[u8]> {
    let mut chunks = chunks(bytes);
    chunks.find_map(|(kind, data)| (kind == SESSION).then_some(data))
}

/// The scene inside the bytes of a PNG.
///
/// # Errors
/// One without a scene, or with one that is not allowed.
pub(super) fn scene_of(path: &Path, bytes: &[u8]) -> Result<Scene, Failure> {
    let name = path.display().to_string();
    let text = chunks(bytes).find_map(|(kind, data)| {
        let rest = data.strip_prefix(KEYWORD)?.strip_prefix(&[0, 0, 0, 0, 0])?;
        (kind == b"iTXt").then(|| std::str::from_utf8(rest).ok())?
    });
    match text {
        Some(text) if text.len() as u64 > scene_file::BYTES_MAX => {
            let reason = format!(
                "the scene in this picture is longer than {} bytes",
                scene_file::BYTES_MAX
            );
            Err(Failure::unreadable(
                path,
                &reason,
                "open a picture that this program has written",
            ))
        }
        Some(text) => scene_file::parse(text, &name),
        None => Err(Failure::unreadable(
            path,
            "there is no scene in this picture",
            "open a picture that this program has written",
        )),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = files::read_bytes(path, BYTES_MAX)?;
    if is_png(&bytes) && bytes.len() > HEADER {
        return Ok(bytes);
    }
    Err(Failure::unreadable(
        path,
        "not a PNG",
        "check that this is the picture you mean",
    ))
}

/// Name and data of every whole chunk.
fn chunks(bytes: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    let mut rest = bytes.get(SIGNATURE.len()..).unwrap_or_default();
    std::iter::from_fn(move || {
        let length = u32::from_be_bytes(rest.get(..4)?.try_into().ok()?) as usize;
        let (name, data) = (rest.get(4..8)?, rest.get(8..8 + length)?);
        rest = rest.get(12 + length..)?;
        Some((name, data))
    })
}

fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = (data.len() as u32).to_be_bytes().to_vec();
    bytes.extend(name);
    bytes.extend(data);
    // That of CRC-32 (ISO 3309) over name and data.
    bytes.extend(crc32fast::hash(&bytes[4..]).to_be_bytes());
    bytes
}

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

/// Samples a second, the lowest that every device takes.
const RATE: u32 = 44_100;
/// The tone (Hz), and the time in which it fades by a factor e (seconds): a tick of a few milliseconds.
const TONE: f64 = 1_600.0;
const FADE: f64 = 0.0015;
/// Silence before it, and all of it (seconds): a server of sound may swallow the first milliseconds of
/// a stream (PulseAudio 16: eight), and a player end before the last are heard.
const LEAD: f64 = 0.04;
const LENGTH: f64 = 0.12;
/// Its first sample as a share of the largest that there is.
const LOUDNESS: f64 = 0.6;

/// The click in a temporary file, which is there as long as this.
///
/// # Errors
/// There is no folder for temporary files, or no room in it.
pub fn click() -> std::io::Result<NamedTempFile> {
    let mut file = Builder::new()
        .prefix("tackscope-click-")
        .suffix(".wav")
        .tempfile()?;
    file.write_all(&wav(&samples()))?;
    file.flush()?;
    Ok(file)
}

fn samples() -> Vec<i16> {
    let count = (LENGTH * f64::from(RATE)) as u32;
    let times = (0..count).map(|k| f64::from(k) / f64::from(RATE));
    let wave = |t: f64| match t - LEAD {
        t if t < 0.0 => 0.0,
        t => LOUDNESS * (-t / FADE).exp() * (TAU * TONE * t).cos(),
    };
    times
        .map(|t| (wave(t) * f64::from(i16::MAX)) as i16)
        .collect()
}

/// One channel of 16 bits a sample as a WAV file.
fn wav(samples: &[i16]) -> Vec<u8> {
    const FORMAT: u32 = 16;
    let bytes = 2 * samples.len() as u32;
    let mut file = b"RIFF".to_vec();
    file.extend((4 + 8 + FORMAT + 8 + bytes).to_le_bytes());
    file.extend(b"WAVEfmt ");
    file.extend(FORMAT.to_le_bytes());
    // Plain samples, one channel.
    file.extend([1, 0, 1, 0]);
    file.extend(RATE.to_le_bytes());
    file.extend((2 * RATE).to_le_bytes());
    // Bytes and bits of a sample.
    file.extend([2, 0, 16, 0]);
    file.extend(b"data");
    file.extend(bytes.to_le_bytes());
    file.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::{self, open_scene};
    use ndarray::array;

    fn own_colours(gap: &Array2<f64>) -> RgbImage {
        gap_image(gap, common_scale([gap]), Colours::default())
    }

    #[test]
    fn contact_is_dark_and_y_points_up() {
        let image = own_colours(&array![[0.0, 1.0], [2.0, 3.0]]);
        assert_eq!(image.dimensions(), (256, 256));
        let brightness = |x, y| {
            image
                .get_pixel(x, y)
                .0
                .iter()
                .map(|c| u32::from(*c))
                .sum::<u32>()
        };
        assert!(
            brightness(0, 255) < brightness(255, 0),
            "the smallest gap, first row, is the darkest and lies at the bottom"
        );
    }

    #[test]
    fn line_cells_uniform_gaps_and_nan_make_pictures_too() {
        assert_eq!(own_colours(&Array2::zeros((1, 64))).dimensions(), (256, 64));
        assert_eq!(
            own_colours(&Array2::zeros((300, 300))).dimensions(),
            (300, 300)
        );
        assert_eq!(
            own_colours(&array![[f64::NAN, 1.0]]).get_pixel(0, 0),
            &Rgb([255, 0, 0])
        );
    }

    #[test]
    fn a_picture_opens_again_as_its_scene_and_stays_a_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gap.png");
        let preset = storage::preset("fig2").unwrap();
        let scene = scene_file::parse(preset.text, preset.name).unwrap();
        write_gap_png(
            &path,
            &Array2::from_shape_fn((8, 8), |(j, i)| 1.0 + (i * j) as f64),
            Colours::default(),
        )
        .unwrap();
        let before = image::open(&path).unwrap().into_rgb8();
        assert!(
            open_scene(&path)
                .unwrap_err()
                .to_string()
                .contains("no scene")
        );
        attach(&path, &scene, None).unwrap();
        assert_eq!(open_scene(&path).unwrap(), scene);
        assert_eq!(image::open(&path).unwrap().into_rgb8(), before);
    }

    #[test]
    fn what_is_no_picture_or_is_cut_short_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        for bytes in [
            &b"hello"[..],
            b"\x89PNG\r\n\x1a\n",
            &[SIGNATURE, &[0xff; 40][..]].concat(),
        ] {
            files::write_whole(&path, bytes).unwrap();
            assert!(open_scene(&path).is_err(), "{bytes:?}");
        }
    }

    #[test]
    fn a_pipe_is_refused_without_waiting_for_what_it_may_give() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        assert!(
            std::process::Command::new("mkfifo")
                .arg(&path)
                .status()
                .unwrap()
                .success()
        );
        assert!(
            open_scene(&path)
                .unwrap_err()
                .to_string()
                .contains("a pipe or a device")
        );
        files::remove(&path);
        assert!(!path.exists() && open_scene(&path).is_err() && open_scene(folder.path()).is_err());
        files::write_whole(&path, b"12345678").unwrap();
        assert!(files::read_regular(&path, 8).is_ok() && files::read_regular(&path, 7).is_err());
    }

    /// By the layout of the format: every length where a reader looks for it.
    #[test]
    fn the_click_is_a_wav_file_with_a_tick_of_ten_milliseconds_between_two_silences() {
        let file = click().unwrap();
        let bytes = std::fs::read(file.path()).unwrap();
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(
            [&bytes[..4], &bytes[8..16], &bytes[36..40]],
            [&b"RIFF"[..], b"WAVEfmt ", b"data"]
        );
        assert_eq!(number(4) as usize, bytes.len() - 8);
        assert_eq!((number(16), number(24), number(28)), (16, RATE, 2 * RATE));
        assert_eq!(number(40) as usize, bytes.len() - 44);
        let heard: Vec<i16> = bytes[44..]
            .chunks(2)
            .map(|pair| i16::from_le_bytes([pair[0], pair[1]]))
            .collect();
        let loudest = |from: f64, to: f64| {
            let [from, to] = [from, to].map(|seconds| (seconds * f64::from(RATE)) as usize);
            let part = heard[from..to.min(heard.len())].iter();
            part.map(|sample| sample.unsigned_abs()).max().unwrap()
        };
        assert!(loudest(0.0, 0.039) == 0 && loudest(0.05, 1.0) < 100);
        assert!(loudest(0.039, 0.05) > 10_000);
        let path = file.path().to_owned();
        drop(file);
        assert!(!path.exists(), "nothing is left of it");
    }
}
