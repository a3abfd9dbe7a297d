//! The scene inside a PNG, so that a picture opens again as what it shows.
//!
//! A PNG is a signature and a row of chunks: length, name, data, checksum. The scene is one more,
//! uncompressed text (iTXt) under a keyword of its own, right after the header.

use crate::scene::Scene;
use crate::storage::{Failure, files, scene_file};
use std::path::Path;

/// Keyword of the chunk.
const KEYWORD: &[u8] = b"tackscope-scene";
/// What every PNG begins with.
const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// Signature and header chunk, which every PNG has at the same length.
const HEADER: usize = 8 + 12 + 13;
/// Largest picture that is read, in bytes.
pub(in crate::storage) const BYTES_MAX: u64 = 1 << 26;

/// Puts the scene into a PNG that has been written.
///
/// # Errors
/// A file that cannot be read, is no PNG, or cannot be written.
pub fn attach_scene(path: &Path, scene: &Scene) -> Result<(), Failure> {
    let mut bytes = read(path)?;
    let mut data = KEYWORD.to_vec();
    // End of keyword; not compressed, method 0; no language; no translated keyword.
    data.extend([0, 0, 0, 0, 0]);
    data.extend(scene_file::to_text(scene).bytes());
    bytes.splice(HEADER..HEADER, chunk(b"iTXt", &data));
    files::write_whole(path, &bytes)
}

/// The scene inside a PNG.
///
/// # Errors
/// A file that cannot be read, is no PNG, has no scene in it, or one that is not allowed.
pub fn load_scene(path: &Path) -> Result<Scene, Failure> {
    scene_of(path, &read(path)?)
}

/// True if this is the beginning of a PNG.
pub(in crate::storage) fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE)
}

/// The scene inside the bytes of a PNG.
///
/// # Errors
/// One without a scene, or with one that is not allowed.
pub(in crate::storage) fn scene_of(path: &Path, bytes: &[u8]) -> Result<Scene, Failure> {
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
            Err(refused(
                path,
                &reason,
                "open a picture that this program has written",
            ))
        }
        Some(text) => scene_file::parse(text, &name),
        None => Err(refused(
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
    Err(refused(
        path,
        "not a PNG",
        "check that this is the picture you mean",
    ))
}

fn refused(path: &Path, reason: &str, remedy: &str) -> Failure {
    Failure::Read {
        file: path.display().to_string(),
        reason: reason.to_owned(),
        remedy: remedy.to_owned(),
    }
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
    let checksum = crc(&bytes[4..]);
    bytes.extend(checksum.to_be_bytes());
    bytes
}

/// The checksum of PNG chunks (CRC-32 of ISO 3309), bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| {
            if c & 1 == 1 {
                0xedb8_8320 ^ (c >> 1)
            } else {
                c >> 1
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::picture::write_gap_png;
    use crate::storage::presets;
    use ndarray::Array2;

    #[test]
    fn the_checksum_is_the_one_of_the_standard() {
        // The end chunk of every PNG.
        assert_eq!(crc(b"IEND"), 0xae42_6082);
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
        )
        .unwrap();
        let before = image::open(&path).unwrap().into_rgb8();
        assert!(
            load_scene(&path)
                .unwrap_err()
                .to_string()
                .contains("no scene")
        );
        attach_scene(&path, &scene).unwrap();
        assert_eq!(load_scene(&path).unwrap(), scene);
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
            assert!(load_scene(&path).is_err(), "{bytes:?}");
        }
    }
}
