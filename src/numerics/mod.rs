//! Floor 0: two-dimensional real Fourier transforms, vector kernels, iterative linear algebra, random numbers, the cancel token.
//!
//! Nothing here knows a physical word. Fields are `ndarray` arrays in standard layout, row = y, column = x.

pub mod cancel;
