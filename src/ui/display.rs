//! Opening the window, and saying in one line why it cannot be opened.

use super::app::App;
use super::saved_state;
use super::theme;
use super::view_state::ViewState;
use crate::scene::Scene;
use crate::storage::{presets, scene_file};
use crate::worker::Worker;
use eframe::EventLoopBuilderHook;
use egui::Context;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
#[cfg(all(unix, not(target_os = "macos")))]
use winit::platform::x11::EventLoopBuilderExtX11;

/// What the window opens with.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The scene; the preset `fig2` if none.
    pub scene: Option<Scene>,
}

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
    run_with(Options::default())
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// One line that says why it could not be opened.
pub fn run_with(options: Options) -> Result<(), String> {
    display_available()?;
    let state = match options.scene {
        Some(scene) => ViewState::new(scene),
        None => ViewState::at_first_jump(opening_scene()?),
    };
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
        saved_state::mend(&folder.join("app.ron"));
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
    let preset = presets::find("fig2")
        .or_else(|| presets::all().first())
        .ok_or("no preset is built in")?;
    scene_file::parse(preset.text, preset.name).map_err(|failure| failure.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
