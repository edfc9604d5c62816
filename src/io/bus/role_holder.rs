//! Who has a role, asked without disturbing anybody: read from the kernel's list of locks.
//!
//! Trying the lock instead would take it for an instant, in which the process that it is meant for is refused.

use super::root::{BusRole, role_file};
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// The kernel's list of file locks.
const LOCKS: &str = "/proc/locks";

/// Who has a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoleHolder {
    /// Nobody.
    Nobody,
    /// The process of that number.
    Process(u32),
    /// The system does not list its locks.
    Unknown,
}

impl RoleHolder {
    /// Who has the role in that root now; the root is not entered.
    pub fn of(root: &Path, role: BusRole) -> Self {
        let Ok(file) = std::fs::metadata(role_file(root, role)) else { return RoleHolder::Nobody };
        match std::fs::read_to_string(LOCKS) {
            Ok(list) => listed(&list, file.ino()),
            Err(_) => RoleHolder::Unknown,
        }
    }
}

/// The holder of the exclusive lock on a file, from lines such as `3: FLOCK  ADVISORY  WRITE 4711 fd:01:1234 0 EOF`. Devices
/// are not compared: a file system in layers reports another one here than of the file.
fn listed(list: &str, inode: u64) -> RoleHolder {
    let holder = |line: &str| {
        let mut words = line.split_whitespace().skip(1);
        let (kind, _, access) = (words.next()?, words.next()?, words.next()?);
        let (process, place) = (words.next()?.parse().ok()?, words.next()?);
        let found: u64 = place.rsplit(':').next()?.parse().ok()?;
        (kind == "FLOCK" && access == "WRITE" && found == inode).then_some(process)
    };
    list.lines().find_map(holder).map_or(RoleHolder::Nobody, RoleHolder::Process)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_holder_of_an_exclusive_lock_is_found_by_its_file() {
        let list = "1: POSIX  ADVISORY  WRITE 11 fd:01:900 0 EOF\n2: FLOCK  ADVISORY  READ 12 fd:01:900 0 EOF\n\
                    2: -> FLOCK  ADVISORY  WRITE 13 fd:01:900 0 EOF\n3: FLOCK  ADVISORY  WRITE 14 00:35:900 0 EOF\nodd\n";
        assert_eq!(listed(list, 900), RoleHolder::Process(14));
        assert_eq!(listed(list, 901), RoleHolder::Nobody);
        assert_eq!(listed("", 1), RoleHolder::Nobody);
    }
}
