//! Polling access to the newest estimate, for a controller or a display: never waits, and marks an estimate that is out of date.
//!
//! ```no_run
//! use sideslip::io::bus::reader::Reader;
//! use sideslip::io::bus::root::BusRoot;
//!
//! let mut reader = Reader::open(&BusRoot::default_path())?;
//! loop {
//!     if let Some(estimate) = reader.latest()?.filter(|estimate| estimate.is_valid()) {
//!         let _dutch_roll = estimate.modes.dutch_roll; // omega, zeta and their standard errors
//!         let _joint_covariance = estimate.derivatives.lateral.map(|lateral| lateral.cov);
//!     }
//!     std::thread::sleep(std::time::Duration::from_millis(20));
//! }
//! # #[allow(unreachable_code)]
//! # Ok::<(), sideslip::io::bus::error::BusError>(())
//! ```

use super::clock::monotonic_ns;
use super::error::BusError;
use super::payload::{DerivativesPayload, ModesPayload};
use super::service::{Bus, Subscriber};
use crate::realtime::modes::record::ModesRecord;
use crate::realtime::regression::record::{DerivativesRecord, Status};
use std::path::Path;
use std::time::Duration;

/// An estimate holds for so long after its newest sample; then it is stale. Estimates come at 10 Hz or faster.
pub const VALID_FOR: Duration = Duration::from_millis(200);

/// The newest estimate, derivatives and modes of the same sample.
#[derive(Clone, Debug)]
pub struct NewestEstimate {
    /// Derivatives with standard errors, and the joint covariance of the lateral ones.
    pub derivatives: DerivativesRecord,
    /// Modes.
    pub modes: ModesRecord,
    /// How long ago its newest sample came onto the bus, when it was asked for.
    pub age: Duration,
    /// Its number, from 0 in each life of the estimator.
    pub sequence: u64,
    /// Which life of the estimator; a later one has the larger number.
    pub incarnation: u64,
    /// How many estimates this reader has missed since it was opened.
    pub missed: u64,
    /// Status of the modes; stale as soon as the estimate is older than [`VALID_FOR`], whatever it was.
    pub status: Status,
    /// Until when it holds, monotonic clock of the machine, ns.
    pub valid_until_ns: u64,
}

impl NewestEstimate {
    /// Whether there are modes that hold now: converging or converged, and not too old.
    pub fn is_valid(&self) -> bool {
        matches!(self.status, Status::Converging | Status::Converged) && monotonic_ns() < self.valid_until_ns
    }
}

/// A place from which the newest estimate is read.
#[derive(Debug)]
pub struct Reader {
    derivatives: Subscriber<DerivativesPayload>,
    modes: Subscriber<ModesPayload>,
    awaiting: Option<DerivativesPayload>,
    newest: Option<(DerivativesPayload, ModesPayload)>,
    _bus: Option<Bus>,
}

impl Reader {
    /// Enters the root; estimates may come later.
    ///
    /// # Errors
    /// [`BusError`] where the root cannot be used or programs of another version are in it.
    pub fn open(root: &Path) -> Result<Self, BusError> {
        let bus = Bus::enter(root)?;
        let reader = Reader::on(&bus)?;
        Ok(Reader { _bus: Some(bus), ..reader })
    }

    /// A reader in a process that is on the bus already.
    ///
    /// # Errors
    /// [`BusError`] where a service has no room.
    pub fn on(bus: &Bus) -> Result<Self, BusError> {
        let (derivatives, modes) = (bus.subscriber()?, bus.subscriber()?);
        Ok(Reader { derivatives, modes, awaiting: None, newest: None, _bus: None })
    }

    /// The newest estimate; `None` before the first. Never waits; what came since the last call is taken in.
    ///
    /// # Errors
    /// [`BusError`] where shared memory cannot be read or holds what no estimator writes.
    pub fn latest(&mut self) -> Result<Option<NewestEstimate>, BusError> {
        self.take_in()?;
        let Some((derivatives, modes)) = &self.newest else { return Ok(None) };
        let header = derivatives.header;
        let (derivatives, modes) = (derivatives.record()?, modes.record()?);
        let valid_for_ns = u64::try_from(VALID_FOR.as_nanos()).unwrap_or(u64::MAX);
        let valid_until_ns = header.sampled_ns.saturating_add(valid_for_ns);
        let now_ns = monotonic_ns();
        let status = if now_ns < valid_until_ns { modes.status } else { Status::Stale };
        Ok(Some(NewestEstimate {
            derivatives,
            modes,
            age: Duration::from_nanos(now_ns.saturating_sub(header.sampled_ns)),
            sequence: header.sequence,
            incarnation: header.incarnation,
            missed: self.derivatives.missed(),
            status,
            valid_until_ns,
        }))
    }

    /// The estimator publishes derivatives, then modes, each with the same number in its sequence.
    fn take_in(&mut self) -> Result<(), BusError> {
        while let Some(modes) = self.modes.receive()? {
            let matches = |derivatives: &DerivativesPayload| belong_together(derivatives, &modes);
            while !self.awaiting.as_ref().is_some_and(matches) {
                match self.derivatives.receive()? {
                    Some(derivatives) => self.awaiting = Some(derivatives),
                    None => break,
                }
            }
            if let Some(derivatives) = self.awaiting.take_if(|derivatives| matches(derivatives)) {
                self.newest = Some((derivatives, modes));
            }
        }
        Ok(())
    }
}

fn belong_together(derivatives: &DerivativesPayload, modes: &ModesPayload) -> bool {
    let (one, other) = (derivatives.header, modes.header);
    (one.incarnation, one.sequence) == (other.incarnation, other.sequence)
}
