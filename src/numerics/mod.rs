//! Floor 0: two-dimensional real Fourier transforms, dense vectors and small matrices, iterative linear
//! algebra, threads and the cancel token.
//!
//! Nothing here knows a physical word. Fields are `ndarray` arrays in standard layout, row = y,
//! column = x. The forward transform carries the factor 1/N, so that an amplitude is in the unit of
//! its field.

pub mod cosine;
pub mod dense;
pub mod eigen;
pub mod fourier;
pub mod functions;
pub mod krylov;
pub mod precision;
pub mod threads;
