//! One folder holds one run: it is taken before anything is written, emptied of an earlier run's
//! results, and given back at the end.

use super::{Failure, files};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The file whose lock says that a process writes here. The lock ends with its process, however
/// that ends.
const LOCK: &str = ".tackscope.lock";
/// How often the lock is tried where it is taken away between opening and locking.
const TRIES: usize = 8;
/// Size of the pieces in which room is tried, in bytes.
const PIECE: usize = 1 << 20;

/// A folder that only this process writes its results into.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Held, never read.
    _lock: File,
}

impl Folder {
    /// Makes the folder, takes it, sweeps what killed processes have left half written in it and in
    /// its `inner` folders, and tries whether `room` bytes fit.
    ///
    /// # Errors
    /// A folder that cannot be made or written to, that another process writes into, or that has no
    /// room.
    pub fn claim(path: &Path, inner: &[&str], room: u64) -> Result<Self, Failure> {
        fs::create_dir_all(path).map_err(|error| Failure::write(path, error))?;
        let folder = Self {
            path: path.to_owned(),
            _lock: lock(path)?,
        };
        files::sweep(path);
        for inner in inner {
            files::sweep(&path.join(inner));
        }
        try_room(path, room).map_err(|error| match error.kind() {
            io::ErrorKind::StorageFull
            | io::ErrorKind::QuotaExceeded
            | io::ErrorKind::FileTooLarge => {
                let reason = format!("{error}; about {} MB are needed", room.div_ceil(1_000_000));
                Failure::refused(path, &reason, "make room, or choose another folder")
            }
            _ => Failure::write(path, error),
        })?;
        Ok(folder)
    }

    /// The path of a file in it.
    pub fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path.join(name)
    }

    /// Removes the results of an earlier run: the files directly in the folder and in its `inner`
    /// folders whose name (as in `gaps/1-approach-bulge.png`) `ours` accepts. The summaries (JSON),
    /// which say that it was finished, go first. Returns how many there were.
    ///
    /// # Errors
    /// A file that is read-only (then nothing is removed) or cannot be removed.
    pub fn clear(&self, inner: &[&str], ours: impl Fn(&str) -> bool) -> Result<usize, Failure> {
        let mut found: Vec<PathBuf> = Vec::new();
        for place in [&[""], inner].concat() {
            for entry in fs::read_dir(self.join(place))
                .into_iter()
                .flatten()
                .flatten()
            {
                let name = Path::new(place).join(entry.file_name());
                // Through a link the file it points to is the result. Folders and devices were
                // never written here.
                let target = name
                    .to_str()
                    .is_some_and(&ours)
                    .then(|| files::target(&entry.path()));
                found.extend(target.and_then(Result::ok).filter(|path| path.is_file()));
            }
        }
        found.sort_by_key(|path| path.extension().is_none_or(|end| end != "json"));
        for path in &found {
            if fs::metadata(path).is_ok_and(|there| there.permissions().readonly()) {
                let reason = "it is read-only, a result of an earlier run";
                return Err(Failure::refused(
                    path,
                    reason,
                    "choose another folder, or allow writing to it",
                ));
            }
        }
        for path in &found {
            fs::remove_file(path).map_err(|error| Failure::write(path, error))?;
        }
        Ok(found.len())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Before the lock ends: whoever opens the file after this makes a new one.
        let _ = fs::remove_file(self.join(LOCK));
    }
}

/// The lock file, locked.
fn lock(folder: &Path) -> Result<File, Failure> {
    let path = folder.join(LOCK);
    let failed = |error: io::Error| Failure::write(folder, error);
    for _ in 0..TRIES {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(taken(folder, &mut file)),
            // A file system without locks: two runs can then mix, which is no reason not to do one.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
        let holder = format!("process {}\n", std::process::id());
        file.set_len(0)
            .and_then(|()| file.write_all(holder.as_bytes()))
            .map_err(failed)?;
        // The holder before may have removed the file after it was opened here; then the lock is on
        // nothing.
        if fs::read_to_string(&path).is_ok_and(|text| text == holder) {
            return Ok(file);
        }
    }
    Err(taken(folder, &mut io::empty()))
}

fn taken(folder: &Path, file: &mut dyn Read) -> Failure {
    let mut holder = String::new();
    // Some systems do not let a locked file be read.
    let _ = file.take(64).read_to_string(&mut holder);
    let holder = if holder.starts_with("process ") {
        format!(" ({})", holder.trim_end())
    } else {
        String::new()
    };
    let reason = format!("another tackscope{holder} is writing into it");
    Failure::refused(
        folder,
        &reason,
        "choose another folder, or wait until that one is done",
    )
}

/// Writes `room` bytes and takes them back.
fn try_room(folder: &Path, room: u64) -> io::Result<()> {
    let file = files::temporary(folder)?;
    let mut file = file.as_file();
    let piece = vec![0; PIECE];
    let mut left = room;
    while left > 0 {
        let now = left.min(PIECE as u64);
        file.write_all(&piece[..now as usize])?;
        left -= now;
    }
    file.sync_all()
}
