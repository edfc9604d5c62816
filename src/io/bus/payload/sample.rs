//! Payload of a sample: the known channels in SI, and as many of the unknown columns as fit.

use super::message::{MessageHeader, service};
use crate::flight::channel::CHANNELS;
use crate::flight::sample::Sample;
use iceoryx2::prelude::ZeroCopySend;

/// Columns besides the known channels that a sample carries; a source with more says which it leaves out.
pub const OTHERS: usize = 32;

/// [`SamplePayload::kind`]: a sample.
pub const SAMPLE: u32 = 0;
/// [`SamplePayload::kind`]: the run ends here; there is no sample in it.
pub const THE_END: u32 = 1;
/// [`SamplePayload::kind`]: a sample whose publisher waits until it was taken, so that none is lost.
pub const SAMPLE_TO_ACKNOWLEDGE: u32 = 2;

/// A sample.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Sample.1")]
pub struct SamplePayload {
    /// Its header; `time_s` is the sample's.
    pub header: MessageHeader,
    /// [`SAMPLE`], [`SAMPLE_TO_ACKNOWLEDGE`] or [`THE_END`].
    pub kind: u32,
    /// Bit by channel index where it was sampled.
    pub present: u32,
    /// Values by channel index, SI.
    pub values: [f64; CHANNELS],
    /// The other columns in their order, as they came; NaN where not sampled, or no such column.
    pub others: [f64; OTHERS],
}
service!(SamplePayload, "sideslip/sample", "sideslip.Sample.1", buffer 1024, history 1024);

impl SamplePayload {
    /// A sample with its other columns.
    pub fn new(sample: &Sample, others: impl Iterator<Item = f64>, kind: u32) -> Self {
        let mut payload = SamplePayload {
            header: MessageHeader { time_s: sample.time_s, ..MessageHeader::default() },
            kind,
            present: sample.present,
            values: sample.values,
            others: [f64::NAN; OTHERS],
        };
        payload.others.iter_mut().zip(others).for_each(|(to, from)| *to = from);
        payload
    }

    /// The end of a run.
    pub fn the_end(time_s: f64) -> Self {
        SamplePayload::new(&Sample::new(time_s), std::iter::empty(), THE_END)
    }

    /// The sample.
    pub fn sample(&self) -> Sample {
        Sample { time_s: self.header.time_s, present: self.present, values: self.values }
    }
}
