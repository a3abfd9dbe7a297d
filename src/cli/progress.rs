//! What a run says while it goes: a bar on a terminal, plain lines otherwise, both on standard
//! error.

use super::tell;
use crate::follow::record::{JumpRecord, StateRecord};
use crate::follow::run::Report;
use crate::plot::ticks::digits;
use crate::scene::units::fixed;
use crate::storage::line;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;

/// Resolution of the bar.
const TICKS: u64 = 1000;

/// Listens to a walk and tells the user.
pub(super) enum Monitor {
    /// `--quiet`.
    Silent,
    /// A terminal.
    Bar(ProgressBar),
    /// A file or a pipe: a line per jump and every tenth of the way.
    Lines {
        /// Tenths already told.
        tenths: u64,
    },
}

impl Monitor {
    /// The fitting monitor, which at once says what begins.
    pub(super) fn new(quiet: bool, heading: &str) -> Self {
        if quiet {
            return Monitor::Silent;
        }
        if !std::io::stderr().is_terminal() {
            tell(heading);
            return Monitor::Lines { tenths: 0 };
        }
        let bar =
            ProgressBar::with_draw_target(Some(TICKS), ProgressDrawTarget::stderr_with_hz(15));
        let style =
            ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}, {eta} left  {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.println(line(heading));
        Monitor::Bar(bar)
    }

    /// Tells one piece of news, u0 to a hundredth of the drive's `step`.
    pub(super) fn tell(&mut self, news: &Report<'_>, step: f64) {
        match news {
            Report::Jump(jump) => self.note(&jump_words(jump, step)),
            Report::State {
                record, fraction, ..
            } => self.reached(*fraction, || state_words(record, step), String::new),
        }
    }

    /// Moves the bar, with `words` beside it; in lines says them and what is `left` every tenth of
    /// the way.
    fn reached(&mut self, fraction: f64, words: impl Fn() -> String, left: impl Fn() -> String) {
        match self {
            Monitor::Silent => {}
            Monitor::Bar(_) => {
                self.fraction(fraction);
                self.now(&words());
            }
            Monitor::Lines { tenths } => {
                let reached = (fraction.clamp(0.0, 1.0) * 10.0 + 1e-9) as u64;
                if reached > *tenths {
                    *tenths = reached;
                    tell(&format!("{:>3} %  {}{}", 10 * reached, words(), left()));
                }
            }
        }
    }

    /// Says what is being done, where there is a bar.
    pub(super) fn now(&self, words: &str) {
        if let Monitor::Bar(bar) = self {
            bar.set_message(line(words));
        }
    }

    /// Moves the bar, where there is one.
    pub(super) fn fraction(&self, fraction: f64) {
        if let Monitor::Bar(bar) = self {
            bar.set_position((fraction.clamp(0.0, 1.0) * TICKS as f64) as u64);
        }
    }

    /// Tells how many loops of so many are done after so many `seconds`, and which share of the work
    /// that is expected to be.
    pub(super) fn loops(&mut self, [done, of]: [usize; 2], fraction: f64, seconds: f64) {
        let left = || {
            let left = (seconds * (1.0 / fraction - 1.0)).max(0.0);
            format!(", {} left", HumanDuration(Duration::from_secs_f64(left)))
        };
        self.reached(fraction, || format!("{done} of {of} loops"), left);
    }

    /// Says something that stays.
    pub(super) fn note(&self, words: &str) {
        match self {
            Monitor::Silent => {}
            Monitor::Bar(bar) => bar.println(line(words)),
            Monitor::Lines { .. } => tell(words),
        }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        if let Monitor::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn state_words(state: &StateRecord, step: f64) -> String {
    format!(
        "{} at u0 = {}: {}",
        state.direction,
        digits(state.mean_displacement, 0.01 * step),
        state.pattern
    )
}

fn jump_words(jump: &JumpRecord, step: f64) -> String {
    format!(
        "jump   {} at u0 = {}: {} to {}, released {} gamma ({})",
        jump.direction,
        digits(jump.mean_displacement, 0.01 * step),
        jump.from,
        jump.to,
        fixed(jump.released_energy, 4),
        jump.cause_words()
    )
}
