//! Whole files or none: what is written appears under its name only when it is complete. And one
//! folder holds one run: it is taken before anything is written, emptied of an earlier run's
//! results, and given back at the end.

use super::Failure;
use std::fs;
use std::io::{self, Cursor, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{RwLock, RwLockWriteGuard};
use zip::ZipArchive;

/// How the name of a file begins that is being written.
pub(super) const TEMPORARY: &str = ".tackscope-";
/// Links that are followed one after the other, as many as Linux follows.
const LINKS_MAX: usize = 40;

/// Held for reading while a file is being written.
static WRITING: RwLock<()> = RwLock::new(());

/// Keeps every file from being written while the guard lives; `None` while one is.
pub fn at_rest() -> Option<RwLockWriteGuard<'static, ()>> {
    WRITING.try_write().ok()
}

/// A file that grows by whole lines, each of which is on the disk before the next is begun.
#[derive(Debug)]
pub(super) struct Growing {
    file: fs::File,
    path: PathBuf,
}

impl Growing {
    /// Opens a file that is there, and cuts off what is beyond its first `keep` bytes.
    ///
    /// # Errors
    /// A file that cannot be written, or is read-only.
    pub(super) fn open(path: &Path, keep: u64) -> Result<Self, Failure> {
        let _writing = WRITING.read();
        let opened = fs::OpenOptions::new().append(true).open(path);
        let cut = opened.and_then(|file| file.set_len(keep).map(|()| file));
        Ok(Self {
            file: cut.map_err(|error| Failure::write(path, error))?,
            path: path.to_owned(),
        })
    }

    /// Appends a line, which ends with a line break.
    ///
    /// # Errors
    /// A disk that is full, or gone.
    pub(super) fn append(&mut self, line: &str) -> Result<(), Failure> {
        let _writing = WRITING.read();
        let written = self.file.write_all(line.as_bytes());
        written
            .and_then(|()| self.file.sync_data())
            .map_err(|error| Failure::write(&self.path, error))
    }
}

/// The path that somebody typed: a `~` at its beginning is the home folder, where no shell has put
/// that in its place.
///
/// # Errors
/// An empty path, a `~` without a home folder, or `~name` that is no file.
pub fn typed(path: &Path) -> Result<PathBuf, Failure> {
    let refuse = |reason: &str, remedy: &str| Err(Failure::no_path(path, reason, remedy));
    if path.as_os_str().is_empty() {
        return refuse("the path is empty", "give the path of a file or folder");
    }
    let mut parts = path.components();
    match parts.next() {
        Some(Component::Normal(first)) if first == "~" => {
            match std::env::home_dir().filter(|home| !home.as_os_str().is_empty()) {
                // A join with nothing would end in a slash.
                Some(home) if parts.as_path().as_os_str().is_empty() => Ok(home),
                Some(home) => Ok(home.join(parts.as_path())),
                None => refuse(
                    "~ is the home folder, and HOME is not set",
                    "write the path out",
                ),
            }
        }
        Some(Component::Normal(first))
            if first.as_encoded_bytes().starts_with(b"~") && !path.exists() =>
        {
            refuse(
                "~ with a name is somebody's home folder",
                "write the path out, or put ./ before a name that begins with ~",
            )
        }
        _ => Ok(path.to_owned()),
    }
}

/// What writing to a path does to what is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// A new file in a folder that is there.
    Adds,
    /// A file is replaced.
    Replaces,
    /// This folder is made.
    MakesFolder(PathBuf),
}

/// What [`write_whole`] would do.
pub fn effect(path: &Path) -> Effect {
    match folder_of(path) {
        _ if path.exists() => Effect::Replaces,
        folder if folder.is_dir() => Effect::Adds,
        folder => Effect::MakesFolder(folder),
    }
}

/// Writes `bytes` to `path`, making its folder: into a temporary file beside it first, which then
/// takes its name.
///
/// Through a symbolic link the file is replaced (or made) that it points to, not the link. A file
/// that is replaced hands on its permissions.
///
/// # Errors
/// A folder or file that cannot be written, that is read-only, or that is no file (a folder, a
/// device, a pipe). What is there is then untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_by(path, |file| file.write_all(bytes))
}

/// The same of what `write` puts into the file, piece by piece.
///
/// # Errors
/// As [`write_whole`], or what `write` says.
pub fn write_by(
    path: &Path,
    write: impl FnOnce(&mut fs::File) -> io::Result<()>,
) -> Result<(), Failure> {
    let _writing = WRITING.read();
    let target = target(path)?;
    let permissions = replaceable(path, &target)?;
    replace(&target, write, permissions).map_err(|error| Failure::write(path, error))
}

/// The file that a path means, at the end of its links.
pub(super) fn target(path: &Path) -> Result<PathBuf, Failure> {
    let mut here = path.to_owned();
    for _ in 0..LINKS_MAX {
        // Links to what a process has open look like files, and are not to be replaced.
        if here.starts_with("/proc") || here.starts_with("/dev/fd") {
            return Err(no_file(path, "leads to what a process has open"));
        }
        match fs::read_link(&here) {
            Ok(next) => here = folder_of(&here).join(next),
            Err(_) if here != path && !folder_of(&here).is_dir() => {
                let reason = format!(
                    "it is a link to {}, whose folder is not there",
                    here.display()
                );
                return Err(Failure::refused(
                    path,
                    &reason,
                    "make that folder, or remove the link",
                ));
            }
            Err(_) => return Ok(here),
        }
    }
    Err(Failure::refused(
        path,
        "its links lead in a circle",
        "remove the link",
    ))
}

/// The permissions of a file that may be replaced; `None` if there is none yet.
fn replaceable(path: &Path, target: &Path) -> Result<Option<fs::Permissions>, Failure> {
    let Ok(there) = fs::metadata(target) else {
        return Ok(None);
    };
    if there.is_dir() {
        return Err(no_file(path, "is a folder"));
    }
    if !there.is_file() {
        return Err(no_file(path, "is a device or a pipe"));
    }
    if there.permissions().readonly() {
        return Err(Failure::refused(
            path,
            "it is read-only",
            "allow writing to it, or choose another path",
        ));
    }
    Ok(Some(there.permissions()))
}

fn no_file(path: &Path, what: &str) -> Failure {
    Failure::refused(
        path,
        &format!("it {what}, not a file"),
        "choose another path, or move it out of the way",
    )
}

fn replace(
    target: &Path,
    write: impl FnOnce(&mut fs::File) -> io::Result<()>,
    permissions: Option<fs::Permissions>,
) -> io::Result<()> {
    let folder = folder_of(target);
    fs::create_dir_all(&folder)?;
    let mut file = temporary(&folder)?;
    write(file.as_file_mut())?;
    if let Some(permissions) = permissions {
        // Some file systems have none.
        let _ = file.as_file().set_permissions(permissions);
    }
    file.as_file().sync_all()?;
    file.persist(target).map_err(|error| error.error)?;
    // Its name too is on the disk then; not every system can be asked for that.
    let _ = fs::File::open(&folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// The folder in which a path lies.
fn folder_of(path: &Path) -> PathBuf {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .map_or_else(|| PathBuf::from("."), Path::to_owned)
}

/// A temporary file with the permissions of any other new file; gone when dropped. The lock on it
/// lives as long as the process that writes it, so that what killed ones have left can be told.
pub(super) fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let file = tempfile::Builder::new()
        .prefix(TEMPORARY)
        .make_in(folder, |path| fs::File::create_new(path))?;
    // Where there are no locks nothing is swept either.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Removes the temporary files in `folder` that nobody writes any more.
pub(super) fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let left = entry
            .file_name()
            .as_encoded_bytes()
            .starts_with(TEMPORARY.as_bytes());
        if !left || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let file = fs::OpenOptions::new().write(true).open(entry.path());
        if file.is_ok_and(|file| file.try_lock().is_ok()) {
            // What cannot be removed stays: it is nobody's result.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Reads at most `limit` bytes.
///
/// # Errors
/// A file that is missing, unreadable, or longer than `limit`.
pub fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    let missing = |error: io::Error| {
        let remedy = "check the path, and that you may read it";
        Failure::unreadable(path, &error.to_string(), remedy)
    };
    let mut bytes = Vec::new();
    fs::File::open(path)
        .map_err(missing)?
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(missing)?;
    if bytes.len() as u64 > limit {
        return Err(Failure::too_long(path, limit));
    }
    Ok(bytes)
}

/// Reads a member of an archive of at most `limit` bytes, whatever the archive says of its length.
///
/// # Errors
/// In words, one that is missing, broken, or longer.
pub(super) fn member(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    name: &str,
    limit: u64,
) -> Result<Vec<u8>, String> {
    let fault = |why: &dyn std::fmt::Display| format!("{name}: {why}");
    let member = archive.by_name(name).map_err(|error| fault(&error))?;
    let mut bytes = Vec::new();
    let read = member.take(limit + 1).read_to_end(&mut bytes);
    read.map_err(|error| fault(&error))?;
    if bytes.len() as u64 > limit {
        return Err(fault(&format_args!("longer than {limit} bytes")));
    }
    Ok(bytes)
}

/// Reads at most `limit` bytes of a regular file: what gives its bytes when it likes (a pipe, a
/// terminal, a device) is refused.
///
/// # Errors
/// A file that is missing, unreadable, not regular, or longer than `limit`.
pub fn read_regular(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    match fs::metadata(path) {
        Ok(data) if !data.is_file() && !data.is_dir() => Err(Failure::unreadable(
            path,
            "a pipe or a device, not a file",
            "open a file; tackscope run reads a scene from a pipe",
        )),
        // What is missing, or a folder, fails at once and in its own words.
        _ => read_bytes(path, limit),
    }
}

/// Forgets a file of the program's own, if it is there.
pub fn remove(path: &Path) {
    // What cannot be removed stays, and is refused again next time.
    let _ = fs::remove_file(path);
}

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
    _lock: fs::File,
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
        sweep(path);
        for inner in inner {
            sweep(&path.join(inner));
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
                    .then(|| target(&entry.path()));
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
fn lock(folder: &Path) -> Result<fs::File, Failure> {
    let path = folder.join(LOCK);
    let failed = |error: io::Error| Failure::write(folder, error);
    for _ in 0..TRIES {
        let mut file = fs::OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(fs::TryLockError::WouldBlock) => return Err(taken(folder, &mut file)),
            // A file system without locks: two runs can then mix, which is no reason not to do one.
            Err(fs::TryLockError::Error(_)) => return Ok(file),
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
    let file = temporary(folder)?;
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
