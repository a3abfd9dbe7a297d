//! Floor 4: the one solver thread and its channels. The caller passes `wake`, called whenever something new can be received.

pub mod protocol;
mod run_loop;
pub mod session;

pub use run_loop::{Output, Worker};
