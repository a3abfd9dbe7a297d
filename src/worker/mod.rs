//! Floor 6: the solver thread, three that work beside it (measurements, the live loop, the paper's figures), and their channels; and the signals that ask the process to end. The caller passes `wake`, called whenever something new can be received.

mod aside;
mod course;
pub mod crew;
mod end;
pub mod job;
mod live;
mod measure;
mod paper;
pub mod protocol;
mod run_loop;
pub mod session;
pub mod signals;

pub use protocol::Output;
pub use run_loop::Worker;
