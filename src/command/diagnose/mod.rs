//! `sideslip diagnose`: what a model gets wrong, its cause, the extended model, the gain on runs it never saw.

use super::flight_condition::read_model;
use super::ingest::head_of;
use super::mapping_input::read_mapping;
use sideslip::diagnosis::aircraft::Aircraft;
use sideslip::diagnosis::problem::Problem;
use sideslip::diagnosis::record::Record;
use sideslip::diagnosis::search::{Settings, search};
use sideslip::error::{Failure, Outcome};
use sideslip::simulation::flight_model::Asked;
use sideslip::telemetry::mavlink::mapping::Config as Mapping;
use sideslip::telemetry::recording::Recording;
use std::path::{Path, PathBuf};

/// Say what a model gets wrong, and why
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The model: a file, or puma
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// A recording to be explained; repeatable
    #[arg(long, value_name = "RUN", num_args = 1.., required = true)]
    fit: Vec<PathBuf>,
    /// A recording to measure the gain on; repeatable
    #[arg(long, value_name = "RUN", num_args = 1..)]
    holdout: Vec<PathBuf>,
}

fn read(file: &Path, mapping: &Mapping) -> Result<Record, Failure> {
    let mut recording = Recording::open_with(file, mapping)?;
    let (info, _) = head_of(file, &recording, &[])?;
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row()? {
        samples.push(row.sample);
    }
    let name = info.run().unwrap_or_default().to_owned();
    Record::of(&name, &samples, *info.geometry()).map_err(|wrong| Failure::file(file, wrong))
}

/// Diagnoses.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let mapping = read_mapping(None)?;
    let model = read_model(&args.model, &Asked::default(), "")?;
    let runs = args.fit.iter().map(|file| read(file, &mapping)).collect::<Result<Vec<_>, _>>()?;
    let problem = Problem::new(Aircraft::of(&model), runs, model.file.tolerance);
    let begun = std::time::Instant::now();
    let Some(found) = search(&problem, &Settings::default()) else {
        return Err(Failure::Running("the model can not be flown along these runs".to_owned()));
    };
    let text = |effect| format!("{effect:?}");
    for (hypothesis, rivals) in found.point.hypotheses.iter().zip(&found.rivals) {
        println!("{}", text(&hypothesis.effect));
        for rival in rivals.iter().take(8) {
            println!("   {:8.1} {} {} +- {:.4}", rival.odds, if rival.fitted { "fit" } else { "   " }, text(&rival.effect), rival.std);
        }
    }
    println!("base {:.0} now {:.0} force noise {:?} -> {:?} least {:?}", found.base.1.cost, found.local.cost, found.base.0.force, found.point.force, problem.least);
    for (c, channel) in sideslip::diagnosis::record::OUTPUT_CHANNELS.iter().enumerate() {
        let sum = found.local.runs.iter().fold((0.0, 0.0), |s, r| (s.0 + r.squares[c].0, s.1 + r.squares[c].1));
        print!("{channel:?} {:.2} ({:.4}) ", sum.0 / sum.1, problem.runs[0].output_noise[c]);
    }
    println!("\n{:.1} s", begun.elapsed().as_secs_f64());
    Ok(Outcome::Done)
}
