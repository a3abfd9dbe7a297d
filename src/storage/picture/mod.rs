//! Pictures: the gap as an image, and the scene inside a PNG.

mod gap;
mod metadata;

pub(super) use gap::gap_pixels;
pub use gap::{Scale, common_scale, gap_image, write_gap_png, write_gap_png_scaled};
pub(super) use metadata::{BYTES_MAX, is_png, scene_of};
pub use metadata::{attach_scene, load_scene};

use super::{Failure, files};
use image::{ImageFormat, RgbImage};
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
