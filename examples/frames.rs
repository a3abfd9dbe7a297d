//! How long the real window takes to its first snap, and for a frame while something is dragged: the
//! window opens, lowers the body, plays a loop, drags what is listed, prints milliseconds and closes.
//! Wants a display.
//!
//! Of frames the first number is what passes from the beginning of a frame to its last triangle (other
//! programs may take their share of it), the second what the window's own thread computes from frame
//! to frame; with a renderer in software the triangles are filled in threads beside it.

use cpu_time::ThreadTime;
use eframe::egui::{self, Event, Id, Key, Modifiers, PointerButton, Pos2, Vec2, pos2, vec2};
use std::error::Error;
use std::time::{Duration, Instant};
use tackscope::storage;
use tackscope::ui::view_state::ViewState;
use tackscope::ui::{App, begun, theme};

/// Frames of a drag, and of one way to and fro.
const FRAMES: usize = 240;
const PERIOD: f32 = 60.0;
/// Frames that are waited after a key, and at most for the solver.
const PAUSE: usize = 8;
const PATIENCE: usize = 20_000;

/// A line of the script.
enum Act {
    /// Press and release.
    Key(Modifiers, Key),
    /// Run what the palette of commands finds.
    Command(&'static str),
    /// Wait.
    Until(fn(&ViewState) -> bool),
    /// Print under this name when that was first shown, counted from the start of the program.
    Say(&'static str, fn(&ViewState) -> bool),
    /// Drag this widget down by so many points, one a frame.
    Lower(&'static str, usize),
    /// Open the fold of the left panel and bring this widget into sight.
    Unfold(&'static str),
    /// Drag this widget so far to and fro, under this name.
    Drag(&'static str, &'static str, Vec2),
}

fn script() -> Vec<Act> {
    use Act::{Command, Drag, Key as Press, Lower, Say, Unfold, Until};
    let rests = |state: &ViewState| !state.run.is_busy() && state.run.state.is_some();
    vec![
        Say("the surface", |state| state.frame.is_some()),
        Say("the live loop, as yet hidden", |state| {
            state.plots.live.is_some()
        }),
        Say("the surface at rest before its first jump", rests),
        Lower("profile", 20),
        Say("the first snap", |state| !state.run.record.jumps.is_empty()),
        Until(rests),
        Command("speed as fast"),
        Press(Modifiers::NONE, Key::Space),
        Until(|state| state.run.closed_loop.is_some()),
        Drag("strip, a loop behind it", "strip", vec2(150.0, 0.0)),
        Press(Modifiers::NONE, Key::Escape),
        Drag("u0", "driven_slider", vec2(0.0, 120.0)),
        Until(rests),
        Command("law mie"),
        Command("A | B: compare"),
        Until(|state| {
            state
                .beside()
                .is_some_and(|(beside, _)| beside.shown.is_ok())
        }),
        Drag("u0 of A | B", "driven_slider", vec2(0.0, 120.0)),
        Until(rests),
        Press(Modifiers::COMMAND, Key::Z),
        Unfold("mu_rho_slider"),
        Drag("mu_rho", "mu_rho_slider", vec2(25.0, 0.0)),
    ]
}

/// The window, its script, and the times of the frames under way.
struct Measured {
    app: App,
    script: Vec<Act>,
    /// The line that is played, and for how many frames.
    line: usize,
    frame: usize,
    /// Where a drag began.
    from: Pos2,
    times: [Vec<f64>; 2],
    begun: ThreadTime,
    /// When the program was started.
    started: Instant,
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

fn key(modifiers: Modifiers, key: Key) -> [Event; 2] {
    [true, false].map(|pressed| Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers,
    })
}

impl Measured {
    /// What happens in this frame; true when the line is done.
    fn play(&mut self, ctx: &egui::Context, events: &mut Vec<Event>) -> bool {
        let frame = self.frame;
        let place = |id: &'static str| ctx.read_response(Id::unique(id)).map(|found| found.rect);
        match &self.script[self.line] {
            Act::Key(modifiers, pressed) => {
                if frame == 0 {
                    events.extend(key(*modifiers, *pressed));
                }
                frame >= PAUSE
            }
            Act::Command(words) => {
                match frame {
                    0 => events.extend(key(Modifiers::COMMAND, Key::K)),
                    2 => events.push(Event::Text((*words).to_owned())),
                    4 => events.extend(key(Modifiers::NONE, Key::Enter)),
                    _ => {}
                }
                frame >= 4 + PAUSE
            }
            Act::Until(reached) => {
                assert!(frame < PATIENCE, "line {} waits in vain", self.line);
                // The events of this frame are seen in the next one.
                frame > PAUSE && reached(self.app.state())
            }
            Act::Say(name, reached) => {
                let is_reached = reached(self.app.state());
                if is_reached {
                    println!(
                        "{name}: {:.0} ms",
                        1e3 * self.started.elapsed().as_secs_f64()
                    );
                }
                is_reached
            }
            Act::Lower(id, by) => {
                if frame == 0 {
                    self.from = place(id).map_or(Pos2::ZERO, |rect| rect.center());
                }
                let at = self.from + vec2(0.0, frame.saturating_sub(1) as f32);
                events.push(Event::PointerMoved(at));
                if frame == 1 || frame == 1 + by {
                    events.push(button(at, frame == 1));
                }
                frame > *by
            }
            Act::Unfold(id) => {
                // The fold is the lowest thing of the panel that takes a click.
                let at = pos2(60.0, 770.0 - 6.0 * (frame / 4) as f32);
                let Some(rect) = place(id) else {
                    events.push(Event::PointerMoved(at));
                    match frame % 4 {
                        1 => events.push(button(at, true)),
                        2 => events.push(button(at, false)),
                        _ => {}
                    }
                    return false;
                };
                if rect.bottom() > 640.0 && frame < PATIENCE {
                    let phase = egui::TouchPhase::Move;
                    events.push(Event::PointerMoved(pos2(60.0, 400.0)));
                    events.push(Event::MouseWheel {
                        unit: egui::MouseWheelUnit::Point,
                        delta: vec2(0.0, -20.0),
                        phase,
                        modifiers: Modifiers::NONE,
                        source: egui::MouseWheelSource::Unknown,
                    });
                    return false;
                }
                frame >= PAUSE
            }
            Act::Drag(_, id, by) => {
                if frame == 0 {
                    self.from = place(id).map_or(Pos2::ZERO, |rect| rect.center());
                    events.push(Event::PointerMoved(self.from));
                } else if frame == 1 {
                    events.push(button(self.from, true));
                } else if frame < FRAMES {
                    let share = (std::f32::consts::TAU * frame as f32 / PERIOD).sin();
                    events.push(Event::PointerMoved(self.from + share * *by));
                } else if frame == FRAMES {
                    events.push(button(self.from, false));
                }
                frame >= FRAMES + PAUSE
            }
        }
    }

    /// Notes how long the last frame took; prints what a drag has taken at its end.
    fn note(&mut self, seconds: Option<f32>) {
        let computed = self.begun.elapsed();
        self.begun = ThreadTime::now();
        let Some(Act::Drag(name, ..)) = self.script.get(self.line) else {
            return;
        };
        if (3..FRAMES).contains(&self.frame) {
            self.times[0].push(1e3 * f64::from(seconds.unwrap_or_default()));
            self.times[1].push(1e3 * Duration::as_secs_f64(&computed));
        } else if self.frame == FRAMES {
            let [passed, computed] = std::mem::take(&mut self.times).map(|mut times| {
                let longest = times.iter().copied().fold(0.0, f64::max);
                let which = times.iter().position(|time| *time == longest);
                times.sort_by(f64::total_cmp);
                let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
                let which = which.unwrap_or_default();
                format!(
                    "{:.1} / {:.1} / {longest:.1} (frame {which})",
                    at(0.5),
                    at(0.95)
                )
            });
            println!("{name}: {passed} ms passed, {computed} ms computed");
        }
    }
}

impl eframe::App for Measured {
    fn raw_input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        input.focused = true;
        input.events.clear();
        let mut events = Vec::new();
        while self.line < self.script.len() {
            let done = self.play(ctx, &mut events);
            let says = matches!(self.script[self.line], Act::Say(..));
            (self.line, self.frame) = if done {
                (self.line + 1, 0)
            } else {
                (self.line, self.frame + 1)
            };
            // What is first shown together is told together.
            if !(done && says) {
                break;
            }
        }
        input.events.append(&mut events);
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.note(frame.info().cpu_usage);
        self.app.frame(ui);
        ui.ctx().request_repaint();
        if self.line == self.script.len() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    let preset = storage::preset("fig2").ok_or("fig2 is built in")?;
    let state = ViewState::at_first_jump(preset.scene()?)?;
    println!("median / of 20 the longest but one / longest");
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([1280.0, 800.0]),
        renderer: eframe::Renderer::Glow,
        ..Default::default()
    };
    let (app, tell) = begun(state);
    let create: eframe::AppCreator<'_> = Box::new(|cc| {
        theme::install(&cc.egui_ctx);
        tell(&cc.egui_ctx);
        Ok(Box::new(Measured {
            app,
            script: script(),
            line: 0,
            frame: 0,
            from: Pos2::ZERO,
            times: Default::default(),
            begun: ThreadTime::now(),
            started,
        }))
    });
    eframe::run_native("frames", options, create)?;
    Ok(())
}
