//! The same samples give the same bits, whatever went before and whoever carries the pipeline on.

use crate::support::fingerprint::Fingerprint;
use crate::support::firmware_manoeuvre::ManoeuvreSamples;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};

fn pipeline() -> Box<Pipeline> {
    Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap())
}

#[test]
fn a_second_flight_has_the_same_bits() {
    let (mut first, mut second) = (pipeline(), pipeline());
    for sample in ManoeuvreSamples::default() {
        // Text holds every field, and a float's text is its bits.
        assert_eq!(format!("{:?}", first.step(&sample)), format!("{:?}", second.step(&sample)));
    }
    assert_eq!(format!("{:?}", first.finish()), format!("{:?}", second.finish()));
}

#[test]
fn a_copy_taken_in_flight_goes_on_with_the_same_bits() {
    let mut original = pipeline();
    let mut copy = None;
    let (mut ours, mut its) = (Fingerprint::default(), Fingerprint::default());
    for (i, sample) in ManoeuvreSamples::default().enumerate() {
        if i == 777 {
            copy = Some(original.clone());
            ours = Fingerprint::default();
        }
        ours.take(original.step(&sample));
        if let Some(copy) = &mut copy {
            its.take(copy.step(&sample));
        }
    }
    assert_eq!(ours, its);
    assert_ne!(ours, Fingerprint::default());
}

/// A change of one part in 10^10 in one reading changes the fingerprint: it does look at what it says.
#[test]
fn another_reading_is_another_fingerprint() {
    let print = |touch: bool| {
        let (mut pipeline, mut fingerprint) = (pipeline(), Fingerprint::default());
        for (i, mut sample) in ManoeuvreSamples::default().take(200).enumerate() {
            if touch && i == 100 {
                sample.values[0] = f64::from_bits(sample.values[0].to_bits() ^ (1 << 20));
            }
            fingerprint.take(pipeline.step(&sample));
        }
        fingerprint
    };
    assert_eq!(print(false), print(false));
    assert_ne!(print(false), print(true));
}
