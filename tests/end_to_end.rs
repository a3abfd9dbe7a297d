//! The real binary in a real window on a virtual screen: it opens before the first jump, the body is
//! dragged through it, the picture shows it.
//!
//! Needs a display, xdotool and ImageMagick; without them it says so and passes, unless
//! TACKSCOPE_REQUIRE_DISPLAY is set (as in CI).
#![cfg(feature = "gui")]

use image::RgbImage;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The window; killed if a test fails, so that nothing is left behind.
struct Window(Child);

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a tool and returns what it printed, or `None` if it is missing or fails.
fn tool(name: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(name)
        .args(arguments)
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

fn xdotool(arguments: &str) {
    let arguments: Vec<_> = arguments.split_whitespace().collect();
    assert!(
        tool("xdotool", &arguments).is_some(),
        "xdotool {arguments:?}"
    );
}

/// A memory of the window in which every number is out of bounds.
const HOSTILE: &str = r#"{
    "window": "(normal_geometry:(outer_position_pixels:Some((x:90000.0,y:-70000.0)),scale_factor:1.0,inner_size_points:(x:1e9,y:NaN)),fullscreen:false,maximized:false)",
    "egui": "(options:(zoom_factor:1000000.0))",
}"#;

/// Why the test cannot run here.
fn missing() -> Option<&'static str> {
    if std::env::var_os("DISPLAY").is_none() {
        Some("there is no display")
    } else if tool("xdotool", &["version"]).is_none() {
        Some("xdotool is not installed")
    } else if tool("import", &["-version"]).is_none() {
        Some("ImageMagick is not installed")
    } else {
        None
    }
}

fn screenshot(path: &Path) -> RgbImage {
    tool("import", &["-window", "root", path.to_str().unwrap()]).expect("a screenshot");
    image::open(path).expect("a picture").to_rgb8()
}

/// Repeats `look` until it gives something, at most 20 s.
fn await_some<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(
            begin.elapsed() < Duration::from_secs(20),
            "{what} did not come"
        );
        sleep(Duration::from_millis(100));
    }
}

/// Largest difference of brightness within the upper half of the gap map, in the middle of the
/// window: above the profile line, where a uniform gap has one colour.
fn contrast_of_the_map(picture: &RgbImage) -> u32 {
    let brightness: Vec<u32> = (110..250)
        .step_by(10)
        .flat_map(|y| (400..740).step_by(10).map(move |x| (x, y)))
        .map(|(x, y)| {
            picture
                .get_pixel(x, y)
                .0
                .iter()
                .map(|c| u32::from(*c))
                .sum()
        })
        .collect();
    brightness.iter().max().unwrap() - brightness.iter().min().unwrap()
}

#[test]
fn a_stranger_drags_u0_down_in_the_real_window_and_sees_the_surface_jump() {
    if let Some(reason) = missing() {
        assert!(
            std::env::var_os("TACKSCOPE_REQUIRE_DISPLAY").is_none(),
            "required, yet {reason}"
        );
        println!("skipped: {reason}");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // What an earlier run may have left: a place far off any screen, a zoom that shows nothing.
    let memory = folder.path().join("tackscope");
    std::fs::create_dir(&memory).unwrap();
    std::fs::write(memory.join("app.ron"), HOSTILE).unwrap();
    let begun = Instant::now();
    let child = Command::new(env!("CARGO_BIN_EXE_tackscope"))
        .env("HOME", folder.path())
        .env("XDG_DATA_HOME", folder.path())
        // Of a session that is gone, beside a display that is there.
        .env("WAYLAND_DISPLAY", "wayland-gone")
        .env_remove("WAYLAND_SOCKET")
        .stdin(Stdio::null())
        .spawn()
        .unwrap();
    let pid = child.id().to_string();
    let mut window = Window(child);
    let id = await_some("the window", || {
        tool(
            "xdotool",
            &[
                "search",
                "--onlyvisible",
                "--all",
                "--pid",
                &pid,
                "--name",
                "^Tackscope",
            ],
        )
    });
    let id = id.lines().next().unwrap().to_owned();
    xdotool(&format!("windowmove {id} 0 0"));
    xdotool(&format!("windowfocus {id}"));
    let path = folder.path().join("shot.png");
    // At rest the map shows one colour. The first frames may show less.
    let lit = |picture: &RgbImage| {
        picture
            .get_pixel(560, 400)
            .0
            .iter()
            .map(|c| u32::from(*c))
            .sum::<u32>()
            > 60
    };
    await_some("a uniform map", || {
        Some(screenshot(&path)).filter(|p| lit(p) && contrast_of_the_map(p) < 20)
    });

    // One gesture: the elastomer by its grip, one step of the mouse a frame.
    xdotool("mousemove 548 578 mousedown 1");
    for y in 579..600 {
        xdotool(&format!("mousemove 548 {y}"));
        sleep(Duration::from_millis(10));
    }
    xdotool("mouseup 1");
    let picture = await_some("a pattern", || {
        Some(screenshot(&path)).filter(|p| contrast_of_the_map(p) > 150)
    });
    println!(
        "first snap after one gesture, {:.1} s from the start",
        begun.elapsed().as_secs_f64()
    );
    assert_eq!(picture.dimensions(), (1280, 800));

    xdotool("key --clearmodifiers ctrl+q");
    let status = await_some("the end", || window.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
}
