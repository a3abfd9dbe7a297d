//! Opening the window, and saying in one line why it cannot be opened.
//!
//! What the window remembers of itself between two runs (the toolkit's `app.ron`) is checked before it
//! is believed. A zoom of a million, sizes that are no numbers, a place on a screen that is gone, a
//! pipe under the file's name: each alone would leave a window that cannot be used. What is not sane is
//! forgotten. Where the window stands is the window manager's to say.

use super::app::App;
use super::theme;
use super::view_state::ViewState;
use crate::scene::Scene;
use crate::storage::{self, files, read_regular, remove, scene_file};
use crate::worker::Worker;
use eframe::EventLoopBuilderHook;
use egui::Context;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
#[cfg(all(unix, not(target_os = "macos")))]
use winit::platform::x11::EventLoopBuilderExtX11;

/// The window's name for the desktop, and of the folder of its memory.
const APP_ID: &str = "tackscope";

/// The smallest window (points): it fits on any screen, and everything scrolls into view.
const LEAST: [f32; 2] = [480.0, 320.0];

/// Libraries that winit loads at run time on X11, and the Debian packages they come in.
const X11_LIBRARIES: [(&str, &str); 6] = [
    ("libX11.so.6", "libx11-6"),
    ("libX11-xcb.so.1", "libx11-xcb1"),
    ("libXcursor.so.1", "libxcursor1"),
    ("libXi.so.6", "libxi6"),
    ("libxkbcommon.so.0", "libxkbcommon0"),
    ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
];

/// Whether a window can be opened here, as far as can be known without trying.
///
/// # Errors
/// One line that says what is missing.
pub fn display_available() -> Result<(), String> {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return Ok(());
    }
    match (wayland(), is_set("DISPLAY")) {
        (Wayland::Answers, _) => return Ok(()),
        (Wayland::Silent, false) => {
            return Err(
                "no display: nothing answers at WAYLAND_DISPLAY, and DISPLAY is not set".to_owned(),
            );
        }
        (Wayland::None, false) => {
            return Err("no display: neither WAYLAND_DISPLAY nor DISPLAY is set".to_owned());
        }
        (_, true) => {}
    }
    match missing_library() {
        Some((library, package)) => Err(no_library(library, package)),
        None => Ok(()),
    }
}

fn is_set(name: &str) -> bool {
    std::env::var_os(name).is_some_and(|value| !value.is_empty())
}

/// What is known of a Wayland display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wayland {
    /// None is named.
    None,
    /// One is named that does not answer: a variable that outlived its session.
    Silent,
    /// It takes connections.
    Answers,
}

#[cfg(unix)]
fn wayland() -> Wayland {
    if is_set("WAYLAND_SOCKET") {
        return Wayland::Answers;
    }
    let Some(name) = std::env::var_os("WAYLAND_DISPLAY").filter(|name| !name.is_empty()) else {
        return Wayland::None;
    };
    // An absolute name stands for itself.
    let socket = Path::new(&std::env::var_os("XDG_RUNTIME_DIR").unwrap_or_default()).join(name);
    if std::os::unix::net::UnixStream::connect(socket).is_ok() {
        Wayland::Answers
    } else {
        Wayland::Silent
    }
}

#[cfg(not(unix))]
fn wayland() -> Wayland {
    Wayland::None
}

/// The toolkit tries Wayland alone where it is named: past one that does not answer it is sent to
/// X11.
fn past_a_silent_wayland() -> Option<EventLoopBuilderHook> {
    #[cfg(all(unix, not(target_os = "macos")))]
    if wayland() == Wayland::Silent && is_set("DISPLAY") {
        return Some(Box::new(|builder| {
            EventLoopBuilderExtX11::with_x11(builder);
        }));
    }
    None
}

fn no_library(library: &str, package: &str) -> String {
    format!("the window needs {library}, which is not installed (on Debian: apt install {package})")
}

/// The first X11 library that lies in none of the usual folders, provided one of its sisters does:
/// on a system that keeps its libraries elsewhere nothing can be told, and trying decides.
fn missing_library() -> Option<(&'static str, &'static str)> {
    let mut folders: Vec<String> = std::env::var("LD_LIBRARY_PATH")
        .unwrap_or_default()
        .split(':')
        .map(str::to_owned)
        .collect();
    let triple = format!("{}-linux-gnu", std::env::consts::ARCH);
    for root in ["/usr/lib", "/lib", "/usr/local/lib"] {
        folders.extend([
            format!("{root}/{triple}"),
            format!("{root}64"),
            root.to_owned(),
        ]);
    }
    let present = |library: &str| {
        folders
            .iter()
            .any(|folder| !folder.is_empty() && Path::new(folder).join(library).exists())
    };
    let missing: Vec<_> = X11_LIBRARIES
        .into_iter()
        .filter(|(library, _)| !present(library))
        .collect();
    if missing.len() == X11_LIBRARIES.len() {
        None
    } else {
        missing.first().copied()
    }
}

/// Opens the window on the first preset and returns when it is closed.
///
/// # Errors
/// One line that says why it could not be opened.
pub fn run() -> Result<(), String> {
    display_available()?;
    let state = ViewState::at_first_jump(opening_scene()?);
    let state = state.map_err(|error| error.to_string())?;
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Tackscope")
            .with_app_id(APP_ID)
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size(LEAST),
        renderer: eframe::Renderer::Glow,
        event_loop_builder: past_a_silent_wayland(),
        ..Default::default()
    };
    if let Some(folder) = eframe::storage_dir(APP_ID) {
        mend(&folder.join("app.ron"));
    }
    let (mut app, tell) = begun(state);
    let opened = Arc::new(AtomicBool::new(false));
    let seen = opened.clone();
    // winit panics where a library of the window system is missing or the connection breaks at the
    // start.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        eframe::run_native(
            "Tackscope",
            native,
            Box::new(move |cc| {
                seen.store(true, Ordering::Relaxed);
                theme::install(&cc.egui_ctx);
                tell(&cc.egui_ctx);
                if let Some(storage) = cc.storage {
                    app.resume(&cc.egui_ctx, storage);
                }
                Ok(Box::new(app))
            }),
        )
    }));
    match outcome {
        Ok(result) => result.map_err(|error| format!("the window cannot be opened: {error}")),
        Err(panic) if opened.load(Ordering::Relaxed) => resume_unwind(panic),
        Err(panic) => Err(in_words(
            panic
                .downcast_ref::<String>()
                .map_or("the window system failed", String::as_str),
        )),
    }
}

fn in_words(panic: &str) -> String {
    match X11_LIBRARIES.iter().rev().find(|(library, _)| {
        panic.contains(library.trim_end_matches(|c: char| c == '.' || c.is_ascii_digit()))
    }) {
        Some((library, package)) => no_library(library, package),
        None => format!("the window cannot be opened: {panic}"),
    }
}

/// The application on this state, its solver at work before there is a window; and whom to tell of
/// the window once there is one.
pub fn begun(state: ViewState) -> (App, impl FnOnce(&Context)) {
    let window = Arc::new(OnceLock::<Context>::new());
    let known = window.clone();
    // What is found before the first frame waits for it.
    let worker = Worker::spawn(move || known.get().iter().for_each(|ctx| ctx.request_repaint()));
    let mut app = App::new(worker, state);
    app.send();
    let tell = move |ctx: &Context| {
        let _ = window.set(ctx.clone());
    };
    (app, tell)
}

/// The preset the window opens with.
fn opening_scene() -> Result<Scene, String> {
    let preset = storage::preset("fig2")
        .or_else(|| storage::presets().first())
        .ok_or("no preset is built in")?;
    scene_file::parse(preset.text, preset.name).map_err(|failure| failure.to_string())
}

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

/// Mends the memory of the last run, if there is one that needs it.
fn mend(path: &Path) {
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

    #[test]
    fn a_panic_about_a_library_names_the_debian_package() {
        let words = in_words("Library libxkbcommon-x11.so could not be loaded.");
        assert!(words.contains("apt install libxkbcommon-x11-0"), "{words}");
        assert!(in_words("Library libXcursor.so.1 ...").contains("libxcursor1"));
        assert!(in_words("something else").contains("something else"));
    }

    #[test]
    fn the_window_opens_on_fig2() {
        assert!(opening_scene().unwrap().title.contains('2'));
    }

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
