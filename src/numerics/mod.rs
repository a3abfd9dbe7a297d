//! Floor 0: two-dimensional real Fourier transforms, vector kernels, iterative linear algebra, the
//! cancel token.
//!
//! Nothing here knows a physical word. Fields are `ndarray` arrays in standard layout, row = y,
//! column = x. The forward transform carries the factor 1/N, so that an amplitude is in the unit of
//! its field.

pub mod cancel;
pub mod cosine;
pub mod eigen;
pub mod factor;
pub mod fourier;
pub mod functions;
pub mod krylov;
pub mod lanczos;
pub mod precision;
pub mod threads;
pub mod vector;
