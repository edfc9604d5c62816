//! The setups of the recordings, and what they say against the data.

use super::chapter10::{read, recording};
use sideslip::io::telemetry::chapter10::packet::Integrity;
use sideslip::io::telemetry::chapter10::pcm_data::PcmMode;
use sideslip::io::telemetry::chapter10::tmats::{SetupRecord, Tmats};
use sideslip::io::telemetry::chapter10::tmats_check::PcmEvidence;
use sideslip::io::telemetry::chapter10::tmats_pcm::TmatsPcmFormat;
use std::collections::BTreeMap;

/// Edition and attributes of a recording.
fn setup(bytes: &[u8]) -> (u8, Vec<u8>) {
    let mut found = (0xFF, Vec::new());
    read(bytes, 1 << 16, |packet| {
        if let Ok(setup) = SetupRecord::parse(packet) {
            found.0 = setup.edition;
            found.1.extend_from_slice(setup.text);
        }
    });
    found
}

/// Pattern, distance and frames that were measured, and the contradictions in words.
type Told = (Option<(u64, u64, u64)>, Vec<String>);

/// What is told of each PCM channel.
fn told(bytes: &[u8], others: &[(u64, u8)]) -> BTreeMap<u16, Told> {
    let tmats = Tmats::parse(&setup(bytes).1);
    let mut channels: BTreeMap<u16, (TmatsPcmFormat, PcmEvidence)> = BTreeMap::new();
    read(bytes, 1 << 16, |packet| {
        if packet.header.data_type == 0x09 {
            let (_, evidence) = channels.entry(packet.header.channel).or_insert_with(|| {
                let format = TmatsPcmFormat::of_channel(&tmats, packet.header.channel).unwrap();
                let evidence = PcmEvidence::new(Some(&format), others);
                (format, evidence)
            });
            assert_eq!(packet.integrity, Integrity::Verified);
            evidence.packet(packet);
        }
    });
    let words = |(format, evidence): (TmatsPcmFormat, PcmEvidence)| {
        let found = evidence.recurrence().map(|found| (found.pattern, found.period, found.frames));
        (found, evidence.contradictions(&format).iter().map(ToString::to_string).collect())
    };
    channels.into_iter().map(|(channel, known)| (channel, words(known))).collect()
}

#[test]
fn the_setup_that_contradicts_its_data_is_told_in_words() {
    let Some(bytes) = recording("pcm_old_101348.c10") else { return };
    let told = told(&bytes, &[]);
    for (channel, (_, words)) in &told {
        words.iter().for_each(|words| println!("channel {channel}: {words}"));
    }
    let frame = "TMATS says 224 bits in a minor frame (P-1\\MF2), the data say 4096 (83 frames)";
    assert_eq!(told[&10], (Some((0x1F74_E949, 4096, 83)), vec![frame.to_owned()]));
    assert_eq!(told[&11], (Some((0x1F74_E949, 4096, 83)), Vec::new()));
}

#[test]
fn right_setups_are_not_contradicted_and_noise_has_no_frames() {
    let (Some(err), Some(pcm)) = (recording("err.c10"), recording("pcm.c10")) else { return };
    assert_eq!(told(&err, &[])[&10], (Some((0x1F74_E949, 320, 9768)), Vec::new()));
    let told = told(&pcm, &[(0xEB90, 16), (0x1F74_E949, 32)]);
    for channel in [51, 53, 54] {
        assert_eq!(told[&channel], (None, Vec::new()), "{channel}");
    }
    assert_eq!(told[&52], (Some((0xFE6B_2840, 512, 511)), Vec::new()));
    // In a frame of 512 bits with its header of 80.
    assert_eq!(told[&55], (Some((0xFE6B_2840, 592, 883)), Vec::new()));
    assert_eq!(told[&56], (Some((0xFE6B_2840, 592, 883)), Vec::new()));
}

#[test]
fn the_texts_beside_the_recordings_are_those_in_them() {
    for (name, text, edition, attributes) in [
        ("err.c10", "tmats_err.txt", 7, 543),
        ("pcm.c10", "tmats_pcm.txt", 0, 937),
        ("pcm_old_101348.c10", "tmats_pcm_old_101348.txt", 8, 845),
    ] {
        let (Some(bytes), Some(text)) = (recording(name), recording(&format!("tmats/{text}"))) else { return };
        let (found, setup) = setup(&bytes);
        let (inside, beside) = (Tmats::parse(&setup), Tmats::parse(&text));
        assert_eq!(found, edition, "{name}");
        let tally = inside.tally();
        println!("{name}: {tally:?}");
        assert_eq!((tally.unreadable, tally.swallowed, tally.unfinished_bytes), (0, 0, 0), "{name}");
        assert_eq!(tally.attributes, attributes, "{name}");
        assert!(inside.attributes().eq(beside.attributes()), "{name}");
    }
}

#[test]
fn setups_of_other_recorders_are_read() {
    for name in ["ADAU_adau_FMT_1.tmt", "tmats_analog.txt", "tmats_discrete.txt", "tmats_ethernet.txt", "tmats_sample.txt"] {
        let Some(text) = recording(&format!("tmats/{name}")) else { return };
        let tmats = Tmats::parse(&text);
        println!("{name}: {:?}", tmats.tally());
        assert_eq!(tmats.tally().unreadable, 0, "{name}");
    }
    let Some(text) = recording("tmats/ADAU_adau_FMT_1.tmt") else { return };
    let tmats = Tmats::parse(&text);
    // Two comments without their semicolon take the statement behind it with them.
    assert_eq!((tmats.tally().swallowed, tmats.get("R-1\\MRC\\E")), (2, None));
    let format = TmatsPcmFormat::of_channel(&tmats, 1).unwrap();
    assert_eq!((format.sync_pattern, format.frame_bits, format.mode), (Some(0xFE6B_2840), Some(512), Some(PcmMode::Unpacked)));
    assert_eq!((format.sync_criteria, format.counters[0].bits), ([Some(2), Some(2), Some(16), Some(2)], Some(2)));
    assert_eq!((format.layout().map(|layout| layout.frame_bits()), format.unreadable), (Some(512), Vec::<String>::new()));
}
