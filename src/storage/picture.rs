//! Pictures: the gap field as an image (contact dark), and the scene inside a PNG, so that
//! a picture opens again as what it shows.
//!
//! A PNG is a signature and a row of chunks: length, name, data, checksum. The scene is one more,
//! uncompressed text (iTXt) under a keyword of its own, right after the header.

use super::{Failure, files, heights, scene_file, session};
use crate::physics::topography::Topography;
use crate::plot::scale::ends;
use crate::plot::style::Colours;
use crate::scene::Scene;
use image::{ImageFormat, Rgb, RgbImage};
use ndarray::Array2;
use std::io::Cursor;
use std::path::Path;

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

/// The scene of a regular file, told by its content and not by its name.
///
/// # Errors
/// A file that cannot be read, or that holds no allowed scene.
pub fn open_scene(path: &Path) -> Result<Scene, Failure> {
    scene_in(path, files::read_regular(path, session::BYTES_MAX)?)
}

/// The scene in the bytes of a file.
///
/// # Errors
/// What holds no allowed scene.
pub(super) fn scene_in(path: &Path, bytes: Vec<u8>) -> Result<Scene, Failure> {
    if is_png(&bytes) {
        scene_of(path, &bytes)
    } else if session::is_session(&bytes) {
        session::scene_of(path, &bytes)
    } else {
        scene_file::scene_of(path, bytes)
    }
}

/// What a file holds.
#[derive(Debug)]
pub enum Opened {
    /// A scene.
    Scene(Scene),
    /// The bytes of a session.
    Session(Vec<u8>),
    /// Measured heights.
    Heights(Topography),
}

/// The scene, session or heights of a regular file. A scene is a picture that holds one, a file
/// named `.toml`, or text with a line that begins with `format` or a bracket.
///
/// # Errors
/// A file that cannot be read, or that holds none of them.
pub fn open(path: &Path) -> Result<Opened, Failure> {
    let bytes = files::read_regular(path, session::BYTES_MAX)?;
    if is_png(&bytes) {
        let carried = chunks(&bytes).find(|(kind, _)| kind == SESSION);
        return match carried {
            Some((_, session)) => Ok(Opened::Session(session.to_vec())),
            None => scene_of(path, &bytes).map(Opened::Scene),
        };
    }
    let named = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let is_key = |line: &str| line.starts_with("format") || line.starts_with('[');
    let has_keys = || std::str::from_utf8(&bytes).is_ok_and(|text| text.lines().any(is_key));
    if session::is_session(&bytes) {
        Ok(Opened::Session(bytes))
    } else if named || has_keys() {
        scene_file::scene_of(path, bytes).map(Opened::Scene)
    } else {
        heights::of_bytes(path, &bytes).map(Opened::Heights)
    }
}

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
fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE)
}

/// The scene inside the bytes of a PNG.
///
/// # Errors
/// One without a scene, or with one that is not allowed.
fn scene_of(path: &Path, bytes: &[u8]) -> Result<Scene, Failure> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::presets;
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
        let preset = presets::find("fig2").unwrap();
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
}
