//! Every figure of the paper, and what is found in it.

mod figures;
mod findings;
