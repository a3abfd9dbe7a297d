//! The paper's figures for the window, computed at the quick size beside the walk.

use super::aside::Aside;
use super::protocol::{Event, Page, PaperNews};
use crate::numerics::cancel::Cancel;
use crate::paper::errata::errata;
use crate::paper::overlay::ZeroRange;
use crate::paper::{GALLERY, Size, Stopped, Task};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between two words on the progress.
const PACE: Duration = Duration::from_millis(80);

/// Starts the thread.
pub(super) fn spawn(tell: impl Fn(Event) + Send + Sync + 'static) -> Aside<Page> {
    Aside::spawn("paper", move |page, cancel| {
        let tell = |news| tell(Event::Paper { page, news });
        let computed = catch_unwind(AssertUnwindSafe(|| compute(page, &tell, cancel)));
        match computed.unwrap_or_else(|_| Err(Stopped::Failed("the computation stopped with a fault of its own".to_owned()))) {
            Ok(news) => tell(news),
            Err(Stopped::Cancelled) => {}
            Err(Stopped::Failed(why)) => tell(PaperNews::Stuck(why)),
        }
    })
}

fn compute(page: Page, tell: &(dyn Fn(PaperNews) + Sync), cancel: &Cancel) -> Result<PaperNews, Stopped> {
    let mut told: Option<Instant> = None;
    let mut observe = |done: f64, what: &str| {
        if !cancel.requested() && told.is_none_or(|at| at.elapsed() >= PACE) {
            told = Some(Instant::now());
            tell(PaperNews::Progress { done, what: what.to_owned() });
        }
    };
    let mut task = Task::new(Size::Quick, cancel, &mut observe);
    match page {
        Page::Figure(number) => match GALLERY.iter().find(|entry| entry.number == number) {
            Some(entry) => (entry.compute)(&mut task).map(|figure| PaperNews::Figure(Arc::new(figure))),
            None => Err(Stopped::Failed(format!("there is no Fig. {number}"))),
        },
        Page::Errata => errata(&mut task).map(|list| PaperNews::Errata(Arc::new(list))),
        Page::Theory => {
            task.tell(0.0, "curves of zero range")?;
            ZeroRange::compute(cancel).map(|theory| PaperNews::Theory(Arc::new(theory))).ok_or(Stopped::Cancelled)
        }
    }
}
