//! Writes a recording as samples of the C interface, one `SideslipSample` after the other:
//! `cargo run -p firmware-profile --example recorded_samples -- RUN OUT`.

use firmware_profile::c_interface::SideslipSample;
use sideslip::io::telemetry::recording::Recording;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [run, out] = arguments.as_slice() else { return Err("expected RUN OUT".into()) };
    let mut recording = Recording::open(Path::new(run))?;
    let mut file = BufWriter::new(File::create(out)?);
    while let Some(row) = recording.next_row()? {
        let SideslipSample { time_s, channels } = SideslipSample::from(&row.sample);
        for number in [time_s].into_iter().chain(channels) {
            file.write_all(&number.to_le_bytes())?;
        }
    }
    Ok(file.flush()?)
}
