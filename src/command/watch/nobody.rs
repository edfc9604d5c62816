//! A root in which nobody estimates: that it is so, and what to do.

use super::bus_picture::BusPicture;
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::bus::root::{BusRole, BusRoot};
use std::path::{Path, PathBuf};

/// The root that is meant where none is named, where an estimator runs there and not here.
pub(super) fn running_elsewhere(root: &Path) -> Option<PathBuf> {
    let usual = BusRoot::default_path();
    let same = usual.canonicalize().ok() == root.canonicalize().ok();
    let runs = || matches!(RoleHolder::of(&usual, BusRole::Estimator), RoleHolder::Process(_));
    (!same && runs()).then_some(usual)
}

/// That nobody estimates here, and what to do: each sentence for itself.
pub(super) fn nobody_here(picture: &BusPicture) -> Vec<String> {
    let mut said = vec![
        match picture.telemetry {
            RoleHolder::Nobody => "no estimator and no telemetry: nothing of Sideslip runs in this root".to_owned(),
            _ => "no estimator in this root, though telemetry runs there".to_owned(),
        },
        format!("the root is {}", picture.root.display()),
    ];
    said.push(match &picture.elsewhere {
        Some(usual) => format!("an estimator runs in {}: expected --root {}", usual.display(), usual.display()),
        None => "expected the --root of a running `sideslip live` or `estimate`, or one that is started there".to_owned(),
    });
    said
}
