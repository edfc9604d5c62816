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

use super::options::replace_option::ReplaceOption;
use super::terminal::console::print;
use super::terminal::output_file::write_json;
use super::terminal::stop::stopped_by_signals;
use crate::command::{message, message_text};
use diagnosis_child::{DIAGNOSIS, EXTENDED, PAGES, WORDS, diagnosed};
use live_child::SAID;
use pcm_vehicle::FRAMES;
use result_table::ResultTable;
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::tables::terminal::Style;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use test_flight::{RATE_HZ, RUNS, TEST_POINTS};
use test_run::{BY_PCM, DemoLink, FlownRun, NUMBERS, fly_run};

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
    /// Directory for logs, numbers and pages (made where it is missing); without it, sideslip-demo in the current directory, and
    /// where that is there already sideslip-demo-2 and so on
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How many times faster than real time it flies
    #[arg(long, value_name = "N", default_value = "4", value_parser = speed)]
    speed: f64,
    /// Seed of the instruments' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the last estimates, those of the climb, as JSON to this file too, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Where results go unless a directory is named.
const FOLDER: &str = "sideslip-demo";

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

/// The directory of the results: the one that is named, which may hold none of the files that are written there (logs take free
/// names); else a fresh one.
fn folder(args: &DemoArgs) -> Result<PathBuf, Failure> {
    let named = args.out.clone().or_else(|| args.replace.force.then(|| FOLDER.into()));
    if let Some(folder) = named {
        refuse_standing(&folder, args.replace)?;
        return std::fs::create_dir_all(&folder).map_err(|error| Failure::io(&folder, &error)).map(|()| folder);
    }
    let mut number = 1_u64;
    loop {
        let folder = PathBuf::from(if number == 1 { FOLDER.to_owned() } else { format!("{FOLDER}-{number}") });
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(Failure::io(&folder, &error)),
        }
    }
}

/// Refuses, before anything is flown, to write over files in the directory of the results.
fn refuse_standing(folder: &Path, replace: ReplaceOption) -> Result<(), Failure> {
    let of_point = |point: &test_flight::DemoTestPoint| {
        let both = RUNS.iter().map(|run| format!("{}-{}", point.name, run.name));
        both.flat_map(|run| [run.clone(), format!("{run}{BY_PCM}")]).collect::<Vec<_>>()
    };
    let of_run = |run: String| [NUMBERS, SAID, FRAMES].map(|name| format!("{run}/{name}"));
    let of_runs = TEST_POINTS.iter().flat_map(of_point).flat_map(of_run);
    let of_diagnosis = [DIAGNOSIS, WORDS, PAGES, EXTENDED].map(str::to_owned);
    let numbered =
        (1..=TEST_POINTS.len()).flat_map(|number| [PAGES, EXTENDED].map(|name| name.replacen('.', &format!("-{number}."), 1)));
    replace.refuse_in("--out", folder, of_runs.chain(of_diagnosis).chain(numbered))
}

/// Flies, estimates, diagnoses, compares.
pub(crate) fn run(args: &DemoArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    let out = &folder(args)?;
    let pilot = RUNS.each_ref().map(|run| format!("{} ({})", run.inputs(), run.name));
    message_text(&format!(
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
        let flown_fit = fly_run((point, fit, DemoLink::Mavlink), out, (args.speed, seed), &stop)?;
        let flown_kept = fly_run((point, kept, DemoLink::Mavlink), out, (args.speed, seed.wrapping_add(1)), &stop)?;
        if point.name == BY_BOTH {
            message(format_args!("  {}, the same flight by PCM", point.name));
            let by_pcm = fly_run((point, fit, DemoLink::Pcm), out, (args.speed, seed), &stop)?;
            both_links = links_compared(point.name, &flown_fit, &by_pcm);
        }
        flown.push([flown_fit, flown_kept]);
    }
    message(format_args!("Diagnosis of a Level-1 simulation by these flights, a minute or two:"));
    let logs = |of: fn(&[FlownRun; 2]) -> &FlownRun| -> Vec<PathBuf> { flown.iter().map(|both| of(both).log.clone()).collect() };
    let diagnosis = diagnosed(&logs(|[fit, _]| fit), &logs(|[_, kept]| kept), out, &stop)?;
    let to_standard_output = args.json.as_ref().is_some_and(|json| json.as_os_str() == "-");
    let style = if to_standard_output { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let fits: Vec<&FlownRun> = flown.iter().map(|[fit, _]| fit).collect();
    let mut closing = ResultTable { flown: &fits, answer: &diagnosis.answer, style }.to_string();
    let paths = [
        ("logs", out.join("*/live.mcap")),
        ("numbers", diagnosis.json),
        ("words", diagnosis.said),
        ("pages", out.join("report-*.html")),
    ];
    closing.push_str(&both_links);
    closing.push('\n');
    paths.iter().for_each(|(what, path)| closing.push_str(&format!("{what:<8} {}\n", path.display())));
    if to_standard_output {
        message_text(closing.trim_end());
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
