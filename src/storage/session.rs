//! Session files (`.tackscope`): a zip of a scene, the loop so far, notes, and what the window keeps
//! of them, so that it opens again as it was.
//!
//! | member | holds |
//! |---|---|
//! | `session.json` | `format`, the version; `program`, which wrote it |
//! | `scene.toml` | the scene file |
//! | `loop.csv`, `events.csv` | states and jumps, as a run writes them |
//! | `notes.txt` | what somebody wrote |
//! | `window.msgpack` | everything, in MessagePack: records, stored states, films of jumps |

use super::{Failure, VERSION, export, files, scene_file};
use crate::follow::record::LoopRecord;
use crate::scene::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufWriter, Cursor, Seek, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// The version of the file.
const FORMAT: u32 = 1;
/// Longest session that is read, in bytes: more than all states and films that a window keeps.
pub const BYTES_MAX: u64 = 1 << 30;
/// Longest `session.json` and `notes.txt` that are read.
const TEXT_MAX: u64 = 1 << 20;
/// What every zip begins with.
const SIGNATURE: &[u8; 4] = b"PK\x03\x04";
/// Where the name of its first member stands.
const FIRST_NAME: usize = 30;
/// The member that says what the file is; the first, by which it is told from height files.
const HEAD: &str = "session.json";
/// What to do about a file that is broken.
const REMEDY: &str = "open a session that this program has saved";

/// A session; `T` is what the window keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Session<T> {
    /// The scene.
    pub scene: Scene,
    /// What somebody wrote.
    pub notes: String,
    /// What the window keeps.
    pub window: T,
}

/// What [`HEAD`] holds.
#[derive(Serialize, Deserialize)]
struct Head {
    format: u32,
    program: String,
}

/// True if this is the beginning of a session file.
pub(super) fn is_session(bytes: &[u8]) -> bool {
    let named = |name: &[u8]| name.starts_with(HEAD.as_bytes());
    bytes.starts_with(SIGNATURE) && bytes.get(FIRST_NAME..).is_some_and(named)
}

/// Writes a session with the states and jumps of its `record`.
///
/// # Errors
/// A scene that cannot be opened again, or a file that cannot be written.
pub fn save<T: Serialize>(
    path: &Path,
    session: &Session<T>,
    record: &LoopRecord,
) -> Result<(), Failure> {
    scene_file::parse(
        &scene_file::to_text(&session.scene),
        &path.display().to_string(),
    )?;
    files::write_by(path, |file: &mut File| {
        archive(BufWriter::new(file), session, record)?.flush()
    })
}

/// The bytes of a session file.
///
/// # Errors
/// What does not fit into memory.
pub fn to_bytes<T: Serialize>(
    session: &Session<T>,
    record: &LoopRecord,
) -> std::io::Result<Vec<u8>> {
    archive(Cursor::new(Vec::new()), session, record).map(Cursor::into_inner)
}

fn archive<T: Serialize, W: Write + Seek>(
    to: W,
    session: &Session<T>,
    record: &LoopRecord,
) -> std::io::Result<W> {
    let mut archive = ZipWriter::new(to);
    // Numbers hardly shrink: more effort costs seconds and gains nothing.
    let options = SimpleFileOptions::default()
        .compression_level(Some(1))
        .large_file(true);
    let head = Head {
        format: FORMAT,
        program: format!("tackscope {VERSION}"),
    };
    let Session {
        scene,
        notes,
        window,
    } = session;
    for (name, text) in [
        (HEAD, serde_json::to_string(&head)?),
        ("scene.toml", scene_file::to_text(scene)),
        ("loop.csv", export::loop_csv(scene, &record.states)),
        ("events.csv", export::events_csv(scene, &record.jumps)),
        ("notes.txt", notes.clone()),
    ] {
        archive.start_file(name, options)?;
        archive.write_all(text.as_bytes())?;
    }
    archive.start_file("window.msgpack", options)?;
    let mut numbers = BufWriter::new(&mut archive);
    rmp_serde::encode::write_named(&mut numbers, window).map_err(std::io::Error::other)?;
    numbers.flush()?;
    drop(numbers);
    Ok(archive.finish()?)
}

/// The session in the bytes of a file, or of a picture that carries one.
///
/// # Errors
/// What is no session, broken, or of another version.
pub fn of_bytes<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<Session<T>, Failure> {
    let mut members = Members::of(path, bytes)?;
    let scene = members.scene()?;
    let notes = members.text("notes.txt", TEXT_MAX)?;
    let numbers = members.member("window.msgpack", BYTES_MAX)?;
    let window = rmp_serde::from_slice(&numbers)
        .map_err(|error| broken(path, &format!("window.msgpack: {error}")))?;
    Ok(Session {
        scene,
        notes,
        window,
    })
}

/// The scene of a session alone.
///
/// # Errors
/// As [`of_bytes`].
pub(super) fn scene_of(path: &Path, bytes: &[u8]) -> Result<Scene, Failure> {
    Members::of(path, bytes)?.scene()
}

fn broken(path: &Path, reason: &str) -> Failure {
    Failure::unreadable(path, reason, REMEDY)
}

/// The members of a session file of this version.
struct Members<'a> {
    path: &'a Path,
    archive: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> Members<'a> {
    fn of(path: &'a Path, bytes: &'a [u8]) -> Result<Self, Failure> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| broken(path, &format!("no session file: {error}")))?;
        let mut members = Self { path, archive };
        let text = members.text(HEAD, TEXT_MAX)?;
        let head: Head = serde_json::from_str(&text)
            .map_err(|error| broken(path, &format!("{HEAD}: {error}")))?;
        if head.format == FORMAT {
            return Ok(members);
        }
        Err(Failure::value(
            &path.display().to_string(),
            "format",
            &head.format.to_string(),
            &format!(
                "this program reads sessions of format {FORMAT}; it was written by {}",
                head.program
            ),
        ))
    }

    fn scene(&mut self) -> Result<Scene, Failure> {
        let text = self.text("scene.toml", scene_file::BYTES_MAX)?;
        scene_file::parse(&text, &self.path.display().to_string())
    }

    fn text(&mut self, name: &str, most: u64) -> Result<String, Failure> {
        String::from_utf8(self.member(name, most)?)
            .map_err(|_| broken(self.path, &format!("{name} is not UTF-8")))
    }

    /// A member of at most so many bytes, whatever the archive says of its length.
    fn member(&mut self, name: &str, most: u64) -> Result<Vec<u8>, Failure> {
        files::member(&mut self.archive, name, most).map_err(|why| broken(self.path, &why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage;
    use proptest::prelude::*;

    /// Numbers that text or single precision would not bring back.
    fn session() -> Session<Vec<f64>> {
        Session {
            scene: storage::preset("rubber").unwrap().scene().unwrap(),
            notes: "Öl, 20 °C\nsecond line".to_owned(),
            window: vec![0.1 + 0.2, -0.0, f64::NAN, f64::INFINITY, 5e-324],
        }
    }

    fn bits(numbers: &[f64]) -> Vec<u64> {
        numbers.iter().map(|number| number.to_bits()).collect()
    }

    #[test]
    fn a_session_comes_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tackscope");
        let written = session();
        save(&path, &written, &LoopRecord::default()).unwrap();
        let bytes = files::read_regular(&path, BYTES_MAX).unwrap();
        assert!(is_session(&bytes));
        let read: Session<Vec<f64>> = of_bytes(&path, &bytes).unwrap();
        assert_eq!((&read.scene, &read.notes), (&written.scene, &written.notes));
        assert_eq!(bits(&read.window), bits(&written.window));
        assert_eq!(scene_of(&path, &bytes).unwrap(), written.scene);
    }

    proptest! {
        #[test]
        fn a_broken_session_is_refused_in_words(place in 0.0..1.0, bit in 0u8..8, cut in any::<bool>()) {
            let mut bytes = to_bytes(&session(), &LoopRecord::default()).unwrap();
            let at = (place * bytes.len() as f64) as usize;
            if cut {
                bytes.truncate(at);
            } else {
                bytes[at] ^= 1 << bit;
            }
            let path = Path::new("a.tackscope");
            match of_bytes::<Vec<f64>>(path, &bytes) {
                // A bit that nobody reads: of a date, a comment, a name that stands twice.
                Ok(read) => prop_assert_eq!(bits(&read.window), bits(&session().window)),
                Err(failure) => prop_assert!(failure.to_string().starts_with("a.tackscope: ")),
            }
        }
    }

    #[test]
    fn another_version_is_refused_with_what_wrote_it() {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        archive
            .start_file(HEAD, SimpleFileOptions::default())
            .unwrap();
        archive
            .write_all(br#"{"format":7,"program":"tackscope 9"}"#)
            .unwrap();
        let bytes = archive.finish().unwrap().into_inner();
        let words = scene_of(Path::new("a.tackscope"), &bytes)
            .unwrap_err()
            .to_string();
        assert!(
            words.contains("format = 7") && words.contains("tackscope 9"),
            "{words}"
        );
    }
}
