//! The header of the C interface, written from the declarations themselves: numbers, names and sizes cannot differ.

use super::{
    ALIGNMENT, NO_POINTER, NO_REASON, NOTHING_YET, SideslipEstimates, SideslipMode, SideslipSample, TOO_SMALL,
    sideslip_profile_bytes,
};
use core::fmt::{Result, Write};
use core::mem::offset_of;
use sideslip::flight::channel::{CHANNELS, Channel, ControlNames};
use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::realtime::regression::record::{Reason, Status};

/// Every reason once, with a name for C.
fn reasons() -> [(&'static str, Reason); 14] {
    let (channel, axis, variable) = (Channel::Ay, Axis::N, Variable::V);
    [
        ("NO_RATES", Reason::NoRates),
        ("NO_ACCELEROMETER", Reason::NoAccelerometer { channel }),
        ("RATE_TOO_LOW", Reason::RateTooLow { hz: 0.0, needed_hz: 0.0 }),
        ("UNOBSERVED", Reason::Unobserved { variable, missing: channel }),
        ("COLLINEAR", Reason::Collinear { condition_index: 0.0 }),
        ("NOT_EXCITED", Reason::NotExcited { axis, variable }),
        ("EQUATION", Reason::Equation { axis }),
        ("NO_TRIM", Reason::NoTrim { channel }),
        ("AID_REJECTED", Reason::AidRejected { channel }),
        ("UNRESOLVED", Reason::Unresolved),
        ("INSTRUMENT_DOUBTED", Reason::InstrumentDoubted { channel: None }),
        ("NOT_CONFIRMED", Reason::NotConfirmed { channel }),
        ("NO_INPUT", Reason::NoInput),
        ("NO_CONTROL", Reason::NoControl),
    ]
}

const STATUSES: [(&str, Status); 8] = [
    ("NOT_IDENTIFIABLE", Status::NotIdentifiable(Reason::Unresolved)),
    ("WAITING", Status::Waiting),
    ("EXCITING", Status::Exciting),
    ("STALE", Status::Stale),
    ("DEPENDS_ON_AMPLITUDE", Status::DependsOnAmplitude),
    ("DISAGREE", Status::Disagree),
    ("CONVERGING", Status::Converging),
    ("CONVERGED", Status::Converged),
];

/// A name in upper case.
struct Upper(&'static str);

impl core::fmt::Display for Upper {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> Result {
        self.0.chars().try_for_each(|letter| f.write_char(letter.to_ascii_uppercase()))
    }
}

fn enumeration<T>(out: &mut impl Write, what: &str, prefix: &str, all: impl Iterator<Item = (T, u32)>) -> Result
where
    T: core::fmt::Display,
{
    write!(out, "\n/* {what} */\nenum {{\n")?;
    for (name, number) in all {
        writeln!(out, "    SIDESLIP_{prefix}{name} = {number},")?;
    }
    out.write_str("};\n")
}

/// Writes `include/sideslip.h`, whose checks of sizes hold where a `double` is aligned to 8 bytes.
///
/// # Errors
/// Those of `out`.
pub fn header(out: &mut impl Write) -> Result {
    write!(
        out,
        "/* The Sideslip profile for C. Written by `firmware-profile --c-header`; SI and radians; NaN is no number. */\n\
         #ifndef SIDESLIP_H\n#define SIDESLIP_H\n\n#include <stddef.h>\n#include <stdint.h>\n\n#ifdef __cplusplus\nextern \"C\" {{\n\
         #define SIDESLIP_ASSERT static_assert\n#else\n#define SIDESLIP_ASSERT _Static_assert\n#endif\n\n\
         #define SIDESLIP_CHANNELS {CHANNELS}\n#define SIDESLIP_AXES {AXES}\n#define SIDESLIP_VARIABLES {VARIABLES}\n\
         /* Memory of a profile on a 64-bit host, bytes; elsewhere it is less, see sideslip_profile_bytes. */\n\
         #define SIDESLIP_PROFILE_BYTES {}\n#define SIDESLIP_PROFILE_ALIGNMENT {ALIGNMENT}\n",
        sideslip_profile_bytes()
    )?;
    let number = |index: usize| u32::try_from(index).unwrap_or(u32::MAX);
    let channels =
        Channel::ALL.into_iter().map(|channel| (Upper(channel.name(ControlNames::default())), number(channel.index())));
    enumeration(out, "Places in SideslipSample.channels.", "CHANNEL_", channels)?;
    let axes = Axis::ALL.into_iter().map(|axis| (axis.name(), number(axis.index())));
    enumeration(out, "Equations: forces X Y Z by mass, moments L M N as angular accelerations.", "AXIS_", axes)?;
    let variables =
        Variable::ALL.into_iter().map(|variable| (Upper(variable.name(ControlNames::default())), number(variable.index())));
    enumeration(out, "What a derivative is taken with respect to.", "VARIABLE_", variables)?;
    let statuses = STATUSES.into_iter().map(|(name, status)| (name, u32::from(status.rank())));
    enumeration(
        out,
        "How far along an answer is; there are numbers from STALE on; CONVERGED alone is to be relied upon.",
        "",
        statuses,
    )?;
    let reasons = reasons().into_iter().map(|(name, reason)| (name, reason.code()));
    enumeration(out, "Why an answer is NOT_IDENTIFIABLE.", "REASON_", reasons)?;
    write!(
        out,
        "#define SIDESLIP_NO_REASON {NO_REASON}u\n\n/* Errors, and what is none. */\n#define SIDESLIP_NO_POINTER ({NO_POINTER})\n\
         #define SIDESLIP_TOO_SMALL ({TOO_SMALL})\n#define SIDESLIP_NOTHING_YET {NOTHING_YET}\n\n\
         typedef struct {{\n    double time_s;\n    double channels[SIDESLIP_CHANNELS];\n}} SideslipSample;\n\n\
         /* A value and its standard error each. */\n\
         typedef struct {{\n    double omega[2];\n    double zeta[2];\n}} SideslipMode;\n\n\
         typedef struct {{\n    double time_s;\n    double derivatives[SIDESLIP_AXES][SIDESLIP_VARIABLES];\n\
         \x20   double standard_errors[SIDESLIP_AXES][SIDESLIP_VARIABLES];\n    SideslipMode dutch_roll;\n\
         \x20   uint32_t status[SIDESLIP_AXES];\n    uint32_t reason[SIDESLIP_AXES];\n    uint32_t modes_status;\n\
         \x20   uint32_t modes_reason;\n}} SideslipEstimates;\n\n"
    )?;
    let sizes = [
        ("SideslipSample", size_of::<SideslipSample>()),
        ("SideslipMode", size_of::<SideslipMode>()),
        ("SideslipEstimates", size_of::<SideslipEstimates>()),
    ];
    for (name, bytes) in sizes {
        writeln!(out, "SIDESLIP_ASSERT(sizeof({name}) == {bytes}, \"{name} is not the library's\");")?;
    }
    let place = offset_of!(SideslipEstimates, status);
    write!(
        out,
        "SIDESLIP_ASSERT(offsetof(SideslipEstimates, status) == {place}, \"SideslipEstimates is not the library's\");\n\n\
         /* Bytes of memory that a profile needs, aligned to SIDESLIP_PROFILE_ALIGNMENT. */\n\
         size_t sideslip_profile_bytes(void);\n\
         /* Makes a profile of that memory, ready for a run. 0, SIDESLIP_NO_POINTER or SIDESLIP_TOO_SMALL. */\n\
         int32_t sideslip_init(void *memory, size_t bytes);\n\
         /* One sample. 1 where estimates are new, else 0, or SIDESLIP_NO_POINTER. */\n\
         int32_t sideslip_step(void *profile, const SideslipSample *sample);\n\
         /* Copies the newest estimates. 0, SIDESLIP_NOTHING_YET before any, or SIDESLIP_NO_POINTER. */\n\
         int32_t sideslip_estimates(const void *profile, SideslipEstimates *estimates);\n\n\
         #ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
}
