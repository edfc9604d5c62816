//! `sideslip demo`: the main job on this machine, nothing to set up.
//!
//! A simulated helicopter whose derivatives are known flies test inputs at three test points and sends MAVLink over the loopback,
//! as its radio would, and at one of them PCM too; `live` takes it up in processes of its own and estimates, and this process
//! reads the estimates from shared memory, as any reader can. Then `diagnose` says what a Level-1 simulation of such a
//! helicopter gets wrong in those flights, and the table of section 4 of Padfield et al. 1987 has simulation, estimate, extended
//! model and truth side by side.

mod child_guard;
mod diagnosis_child;
mod live_child;
mod live_table;
mod pcm_vehicle;
mod result_table;
mod test_flight;
mod test_run;

use super::terminal::console::print;
use super::terminal::output_file::write_json;
use super::terminal::stop::stopped_by_signals;
use crate::command::message;
use result_table::ResultTable;
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::tables::terminal::Style;
use std::path::PathBuf;
use test_flight::{RATE_HZ, RUNS, TEST_POINTS};
use test_run::{DemoLink, FlownRun, fly_run};

const EXAMPLE: &str = "\
Example:
  sideslip demo
  sideslip demo --speed 1 --seed 3 --out trial/

On a terminal the estimates are shown while they come; it ends with the table of the README (simulation, live
estimate, extended model, and the truth) and the paths of logs, numbers and pages. Everything stays on this machine (127.0.0.1).
While a run is flown, `sideslip watch --root DIR` with the root that it names shows the same to anybody.

Exit status: 0 done; 1 failed while running; 2 the call is wrong; 3 done, with data lost (said how much).";

/// Fly a simulated helicopter at three test points, estimate live over MAVLink, diagnose a simulation, compare with the truth
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct DemoArgs {
    /// Directory for logs, numbers and pages (made where it is missing)
    #[arg(long, value_name = "DIR", default_value = "sideslip-demo")]
    out: PathBuf,
    /// How many times faster than real time it flies
    #[arg(long, value_name = "N", default_value = "4", value_parser = speed)]
    speed: f64,
    /// Seed of the instruments' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the last estimates, those of the climb, as JSON to this file too, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The test point that is flown by both links.
const BY_BOTH: &str = "level";

/// How far the live estimates of a flight by PCM are from those of the same flight by MAVLink.
fn links_compared(point: &str, by_mavlink: &FlownRun, by_pcm: &FlownRun) -> String {
    let (mut compared, mut largest) = (0, 0.0_f64);
    let equations = &by_mavlink.estimate.derivatives.equations;
    for (one, other) in equations.iter().zip(&by_pcm.estimate.derivatives.equations) {
        for term in &one.terms {
            let Some(found) = term.variable.and_then(|variable| other.term(variable)) else { continue };
            compared += 1;
            largest = largest.max((found.value - term.value).abs() / term.std);
        }
    }
    format!("{point} by PCM instead of MAVLink: {compared} derivatives, at most {largest:.2} standard errors apart.\n")
}

fn speed(text: &str) -> Result<f64, String> {
    let factor = text.parse::<f64>().ok().filter(|factor| (0.25..=20.0).contains(factor));
    factor.ok_or_else(|| format!("expected a factor from 0.25 to 20, found `{text}`"))
}

/// Flies, estimates, diagnoses, compares.
pub(crate) fn run(args: &DemoArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    std::fs::create_dir_all(&args.out).map_err(|error| Failure::io(&args.out, &error))?;
    let pilot = RUNS.each_ref().map(|run| format!("{} ({})", run.inputs(), run.name));
    message(format_args!(
        "A helicopter flies three test points, {} times real time: {}\nIts telemetry is MAVLink at {RATE_HZ:.0} Hz over the loopback, at level flight PCM too; \
         each run is estimated live and logged",
        args.speed,
        pilot.join("; ")
    ));
    let mut flown: Vec<[FlownRun; 2]> = Vec::new();
    let mut both_links = String::new();
    for point in &TEST_POINTS {
        let seed = args.seed.wrapping_mul(10).wrapping_add(2 * flown.len() as u64);
        message(format_args!("  {}", point.name));
        let [fit, kept] = &RUNS;
        let flown_fit = fly_run((point, fit, DemoLink::Mavlink), &args.out, (args.speed, seed), &stop)?;
        let flown_kept = fly_run((point, kept, DemoLink::Mavlink), &args.out, (args.speed, seed.wrapping_add(1)), &stop)?;
        if point.name == BY_BOTH {
            message(format_args!("  {}, the same flight by PCM", point.name));
            let by_pcm = fly_run((point, fit, DemoLink::Pcm), &args.out, (args.speed, seed), &stop)?;
            both_links = links_compared(point.name, &flown_fit, &by_pcm);
        }
        flown.push([flown_fit, flown_kept]);
    }
    message(format_args!("Diagnosis of a Level-1 simulation by these flights, a minute or two:"));
    let logs = |of: fn(&[FlownRun; 2]) -> &FlownRun| -> Vec<PathBuf> { flown.iter().map(|both| of(both).log.clone()).collect() };
    let diagnosed = diagnosis_child::diagnosed(&logs(|[fit, _]| fit), &logs(|[_, kept]| kept), &args.out, &stop)?;
    let to_standard_output = args.json.as_ref().is_some_and(|json| json.as_os_str() == "-");
    let style = if to_standard_output { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let fits: Vec<&FlownRun> = flown.iter().map(|[fit, _]| fit).collect();
    let mut closing = ResultTable { flown: &fits, answer: &diagnosed.answer, style }.to_string();
    let paths = [
        ("logs", args.out.join("*/live.mcap")),
        ("numbers", diagnosed.json),
        ("words", diagnosed.said),
        ("pages", args.out.join("report-*.html")),
    ];
    closing.push_str(&both_links);
    closing.push('\n');
    paths.iter().for_each(|(what, path)| closing.push_str(&format!("{what:<8} {}\n", path.display())));
    if to_standard_output {
        message(format_args!("{}", closing.trim_end()));
    } else {
        print(&closing)?;
    }
    if let (Some(copy), Some(last)) = (&args.json, fits.last()) {
        let numbers = std::fs::read_to_string(&last.numbers).map_err(|error| Failure::io(&last.numbers, &error))?;
        write_json(copy, &numbers)?;
    }
    let lost = flown.iter().flatten().any(|one| matches!(one.outcome, Outcome::DataLost));
    Ok(if lost { Outcome::DataLost } else { Outcome::Done })
}
