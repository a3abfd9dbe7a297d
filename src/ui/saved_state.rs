//! What the window remembers of itself between two runs (the toolkit's `app.ron`), checked before
//! it is believed.
//!
//! A zoom of a million, sizes that are no numbers, a place on a screen that is gone, a pipe under
//! the file's name: each alone would leave a window that cannot be used. What is not sane is
//! forgotten. Where the window stands is the window manager's to say.

use crate::storage::{files, read_regular, remove};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Longest file that is believed, in bytes.
const BYTES_MAX: u64 = 1 << 20;
/// Smallest and largest zoom.
const ZOOM: std::ops::RangeInclusive<f32> = 0.4..=4.0;
/// Smallest and largest side of the window (points).
const SIDE: std::ops::RangeInclusive<f32> = 100.0..=16_384.0;
/// Smallest and largest scale of a screen.
const SCALE: std::ops::RangeInclusive<f32> = 0.25..=8.0;

/// The toolkit's words for the window.
#[derive(Serialize, Deserialize)]
struct Window {
    normal_geometry: Geometry,
    fullscreen: bool,
    maximized: bool,
}

#[derive(Serialize, Deserialize)]
struct Geometry {
    outer_position_pixels: Option<egui::Pos2>,
    scale_factor: f32,
    inner_size_points: egui::Vec2,
}

/// Mends the file, if there is one that needs it.
pub fn mend(path: &Path) {
    let Ok(bytes) = read_regular(path, BYTES_MAX) else {
        return remove(path);
    };
    let text = String::from_utf8_lossy(&bytes);
    let mended = mended(&text);
    if mended != text {
        // Where it cannot be written it cannot be believed either.
        if files::write_whole(path, mended.as_bytes()).is_err() {
            remove(path);
        }
    }
}

/// The text without what is not sane.
fn mended(text: &str) -> String {
    let Ok(mut entries) = ron::from_str::<BTreeMap<String, String>>(text) else {
        return String::new();
    };
    let before = entries.clone();
    if let Some(window) = entries.remove("window").as_deref().and_then(window) {
        entries.insert("window".to_owned(), window);
    }
    if entries.get("egui").is_some_and(|memory| !is_sane(memory)) {
        entries.remove("egui");
    }
    if entries == before {
        text.to_owned()
    } else {
        ron::to_string(&entries).unwrap_or_default()
    }
}

/// The window's entry without its place; `None` if its numbers are not sane.
fn window(text: &str) -> Option<String> {
    let mut window: Window = ron::from_str(text).ok()?;
    let Geometry {
        outer_position_pixels,
        scale_factor,
        inner_size_points: size,
    } = &mut window.normal_geometry;
    if !(SCALE.contains(scale_factor) && SIDE.contains(&size.x) && SIDE.contains(&size.y)) {
        return None;
    }
    if outer_position_pixels.take().is_none() {
        return Some(text.to_owned());
    }
    ron::to_string(&window).ok()
}

/// True if every number of the toolkit's memory is one, and the zoom leaves something to be seen.
fn is_sane(text: &str) -> bool {
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    let no_number = |word: &str| ["nan", "inf"].contains(&word.to_ascii_lowercase().as_str());
    let memory = ron::from_str::<egui::Memory>(text);
    !words.into_iter().any(no_number)
        && memory.is_ok_and(|memory| ZOOM.contains(&memory.options.zoom_factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Pos2, Vec2, pos2, vec2};

    fn entry(at: Option<Pos2>, scale_factor: f32, size: Vec2) -> String {
        let normal_geometry = Geometry {
            outer_position_pixels: at,
            scale_factor,
            inner_size_points: size,
        };
        ron::to_string(&Window {
            normal_geometry,
            fullscreen: false,
            maximized: true,
        })
        .unwrap()
    }

    fn memory(zoom: f32) -> String {
        let mut memory = egui::Memory::default();
        memory.options.zoom_factor = zoom;
        ron::to_string(&memory).unwrap()
    }

    fn saved(window: &str, memory: &str) -> String {
        let entries = [("window", window), ("egui", memory)]
            .map(|(key, value)| (key.to_owned(), value.to_owned()));
        ron::to_string(&BTreeMap::from(entries)).unwrap()
    }

    fn kept(text: &str) -> Vec<String> {
        ron::from_str::<BTreeMap<String, String>>(&mended(text))
            .map(|entries| entries.into_keys().collect())
            .unwrap_or_default()
    }

    #[test]
    fn a_sane_memory_is_left_as_it_is_but_for_the_place_of_the_window() {
        let size = vec2(1280.0, 800.0);
        let text = saved(&entry(None, 1.0, size), &memory(1.25));
        assert_eq!(mended(&text), text);
        let placed = saved(&entry(Some(pos2(90_000.0, -7.0)), 1.0, size), &memory(1.25));
        assert_eq!(mended(&placed), text);
    }

    #[test]
    fn what_is_not_sane_is_forgotten_and_the_rest_kept() {
        let good = entry(None, 1.0, vec2(1280.0, 800.0));
        for zoom in [0.0, -1.0, 1e-9, 1e6, f32::NAN, f32::INFINITY] {
            assert_eq!(kept(&saved(&good, &memory(zoom))), ["window"], "{zoom}");
        }
        for size in [
            vec2(f32::NAN, 800.0),
            vec2(1.0, 1.0),
            vec2(1e9, 1e9),
            vec2(1280.0, f32::INFINITY),
            vec2(-5.0, 3.0),
        ] {
            assert_eq!(
                kept(&saved(&entry(None, 1.0, size), &memory(1.0))),
                ["egui"],
                "{size}"
            );
        }
        for scale in [0.0, f32::NAN, 1e9] {
            assert_eq!(
                kept(&saved(
                    &entry(None, scale, vec2(640.0, 480.0)),
                    &memory(1.0)
                )),
                ["egui"],
                "{scale}"
            );
        }
        assert_eq!(kept(&saved("(what is this", "{{{{")), [""; 0]);
        assert_eq!(kept("no ron at all"), [""; 0]);
    }
}
