//! The click of a jump, as a file that programs which play sounds take.

use std::f64::consts::TAU;
use std::io::{self, Write};
use tempfile::{Builder, NamedTempFile};

/// Samples a second, the lowest that every device takes.
const RATE: u32 = 44_100;
/// The tone (Hz), and the time in which it fades by a factor e (seconds): a tick of a few milliseconds.
const TONE: f64 = 1_600.0;
const FADE: f64 = 0.0015;
/// Silence before it, and all of it (seconds): a server of sound may swallow the first milliseconds of
/// a stream (PulseAudio 16: eight), and a player end before the last are heard.
const LEAD: f64 = 0.04;
const LENGTH: f64 = 0.12;
/// Its first sample as a share of the largest that there is.
const LOUDNESS: f64 = 0.6;

/// The click in a temporary file, which is there as long as this.
///
/// # Errors
/// There is no folder for temporary files, or no room in it.
pub fn file() -> io::Result<NamedTempFile> {
    let mut file = Builder::new()
        .prefix("tackscope-click-")
        .suffix(".wav")
        .tempfile()?;
    file.write_all(&wav(&samples()))?;
    file.flush()?;
    Ok(file)
}

fn samples() -> Vec<i16> {
    let count = (LENGTH * f64::from(RATE)) as u32;
    let times = (0..count).map(|k| f64::from(k) / f64::from(RATE));
    let wave = |t: f64| match t - LEAD {
        t if t < 0.0 => 0.0,
        t => LOUDNESS * (-t / FADE).exp() * (TAU * TONE * t).cos(),
    };
    times
        .map(|t| (wave(t) * f64::from(i16::MAX)) as i16)
        .collect()
}

/// One channel of 16 bits a sample as a WAV file.
fn wav(samples: &[i16]) -> Vec<u8> {
    const FORMAT: u32 = 16;
    let bytes = 2 * samples.len() as u32;
    let mut file = b"RIFF".to_vec();
    file.extend((4 + 8 + FORMAT + 8 + bytes).to_le_bytes());
    file.extend(b"WAVEfmt ");
    file.extend(FORMAT.to_le_bytes());
    // Plain samples, one channel.
    file.extend([1, 0, 1, 0]);
    file.extend(RATE.to_le_bytes());
    file.extend((2 * RATE).to_le_bytes());
    // Bytes and bits of a sample.
    file.extend([2, 0, 16, 0]);
    file.extend(b"data");
    file.extend(bytes.to_le_bytes());
    file.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the layout of the format: every length where a reader looks for it.
    #[test]
    fn the_click_is_a_wav_file_with_a_tick_of_ten_milliseconds_between_two_silences() {
        let file = file().unwrap();
        let bytes = std::fs::read(file.path()).unwrap();
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(
            [&bytes[..4], &bytes[8..16], &bytes[36..40]],
            [&b"RIFF"[..], b"WAVEfmt ", b"data"]
        );
        assert_eq!(number(4) as usize, bytes.len() - 8);
        assert_eq!((number(16), number(24), number(28)), (16, RATE, 2 * RATE));
        assert_eq!(number(40) as usize, bytes.len() - 44);
        let heard: Vec<i16> = bytes[44..]
            .chunks(2)
            .map(|pair| i16::from_le_bytes([pair[0], pair[1]]))
            .collect();
        let loudest = |from: f64, to: f64| {
            let [from, to] = [from, to].map(|seconds| (seconds * f64::from(RATE)) as usize);
            let part = heard[from..to.min(heard.len())].iter();
            part.map(|sample| sample.unsigned_abs()).max().unwrap()
        };
        assert!(loudest(0.0, 0.039) == 0 && loudest(0.05, 1.0) < 100);
        assert!(loudest(0.039, 0.05) > 10_000);
        let path = file.path().to_owned();
        drop(file);
        assert!(!path.exists(), "nothing is left of it");
    }
}
