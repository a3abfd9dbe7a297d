//! Floor 7: the only threads and channels. The solver's thread and the live loop's beside it,
//! background jobs (measurements, the paper's figures, whatever else takes its time), the player of
//! a sound, and the signals that ask the process to end. The caller passes `wake`, called whenever
//! something new can be received. Names no window, writes no files.

pub mod background;
pub mod job;
pub mod protocol;
pub mod session;

mod run_loop;
mod system;

pub use protocol::SolverHandle;
pub use run_loop::{Worker, rehearse};
pub use system::{cancel_on_signal, play};
