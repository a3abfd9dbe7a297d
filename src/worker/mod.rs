//! Floor 4: the solver thread, two that work beside it (measurements, the live loop), and their channels. The caller passes `wake`, called whenever something new can be received.

mod course;
pub mod crew;
mod live;
mod measure;
pub mod protocol;
mod run_loop;
pub mod session;

pub use run_loop::{Output, Worker};
