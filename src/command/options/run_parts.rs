//! `--from`, `--to`, `--manoeuvre`, and `--set` of runs: for all recordings of a call, or for one that is named before a colon.
//!
//! One grammar: `VALUE` is for every recording, `RUN:VALUE` for the one of that path, file name, or file name without its ending;
//! what names a recording counts before what names none, and of two the later.

use super::telemetry_source::RecordingSource;
use sideslip::error::Failure;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::telemetry::alignment::aligned_recording::TimeSpan;
use std::path::Path;

/// Which part of each recording is read.
#[derive(clap::Args)]
pub(crate) struct PartOptions {
    /// Leave out what is earlier, s of the recording's time; RUN:S of that recording alone; repeatable
    #[arg(long, value_name = "[RUN:]S", allow_negative_numbers = true)]
    from: Vec<String>,
    /// Leave out what is later, s of the recording's time; RUN:S of that recording alone; repeatable
    #[arg(long, value_name = "[RUN:]S", allow_negative_numbers = true)]
    to: Vec<String>,
    /// Read a manoeuvre of a flight as a run of its own, by its number in `sideslip inspect RUN --manoeuvres`: 2, several as
    /// 1,3,4, or all; where several recordings are read, RUN:N of that one; repeatable
    #[arg(long, value_name = "[RUN:]N")]
    manoeuvre: Vec<String>,
}

/// Manoeuvres that were asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ManoeuvreChoice {
    All,
    /// By number, from 1.
    Numbers(Vec<usize>),
}

/// What was asked of one recording.
#[derive(Debug)]
pub(crate) struct PartChoice {
    pub(crate) span: TimeSpan,
    pub(crate) manoeuvres: Option<ManoeuvreChoice>,
    pub(crate) set: Vec<String>,
}

impl PartOptions {
    /// Whether any was given.
    pub(crate) fn any(&self) -> bool {
        !(self.from.is_empty() && self.to.is_empty() && self.manoeuvre.is_empty())
    }

    /// The same options for a call of another command.
    pub(crate) fn call(&self) -> Vec<String> {
        let all = [("--from", &self.from), ("--to", &self.to), ("--manoeuvre", &self.manoeuvre)];
        all.into_iter().flat_map(|(option, values)| values.iter().map(move |value| format!("{option}={value}"))).collect()
    }

    /// What is asked of each of the recordings; `set` are keys of runs.
    pub(crate) fn choices(&self, sources: &[&RecordingSource], set: &[String]) -> Result<Vec<PartChoice>, Failure> {
        let from = each("--from", &self.from, sources, seconds)?;
        let to = each("--to", &self.to, sources, seconds)?;
        let manoeuvres = each("--manoeuvre", &self.manoeuvre, sources, numbers)?;
        self.refuse_numbers_of_several(sources)?;
        let set = each("--set", set, sources, key_and_value)?;
        let mut choices = Vec::new();
        for ((((from, to), manoeuvres), set), source) in from.into_iter().zip(to).zip(manoeuvres).zip(set).zip(sources) {
            let span = TimeSpan { from_s: from.last().copied(), to_s: to.last().copied() };
            if let (Some(from_s), Some(to_s)) = (span.from_s, span.to_s)
                && !(from_s < to_s)
            {
                return Err(Failure::file(&source.file, format!("expected --from before --to, found {from_s} and {to_s} s")));
            }
            let manoeuvres = manoeuvres.into_iter().reduce(joined);
            if manoeuvres.is_some() && !span.is_whole() {
                let what = "expected --manoeuvre, which has times of its own, or --from and --to, found both";
                return Err(Failure::file(&source.file, what));
            }
            choices.push(PartChoice { span, manoeuvres, set });
        }
        Ok(choices)
    }

    /// A manoeuvre's number is one of a recording: of several it must be named, or the hold-out would be cut by the number that
    /// was meant for the fit.
    fn refuse_numbers_of_several(&self, sources: &[&RecordingSource]) -> Result<(), Failure> {
        let is_number = |text: &&String| matches!(numbers(text), Some(ManoeuvreChoice::Numbers(_)));
        match (sources, self.manoeuvre.iter().find(is_number)) {
            ([first, _, ..], Some(text)) => {
                let (count, stem) = (sources.len(), first.file.file_stem().unwrap_or_default().to_string_lossy());
                Err(Failure::Input(format!(
                    "--manoeuvre: expected the recording before the number, such as {stem}:{text}, for {count} recordings are \
                     read; found `{text}`"
                )))
            }
            _ => Ok(()),
        }
    }
}

/// Whether an assignment of `--set` is one of a run's keys, of one run or all, and not one of a model.
pub(crate) fn is_of_run(assignment: &str) -> bool {
    let key = assignment.split('=').next().unwrap_or_default();
    key.contains(':') || RunInfo::is_known(key.trim())
}

fn joined(one: ManoeuvreChoice, other: ManoeuvreChoice) -> ManoeuvreChoice {
    match (one, other) {
        (ManoeuvreChoice::Numbers(one), ManoeuvreChoice::Numbers(other)) => ManoeuvreChoice::Numbers([one, other].concat()),
        _ => ManoeuvreChoice::All,
    }
}

fn seconds(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|seconds: &f64| seconds.is_finite())
}

fn numbers(text: &str) -> Option<ManoeuvreChoice> {
    if text == "all" {
        return Some(ManoeuvreChoice::All);
    }
    let numbers = text.split(',').map(|number| number.trim().parse().ok().filter(|number| *number > 0));
    numbers.collect::<Option<_>>().map(ManoeuvreChoice::Numbers)
}

/// `key=value`, whose key has no colon.
fn key_and_value(text: &str) -> Option<String> {
    (!text.split('=').next().unwrap_or_default().contains(':')).then(|| text.to_owned())
}

/// By recording, what is for all of them, then what is for it.
fn each<T: Clone>(
    option: &str,
    given: &[String],
    sources: &[&RecordingSource],
    read: impl Fn(&str) -> Option<T>,
) -> Result<Vec<Vec<T>>, Failure> {
    let (mut for_all, mut own) = (Vec::new(), vec![Vec::new(); sources.len()]);
    for text in given {
        // A name may hold colons and equals signs itself.
        let named = sources.iter().flat_map(|source| names(source)).find_map(|name| {
            let rest = text.strip_prefix(&name)?.strip_prefix(':')?;
            Some((name, read(rest)?))
        });
        let Some((name, value)) = named else {
            for_all.push(read(text).ok_or_else(|| unreadable(option, text, sources))?);
            continue;
        };
        let is_path = |source: &&RecordingSource| source.file.as_path() == Path::new(&name);
        let any_path = sources.iter().any(is_path);
        let meant = |source: &&RecordingSource| if any_path { is_path(source) } else { names(source).contains(&name) };
        let mut files: Vec<&Path> = sources.iter().filter(|source| meant(source)).map(|source| source.file.as_path()).collect();
        files.dedup();
        if let [one, other, ..] = files.as_slice() {
            let what = format!(
                "expected the path of one recording before the colon; `{name}` is {} and {}",
                one.display(),
                other.display()
            );
            return Err(Failure::Input(format!("{option}: {what}")));
        }
        own.iter_mut().zip(sources).filter(|(_, source)| meant(source)).for_each(|(own, _)| own.push(value.clone()));
    }
    Ok(own.into_iter().map(|own| [for_all.clone(), own].concat()).collect())
}

/// What a recording may be called: its path, its file's name, and that without the ending.
fn names(source: &RecordingSource) -> Vec<String> {
    let file = source.file.as_path();
    let parts = [Some(file.as_os_str()), file.file_name(), file.file_stem()];
    let mut names: Vec<String> = parts.into_iter().flatten().map(|name| name.to_string_lossy().into_owned()).collect();
    names.dedup();
    names
}

fn unreadable(option: &str, text: &str, sources: &[&RecordingSource]) -> Failure {
    let expected = match option {
        "--manoeuvre" => "a number from 1, several as 1,3, or all",
        "--set" => "KEY=VALUE",
        _ => "seconds",
    };
    let read: Vec<String> = sources.iter().map(|source| source.file.display().to_string()).collect();
    Failure::Input(format!(
        "{option}: expected {expected}, or a recording that is read ({}) and a colon before it; found `{text}`",
        read.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::options::telemetry_source::RecordingKind;

    fn options(from: &[&str], to: &[&str], manoeuvre: &[&str]) -> PartOptions {
        let owned = |all: &[&str]| all.iter().map(|&one| one.to_owned()).collect();
        PartOptions { from: owned(from), to: owned(to), manoeuvre: owned(manoeuvre) }
    }

    #[test]
    fn what_names_a_recording_is_for_it_alone_and_counts_before_what_names_none() {
        let sources =
            ["a/one.csv", "b/two.csv", "b/x=1:2.csv"].map(|file| RecordingSource::whole(file.into(), RecordingKind::ByContent));
        let sources: Vec<&RecordingSource> = sources.iter().collect();
        let set = ["two:blades=4", "blades=3", "b/x=1:2.csv:run=q:r", "run=s:t"].map(str::to_owned);
        let chosen = options(&["two.csv:-3", "1.5"], &["b/two.csv:4"], &["one:1,3", "one:2"]);
        let refused = chosen.choices(&sources, &set).unwrap_err().to_string();
        assert!(refused.contains("a/one.csv") && refused.contains("found both"), "{refused}");
        let all = options(&["two.csv:-3"], &["b/two.csv:4"], &["one:1,3", "one:2"]).choices(&sources, &set).unwrap();
        assert_eq!(all[0].manoeuvres, Some(ManoeuvreChoice::Numbers(vec![1, 3, 2])));
        assert_eq!(all[1].span, TimeSpan { from_s: Some(-3.0), to_s: Some(4.0) });
        assert_eq!(all[1].set, ["blades=3", "run=s:t", "blades=4"]);
        assert_eq!(
            (all[2].set.as_slice(), all[2].span.is_whole()),
            (&["blades=3", "run=s:t", "run=q:r"].map(str::to_owned)[..], true)
        );
    }

    #[test]
    fn a_name_that_no_recording_or_two_have_is_refused() {
        let sources = ["a/one.csv", "b/one.csv"].map(|file| RecordingSource::whole(file.into(), RecordingKind::ByContent));
        let sources: Vec<&RecordingSource> = sources.iter().collect();
        let refused = |options: PartOptions, set: &[String]| options.choices(&sources, set).unwrap_err().to_string();
        assert!(refused(options(&["one:1"], &[], &[]), &[]).contains("`one` is a/one.csv and b/one.csv"));
        assert!(refused(options(&["three:1"], &[], &[]), &[]).contains("a recording that is read (a/one.csv, b/one.csv)"));
        assert!(refused(options(&[], &[], &["0"]), &[]).contains("a number from 1"));
        assert!(refused(options(&[], &[], &[]), &["three:blades=4".to_owned()]).contains("found `three:blades=4`"));
        let several = refused(options(&[], &[], &["2"]), &[]);
        assert!(several.contains("such as one:2, for 2 recordings are read"), "{several}");
        options(&[], &[], &["all"]).choices(&sources, &[]).unwrap();
        options(&[], &[], &["2"]).choices(&sources[..1], &[]).unwrap();
        assert!(refused(options(&["5"], &["4"], &[]), &[]).contains("found 5 and 4 s"));
    }
}
