//! The call of `sideslip diagnose`.

use crate::command::options::fitted_runs::FittedRuns;
use crate::command::options::flight_condition::FlightCondition;
use crate::command::options::mapping_input::{CONFIG_HELP, MapOption};
use crate::command::options::replace_option::ReplaceOption;
use crate::command::options::run_parts::PartOptions;
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip diagnose --model puma-100kn.toml --fit 3211.csv lateral.csv doublet.csv --holdout other.csv --extended better.toml
  sideslip diagnose --model puma --speed 51.4 --density 1.024 --fit monday/*.csv --json -

Every effect that a model file can have is a hypothesis, for every axis, control and channel: derivatives, nonlinear terms, the
path of each control to its blade, rotor speed, gusts, the instruments. A score test over all runs ranks them, with every
derivative free within the model's own tolerance; the best are fitted with their numbers free, and after each cause that is
accepted the search continues until the remaining residual is noise. Causes that the data do not distinguish are reported
together. Where no hypothesis explains the residual, the answer is unknown, with the axis and the band. The improvement is that of
predictions 2 s ahead on hold-out runs; without improvement no model is extended, and a cause that these runs refute is rejected.
Where runs do not begin in the trim of the model, the difference is reported and is no cause. A gap of the rates parts a run: what
lies between gaps is diagnosed as runs, each with its own start. A Level-1 model
whose airspeed and climb are left open is trimmed where the runs were flown; runs of several test points are diagnosed at each
test point, and then over the flight path.

Exit status: 0 done, whatever was found; 1 failed while running; 2 the call, a recording or a model is wrong; 3 done, rows were
skipped or a run was set aside. With --json - the table goes to standard error.";

/// Find what a model gets wrong, identify the cause, extend the model, and measure the improvement on hold-out runs
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct DiagnoseArgs {
    #[command(flatten)]
    pub(super) condition: FlightCondition,
    #[command(flatten)]
    pub(super) runs: FittedRuns,
    /// Largest number of causes that is searched for
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(super) causes: usize,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    pub(super) config: Option<PathBuf>,
    #[command(flatten)]
    pub(super) map: MapOption,
    #[command(flatten)]
    pub(super) parts: PartOptions,
    /// Write the answer as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write the extended model to this file, where there is one
    #[arg(long, value_name = "FILE")]
    pub(super) extended: Option<PathBuf>,
    /// Write a report (HTML) to this file: causes and their evidence, every run beside both models, residuals, improvement
    #[arg(long, value_name = "FILE")]
    pub(super) html: Option<PathBuf>,
    #[command(flatten)]
    pub(super) replace: ReplaceOption,
}
