//! Floor 4: the solver thread, the thread for measurements beside it, and their channels. The caller passes `wake`, called whenever something new can be received.

mod measure;
pub mod protocol;
mod run_loop;
pub mod session;

pub use run_loop::{Output, Worker};
