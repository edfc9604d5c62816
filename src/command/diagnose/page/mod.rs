//! The report: the causes and their evidence, every run beside both models, the improvement, the limits of the data.
//!
//! Consumes the answer and the runs; produces one page of `outputs::page` without scripts, fonts or network. Names come from
//! files and are made safe wherever they stand.

mod answer;
mod causes;
mod flights;
mod gained;
mod parts;
mod residuals;

use crate::command::diagnose::answer::{Answer, Flights};
use crate::command::terminal::output_file::write_whole;
use sideslip::error::Failure;
use sideslip::io::outputs::charts::chart::ChartError;
use sideslip::io::outputs::html::page::{FOOT, escaped, head};
use std::fmt::Write;
use std::path::Path;

fn text(answer: &Answer, flights: &Flights<'_>) -> Result<String, Failure> {
    let drawn = |error: ChartError| Failure::Running(error.to_string());
    let name = format!("Diagnosis of {}", answer.model.file.name);
    let mut page = head(&name);
    let _ = writeln!(page, "<h1>{}</h1>", escaped(&name));
    let names = |runs: &[sideslip::postflight::recorded_run::RecordedRun]| {
        runs.iter().map(|run| escaped(&run.name)).collect::<Vec<_>>().join(", ")
    };
    let kept = if flights.holdout.is_empty() { "none".to_owned() } else { names(flights.holdout) };
    let _ = writeln!(page, "<p class=\"faint\">Fitted runs: {}. Hold-out runs: {kept}.</p>", names(flights.fit));
    answer::section(&mut page, answer);
    causes::section(&mut page, answer).map_err(drawn)?;
    flights::section(&mut page, answer, flights)?;
    residuals::section(&mut page, answer).map_err(drawn)?;
    gained::section(&mut page, answer, flights).map_err(drawn)?;
    answer::limits(&mut page, answer, flights);
    page.push_str(FOOT);
    Ok(page)
}

/// Writes the page to a file.
pub(super) fn write(path: &Path, answer: &Answer, flights: &Flights<'_>) -> Result<(), Failure> {
    let text = text(answer, flights)?;
    write_whole(path, |file| file.write_all(flights.provenance.at_the_foot_of(&text).as_bytes()))
}
