//! Cases as files: a model file and run files as a user has them, and what was hidden beside them.

use super::case::{Case, FAMILIES, Recorded, Sort, case};
use crate::support::asked::number;
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::flight::file::run_file::RunFileWriter;
use std::fmt::Write;
use std::fs::{File, create_dir_all, write};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

fn write_recorded(recorded: &Recorded, folder: &Path) {
    let present = recorded.samples.iter().fold(0, |present, sample| present | sample.present);
    let channels: Vec<Channel> = Channel::ALL.into_iter().filter(|channel| present & (1 << channel.index()) != 0).collect();
    let file = File::create(folder.join(format!("{}.csv", recorded.name))).unwrap();
    let mut writer = RunFileWriter::new(BufWriter::new(file), &recorded.info, &channels).unwrap();
    for sample in &recorded.samples {
        writer.write_row(sample.time_s, |channel| sample.get(channel)).unwrap();
    }
    writer.finish().unwrap();
}

/// What was hidden, as a document.
fn truth(case: &Case) -> String {
    let mut text = format!("seed = {}\noff = {}\nshare = {:?}\n", case.seed, case.off, case.share);
    if let Some(said) = &case.outside_library {
        let _ = writeln!(text, "outside_library = {}", toml::Value::String(said.clone()));
    }
    for &effect in &case.hidden {
        let _ = write!(text, "\n{}", DeclaredEffect { effect, std: None }.to_toml(ControlNames::Rotorcraft));
    }
    text
}

/// Writes `model.toml`, `fit-1.csv` to `holdout-2.csv` and `truth.toml` into that folder, which is made.
pub(crate) fn write_case(case: &Case, folder: &Path) {
    create_dir_all(folder).unwrap();
    write(folder.join("model.toml"), &case.model_text).unwrap();
    case.fit.iter().chain(&case.holdout).for_each(|recorded| write_recorded(recorded, folder));
    write(folder.join("truth.toml"), truth(case)).unwrap();
}

/// What a word stands for: `single healthy double outside`, or a family of single causes.
fn sort_of(word: &str, seed: u64) -> Sort {
    match word {
        "single" => Sort::Single(FAMILIES[(seed % 6) as usize]),
        "healthy" => Sort::Healthy,
        "double" => Sort::Double,
        "outside" => Sort::Outside,
        family => Sort::Single(*FAMILIES.iter().find(|one| format!("{one:?}").to_lowercase() == family).unwrap_or_else(|| {
            panic!("SIDESLIP_CASES_SORT: expected single, healthy, double, outside or a family, found {family}")
        })),
    }
}

/// Cases for the program itself, numbered from zero in the folder that `SIDESLIP_CASES_OUT` names: `SIDESLIP_CASES` of them
/// (20), of the sort `SIDESLIP_CASES_SORT` (`single`), seeds from `SIDESLIP_CASES_FROM` (0) on.
#[test]
fn cases_are_written_where_asked() {
    let Some(out) = std::env::var_os("SIDESLIP_CASES_OUT").map(PathBuf::from) else { return };
    let (count, from) = (number("SIDESLIP_CASES").unwrap_or(20), number("SIDESLIP_CASES_FROM").unwrap_or(0));
    let sort = std::env::var("SIDESLIP_CASES_SORT").unwrap_or_else(|_| "single".to_owned());
    over_seeds(count, |place| {
        let case = case(sort_of(&sort, from + place), from + place);
        write_case(&case, &out.join(format!("{place:03}")));
    });
    eprintln!("{count} cases ({sort}) in {}", out.display());
}
