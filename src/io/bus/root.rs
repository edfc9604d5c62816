//! The root directory of a bus: admission of processes, the roles, and removal of what ended processes have left.
//!
//! Everything is below `.sideslip` in the directory that the user names. Its files are locked by the kernel (`flock`), so that no
//! lock outlives its process:
//!
//! - `door`: held exclusively while a process enters. Services are created and opened under this lock only, one process at a
//!   time.
//! - `inside`: held shared by every process of the bus. A process that gets it exclusively is the only one and removes leftovers.
//! - `telemetry`, `estimator`, `supervisor`: the roles, one process each; the file contains its process number.
//!
//! The middleware's own files and its shared memory are in the system's directory for shared memory, under names with a prefix
//! derived from the root's path: the length of the path is not limited by the middleware, and removal touches no file of the
//! user.
//!
//! Completeness: a service is left half created only by a process that ended under `door` while no other process was inside
//! (every process inside has all services open), so the next process that enters is the only one and removes it.

use super::error::BusError;
use std::fs::{DirBuilder, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The longest wait at the door; whoever stands in it needs some tens of milliseconds.
const DOOR: Duration = Duration::from_secs(5);

const OURS: &str = ".sideslip";

/// Directory of the heads of runs below what is ours.
const HEADS: &str = "runs";

/// What the names of private roots begin with, in the directory of temporary files.
const PRIVATE: &str = "sideslip-private-";

/// A private root younger than this may belong to a process that has not entered it yet.
const SETTLED: Duration = Duration::from_secs(60);

/// Where the system keeps shared memory.
const SHARED_MEMORY: &str = "/dev/shm";

/// A part that only one process can play.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusRole {
    /// Publishes samples.
    Telemetry,
    /// Publishes estimates.
    Estimator,
    /// Starts the other two.
    Supervisor,
}

impl BusRole {
    /// The name, of the lock file too.
    pub const fn name(self) -> &'static str {
        match self {
            BusRole::Telemetry => "telemetry",
            BusRole::Estimator => "estimator",
            BusRole::Supervisor => "supervisor",
        }
    }
}

/// A role, held until dropped.
#[derive(Debug)]
pub struct RoleLock(#[expect(dead_code, reason = "the lock is the file's")] File);

/// The door, closed to others until dropped.
#[derive(Debug)]
pub(super) struct DoorLock(#[expect(dead_code, reason = "the lock is the file's")] File);

/// A root that this process is inside of.
#[derive(Debug)]
pub struct BusRoot {
    path: PathBuf,
    /// Our part of it.
    ours: PathBuf,
    /// Shared lock, for as long as the process is inside.
    inside: Option<File>,
    swept: bool,
    remove: bool,
}

impl BusRoot {
    /// The root that is meant where none is named: `sideslip` below `XDG_RUNTIME_DIR`, else `sideslip-UID` below the
    /// directory of temporary files.
    pub fn default_path() -> PathBuf {
        match std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|path| path.is_dir()) {
            Some(runtime) => runtime.join("sideslip"),
            None => std::env::temp_dir().join(format!("sideslip-{}", own_user())),
        }
    }

    /// A root for this process and those that it starts, not made yet. Such roots of processes that are no more are removed.
    pub fn private_path() -> PathBuf {
        let place = std::env::temp_dir();
        for entry in std::fs::read_dir(&place).into_iter().flatten().flatten() {
            if entry.file_name().as_encoded_bytes().starts_with(PRIVATE.as_bytes()) {
                remove_if_left(&entry.path());
            }
        }
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |time| time.subsec_nanos());
        place.join(format!("{PRIVATE}{}-{since}", std::process::id()))
    }

    /// Enters the root, making it where it is missing; the door stays closed until what is returned beside it is dropped.
    pub(super) fn enter(path: &Path) -> Result<(Self, DoorLock), BusError> {
        let path = make(path)?;
        let ours = make(&path.join(OURS))?;
        let mut door = open(&ours, "door")?;
        lock_within(&door, DOOR, |file| file.try_lock()).map_err(|what| {
            let holder = holder(&mut door);
            BusError::Busy { path: path.clone(), what: format!("the door is closed by {holder}: {what}") }
        })?;
        sign(&mut door).map_err(|error| root_error(&path, &error))?;
        let inside = open(&ours, "inside")?;
        let swept = match inside.try_lock() {
            Ok(()) => {
                sweep(&path, &ours)?;
                inside.unlock().map_err(|error| root_error(&path, &error))?;
                true
            }
            Err(TryLockError::WouldBlock) => false,
            Err(TryLockError::Error(error)) => return Err(root_error(&path, &error)),
        };
        // The exclusive lock is taken behind the door only, so nothing can stand against the shared one.
        lock_within(&inside, DOOR, |file| file.try_lock_shared())
            .map_err(|what| BusError::Busy { path: path.clone(), what: format!("cannot enter: {what}") })?;
        Ok((BusRoot { path, ours, inside: Some(inside), swept, remove: false }, DoorLock(door)))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether this process was the first, and swept.
    pub fn swept(&self) -> bool {
        self.swept
    }

    /// Removes the whole root when this process leaves it: for a private one.
    pub(super) fn remove_at_the_end(&mut self) {
        self.remove = true;
    }

    /// Where the heads of runs are written: removed when the next process sweeps.
    pub(super) fn heads(&self) -> PathBuf {
        self.ours.join(HEADS)
    }

    /// Takes a role.
    ///
    /// # Errors
    /// [`BusError::RoleTaken`] where another process has it.
    pub fn take(&self, role: BusRole) -> Result<RoleLock, BusError> {
        let mut file = open(&self.ours, role.name())?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let holder = holder(&mut file);
                return Err(BusError::RoleTaken { path: self.path.clone(), role: role.name(), holder });
            }
            Err(TryLockError::Error(error)) => return Err(root_error(&self.path, &error)),
        }
        sign(&mut file).map_err(|error| root_error(&self.path, &error))?;
        Ok(RoleLock(file))
    }

    /// The same, waiting so long for a process that is ending.
    ///
    /// # Errors
    /// [`BusError::RoleTaken`] where another process still has it then.
    pub fn take_within(&self, role: BusRole, limit: Duration) -> Result<RoleLock, BusError> {
        let begun = Instant::now();
        loop {
            match self.take(role) {
                Err(BusError::RoleTaken { .. }) if begun.elapsed() < limit => std::thread::sleep(Duration::from_millis(5)),
                taken => return taken,
            }
        }
    }

    /// The middleware's own directory, made here.
    pub(super) fn bus_directory(&self) -> Result<PathBuf, BusError> {
        make(&Path::new(SHARED_MEMORY).join(format!("{}bus", prefix(&self.path))))
    }

    /// What the names of its shared memory begin with.
    pub(super) fn prefix(&self) -> String {
        prefix(&self.path)
    }
}

impl Drop for BusRoot {
    /// The last one out sweeps too; where someone stands in the door, that one is not the last.
    fn drop(&mut self) {
        drop(self.inside.take());
        sweep_if_alone(&self.path, self.remove);
    }
}

/// Sweeps, and removes the whole root where that is meant, if nobody is inside.
fn sweep_if_alone(path: &Path, remove: bool) {
    let ours = path.join(OURS);
    let alone = |name: &str| open(&ours, name).ok().filter(|file| file.try_lock().is_ok());
    let door = alone("door");
    if door.is_some() && alone("inside").is_some() {
        let _ = sweep(path, &ours);
        if remove {
            let _ = std::fs::remove_dir_all(path);
        }
    }
}

/// A private root of a process that was killed; one whose process lives, or has not entered yet, stays.
fn remove_if_left(path: &Path) {
    let ours = path.symlink_metadata().ok().filter(|found| found.is_dir() && found.uid() == own_user());
    let age = ours.and_then(|found| found.modified().ok()).and_then(|time| time.elapsed().ok());
    if age.is_some_and(|age| age > SETTLED) {
        if path.join(OURS).is_dir() {
            sweep_if_alone(path, true);
        } else {
            let _ = std::fs::remove_dir(path);
        }
    }
}

/// The lock file of a role in a root.
pub(super) fn role_file(root: &Path, role: BusRole) -> PathBuf {
    root.join(OURS).join(role.name())
}

/// Writes this process' number into a file that it has locked.
fn sign(file: &mut File) -> std::io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{}", std::process::id())
}

/// Whose number stands in a locked file.
fn holder(file: &mut File) -> String {
    let mut text = String::new();
    let _ = file.rewind().and_then(|()| file.read_to_string(&mut text));
    let number = text.trim();
    if number.is_empty() { "another process".to_owned() } else { format!("process {number}") }
}

/// The path as the file system knows it, a directory of this user that no one else can enter.
fn make(path: &Path) -> Result<PathBuf, BusError> {
    let cannot = |error: std::io::Error| root_error(path, &error);
    if !path.exists() {
        if let Some(parent) = path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            std::fs::create_dir_all(parent).map_err(cannot)?;
        }
        match DirBuilder::new().mode(0o700).create(path) {
            Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => return Err(cannot(error)),
            _ => {}
        }
    }
    let found = path.symlink_metadata().map_err(cannot)?;
    let refuse = |what: String| Err(BusError::Root { path: path.into(), what });
    if !found.is_dir() {
        return refuse("expected a directory for --root, found something else".into());
    }
    if found.uid() != own_user() {
        return refuse(format!("expected a directory of this user ({}), found one of user {}", own_user(), found.uid()));
    }
    if found.mode() & 0o022 != 0 {
        return refuse(format!("expected a directory that only this user can write, found mode {:03o}", found.mode() & 0o777));
    }
    path.canonicalize().map_err(cannot)
}

fn own_user() -> u32 {
    std::fs::metadata("/proc/self").map_or(u32::MAX, |found| found.uid())
}

fn open(root: &Path, name: &str) -> Result<File, BusError> {
    let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(root.join(name));
    opened.map_err(|error| root_error(root, &error))
}

fn root_error(path: &Path, error: &std::io::Error) -> BusError {
    BusError::Root { path: path.into(), what: error.to_string() }
}

fn lock_within(file: &File, limit: Duration, lock: impl Fn(&File) -> Result<(), TryLockError>) -> Result<(), String> {
    let begun = Instant::now();
    loop {
        match lock(file) {
            Ok(()) => return Ok(()),
            Err(TryLockError::WouldBlock) if begun.elapsed() < limit => std::thread::sleep(Duration::from_millis(1)),
            Err(TryLockError::WouldBlock) => return Err(format!("another process has held it for {} s", limit.as_secs())),
            Err(TryLockError::Error(error)) => return Err(error.to_string()),
        }
    }
}

/// 64-bit FNV-1a of the path: two roots never share memory, and a root finds its own again.
fn prefix(path: &Path) -> String {
    let bytes = path.as_os_str().as_encoded_bytes();
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("sideslip_{hash:016x}_")
}

/// Removes everything of ours that processes now dead have left behind.
fn sweep(root: &Path, ours: &Path) -> Result<(), BusError> {
    let gone = |removed: std::io::Result<()>, path: &Path| match removed {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(root_error(path, &error)),
        _ => Ok(()),
    };
    gone(std::fs::remove_dir_all(ours.join(HEADS)), root)?;
    let prefix = prefix(root);
    let Ok(entries) = std::fs::read_dir(SHARED_MEMORY) else { return Ok(()) };
    for entry in entries.flatten() {
        if entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            let path = entry.path();
            let is_directory = entry.file_type().is_ok_and(|kind| kind.is_dir());
            gone(if is_directory { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) }, &path)?;
        }
    }
    Ok(())
}
