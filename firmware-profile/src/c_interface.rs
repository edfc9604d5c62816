//! The profile for programs in C: memory of the caller's, a sample in, the newest estimates out.
//!
//! | function | returns |
//! | --- | --- |
//! | `sideslip_profile_bytes()` | bytes of memory that a profile needs, aligned to [`ALIGNMENT`] |
//! | `sideslip_init(memory, bytes)` | 0, or a negative error |
//! | `sideslip_step(profile, sample)` | 1 where estimates are new, else 0, or a negative error |
//! | `sideslip_estimates(profile, estimates)` | 0, `SIDESLIP_NOTHING_YET` before the first, or a negative error |
//!
//! All is SI and radians. A channel that was not sampled, and a number that there is not, is NaN. The declarations are in
//! `include/sideslip.h`, written by [`header`].
#![expect(unsafe_code, reason = "what C hands over are pointers")]

pub mod header;

use crate::{Profile, SETTINGS};
use core::ffi::c_void;
use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::flight::derivative::{AXES, VARIABLES};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::modes::record::OscillatoryMode;
use sideslip::realtime::pipeline::Tick;
use sideslip::realtime::regression::record::Status;

/// Alignment of a profile's memory, bytes: that of a cache line.
pub const ALIGNMENT: usize = align_of::<CProfile>();
/// No pointer, or one that is not aligned.
pub const NO_POINTER: i32 = -1;
/// Less memory than a profile needs.
pub const TOO_SMALL: i32 = -2;
/// Nothing was estimated yet.
pub const NOTHING_YET: i32 = 2;
/// Reason of a status that has none.
pub const NO_REASON: u32 = u32::MAX;

/// One sample.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideslipSample {
    /// Its time, s.
    pub time_s: f64,
    /// Values by `Channel::index()`, SI and radians; NaN where the channel was not sampled.
    pub channels: [f64; CHANNELS],
}

impl SideslipSample {
    /// Its bytes in a file, little-endian numbers one after the other.
    pub const BYTES: usize = 8 * (1 + CHANNELS);

    /// The sample of those bytes.
    pub fn from_le_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let (numbers, _) = bytes.as_chunks::<8>();
        let number = |place: usize| numbers.get(place).map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes));
        SideslipSample { time_s: number(0), channels: core::array::from_fn(|channel| number(1 + channel)) }
    }
}

impl From<&Sample> for SideslipSample {
    fn from(sample: &Sample) -> Self {
        let channels = Channel::ALL.map(|channel| sample.get(channel).unwrap_or(f64::NAN));
        SideslipSample { time_s: sample.time_s, channels }
    }
}

impl From<&SideslipSample> for Sample {
    fn from(from: &SideslipSample) -> Self {
        let mut sample = Sample::new(from.time_s);
        for (channel, value) in Channel::ALL.into_iter().zip(from.channels) {
            if !value.is_nan() {
                sample.set(channel, value);
            }
        }
        sample
    }
}

/// A pair of conjugate roots; NaN where there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideslipMode {
    /// Undamped natural frequency and its standard error, rad/s.
    pub omega: [f64; 2],
    /// Damping ratio and its standard error.
    pub zeta: [f64; 2],
}

/// The newest estimates.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideslipEstimates {
    /// Time of the newest sample in them, s.
    pub time_s: f64,
    /// Derivatives by axis and variable, SI and radians; NaN where there is no number.
    pub derivatives: [[f64; VARIABLES]; AXES],
    /// Their standard errors.
    pub standard_errors: [[f64; VARIABLES]; AXES],
    /// Dutch roll of the lateral equations.
    pub dutch_roll: SideslipMode,
    /// Status of every equation, by `Status::rank`.
    pub status: [u32; AXES],
    /// Why an equation has no number, by `Reason::code`.
    pub reason: [u32; AXES],
    /// Status of the modes.
    pub modes_status: u32,
    /// Why they have no number.
    pub modes_reason: u32,
}

/// A profile with its newest estimates.
#[repr(C)]
#[derive(Debug)]
struct CProfile {
    profile: Profile,
    estimates: SideslipEstimates,
}

/// What a profile begins with: copied, so that no stack is needed for it.
static BEGIN: CProfile = CProfile { profile: Profile::new(&SETTINGS, RunGeometry::DEFAULT), estimates: SideslipEstimates::NONE };

impl SideslipEstimates {
    /// Before the first.
    pub const NONE: SideslipEstimates = SideslipEstimates {
        time_s: f64::NAN,
        derivatives: [[f64::NAN; VARIABLES]; AXES],
        standard_errors: [[f64::NAN; VARIABLES]; AXES],
        dutch_roll: SideslipMode { omega: [f64::NAN; 2], zeta: [f64::NAN; 2] },
        status: [1; AXES],
        reason: [NO_REASON; AXES],
        modes_status: 1,
        modes_reason: NO_REASON,
    };

    /// Takes what a sample brought; `false` where that was nothing new.
    pub fn take(&mut self, tick: &Tick) -> bool {
        let Some(derivatives) = &tick.derivatives else { return false };
        *self = SideslipEstimates { time_s: derivatives.time_s, ..SideslipEstimates::NONE };
        for equation in &derivatives.equations {
            let axis = equation.axis.index();
            (self.status[axis], self.reason[axis]) = codes(equation.status);
            for (term, variable) in equation.terms.iter().filter_map(|term| Some((term, term.variable?))) {
                self.derivatives[axis][variable.index()] = term.value;
                self.standard_errors[axis][variable.index()] = term.std;
            }
        }
        if let Some(modes) = &tick.modes {
            (self.modes_status, self.modes_reason) = codes(modes.status);
            if let Some(OscillatoryMode { omega, std_omega, zeta, std_zeta, .. }) = modes.dutch_roll {
                self.dutch_roll = SideslipMode { omega: [omega, std_omega], zeta: [zeta, std_zeta] };
            }
        }
        true
    }
}

fn codes(status: Status) -> (u32, u32) {
    let reason = if let Status::NotIdentifiable(reason) = status { reason.code() } else { NO_REASON };
    (u32::from(status.rank()), reason)
}

fn is_usable<T>(pointer: *const T) -> bool {
    !pointer.is_null() && pointer.is_aligned()
}

/// Bytes of memory that a profile needs, aligned to [`ALIGNMENT`].
#[unsafe(no_mangle)]
pub extern "C" fn sideslip_profile_bytes() -> usize {
    size_of::<CProfile>()
}

/// Makes a profile of that memory, ready for the first sample of a run; the same again for the next run.
///
/// # Safety
/// `memory` has that many bytes, which nothing else uses meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sideslip_init(memory: *mut c_void, bytes: usize) -> i32 {
    let profile = memory.cast::<CProfile>();
    if !is_usable(profile) {
        return NO_POINTER;
    }
    if bytes < size_of::<CProfile>() {
        return TOO_SMALL;
    }
    // SAFETY: the caller's memory is large enough and aligned; nothing in a profile is owned, so a copy of it is one.
    unsafe { core::ptr::copy_nonoverlapping(&raw const BEGIN, profile, 1) };
    0
}

/// One sample.
///
/// # Safety
/// `profile` is memory that [`sideslip_init`] returned 0 for, and `sample` a sample; nothing else uses them meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sideslip_step(profile: *mut c_void, sample: *const SideslipSample) -> i32 {
    let profile = profile.cast::<CProfile>();
    if !is_usable(profile) || !is_usable(sample) {
        return NO_POINTER;
    }
    // SAFETY: the caller's promise.
    let (profile, sample) = unsafe { (&mut *profile, &*sample) };
    i32::from(profile.estimates.take(profile.profile.step(&Sample::from(sample))))
}

/// Copies the newest estimates.
///
/// # Safety
/// As of [`sideslip_step`]; `estimates` has room for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sideslip_estimates(profile: *const c_void, estimates: *mut SideslipEstimates) -> i32 {
    let profile = profile.cast::<CProfile>();
    if !is_usable(profile) || !is_usable(estimates) {
        return NO_POINTER;
    }
    // SAFETY: the caller's promise.
    unsafe { *estimates = (*profile).estimates };
    // SAFETY: as above.
    if unsafe { (*profile).estimates.time_s }.is_nan() { NOTHING_YET } else { 0 }
}
