//! Memory that is freed and wanted again at once.

use std::hint::black_box;
use std::sync::Once;

/// Size of the largest block that raises the threshold of glibc when it is freed is 32 MiB: just
/// below.
const LARGE: usize = 31 << 20;

/// Makes the allocator keep freed vectors instead of handing them back to the system.
///
/// Every increment makes and drops dozens of vectors. The GNU C library returns what is freed at
/// once, until it has seen a larger block freed; that the system must clear each page anew then
/// took longer than the arithmetic. The block here is never touched and so costs nothing; with
/// other allocators nothing happens.
pub fn keep_freed() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| drop(black_box(Vec::<u8>::with_capacity(LARGE))));
}
