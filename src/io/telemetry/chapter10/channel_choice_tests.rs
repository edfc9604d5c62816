//! Setups written by hand: which channel is chosen, and what is said where none is.

use super::*;

/// A PCM channel with the measurements of these names.
fn channel(number: u16, names: &[&str]) -> String {
    let mut text = format!(
        "R-1\\TK1-{number}:{number};R-1\\CDLN-{number}:L{number};P-{number}\\DLN:L{number};P-{number}\\D1:NRZ-L;\
         P-{number}\\D2:100000;\
         P-{number}\\F1:16;P-{number}\\MF1:20;P-{number}\\MF4:32;P-{number}\\MF5:11111110011010110010100001000000;\
         D-{number}\\DLN:L{number};D-{number}\\MN\\N-1:{};",
        names.len()
    );
    for (n, name) in (1..).zip(names) {
        text += &format!(
            "D-{number}\\MN-1-{n}:{name};D-{number}\\WP-1-{n}-1-1:{n};C-{number}{n}\\DCN:{name};C-{number}{n}\\MN3:DEG/S;"
        );
    }
    text
}

fn chosen(text: &str, map: &str) -> Result<ChosenChannel, String> {
    FrameDescription::from_toml(map).unwrap().choose(text.as_bytes())
}

#[test]
fn the_channel_that_has_channels_of_the_program_is_read() {
    let setup = channel(3, &["P", "OIL"]) + &channel(4, &["OIL"]) + "R-1\\TK1-9:9;R-1\\CDLN-9:BUS;";
    let found = chosen(&setup, "").unwrap();
    assert_eq!((found.channel, found.format.parameters().len()), (Some(3), 2));
    assert_eq!(found.format.parameters()[0].name, "p");
    let named = chosen(&setup, "channel = 4\n[measurements]\nq = \"OIL\"\n[run]\naircraft = \"Puma\"\n").unwrap();
    assert_eq!((named.channel, named.info.aircraft()), (Some(4), Some("Puma")));
}

#[test]
fn what_is_not_clear_is_refused_with_what_there_is_and_what_to_do() {
    let two = channel(3, &["P"]) + &channel(4, &["Q", "R"]);
    let said = chosen(&two, "").unwrap_err();
    assert!(said.contains("channel 3 (1 of them), channel 4 (2 of them)") && said.contains("`channel = 3`"), "{said}");
    assert_eq!(chosen(&two, "channel = 4").map(|found| found.channel), Ok(Some(4)));
    assert!(chosen(&two, "channel = 7").unwrap_err().contains("no channel 7"));
    let names: Vec<String> = (0..30).map(|n| format!("M{n}")).collect();
    let names: Vec<&str> = names.iter().take(19).map(String::as_str).collect();
    let said = chosen(&(channel(3, &names) + &channel(4, &[])), "").unwrap_err();
    for words in
        ["PCM channel 3 (L3) has `M0`", "`M11` and 7 more", "PCM channel 4 (L4) has no measurement", "[measurements]", "--config"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = chosen(&channel(3, &["P"]), "[measurements]\nq = \"PITCH RATE\"\n").unwrap_err();
    assert!(said.contains("`PITCH RATE` for q") && said.contains("`p`"), "{said}");
    assert!(chosen("", "").unwrap_err().contains("no setup (TMATS)"));
    assert!(chosen("R-1\\TK1-9:9;", "").unwrap_err().contains("it has no PCM channel"));
}
