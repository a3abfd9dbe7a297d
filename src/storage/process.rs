//! What the system knows of this process.

use std::fs;

/// The signals that this process was told to ignore when it was started (`nohup`, `&` in a script),
/// as a mask: bit 0 is signal 1. Nothing where the system does not say.
pub fn ignored_signals() -> u64 {
    fs::read_to_string("/proc/self/status").map_or(0, |status| ignored_in(&status))
}

fn ignored_in(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_is_read_where_there_is_one() {
        assert_eq!(
            ignored_in("Name:\tx\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\n"),
            0x1001
        );
        assert_eq!([ignored_in(""), ignored_in("SigIgn:\tmany\n")], [0, 0]);
    }
}
