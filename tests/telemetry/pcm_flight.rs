//! A simulated Puma telemetered as PCM, against the same samples as they were measured: the same derivatives.
//!
//! Gate: a tenth of a standard error in each derivative that has a number.

use super::derivatives::{apart, derivatives};
use super::pcm_link::{Guard, flown, format, received, sent, words};
use sideslip::flight::sample::Sample;

/// What the format takes of each sample.
pub(super) fn kept(samples: &[Sample]) -> Vec<Sample> {
    let of = |(frame, sample): (u32, &Sample)| {
        let mut kept = Sample::new(sample.time_s);
        for word in words().into_iter().filter(|word| frame % word.every == 0) {
            sample.get(word.channel).into_iter().for_each(|value| kept.set(word.channel, value));
        }
        kept
    };
    (0..).zip(samples).map(of).collect()
}

#[test]
fn a_puma_by_pcm_has_the_derivatives_of_its_samples() {
    let (samples, format) = (flown(11), format(Guard::None));
    let measured = kept(&samples);
    let received = received(&format, &sent(&format, &samples)).samples;
    // The words of a frame are one row here: 20 of 16 bits and the pattern are a third of a millisecond.
    assert_eq!(received.len(), measured.len());
    for (sent, got) in measured.iter().zip(&received) {
        assert_eq!(sent.present, got.present);
        assert!((0.0..0.4e-3).contains(&(got.time_s - sent.time_s)));
    }

    let found = apart(&derivatives(&measured), &derivatives(&received));
    eprintln!("{found:?}");
    assert!(found.compared > 12 && found.largest <= 0.1 && found.different.is_empty(), "{found:?}");
}
