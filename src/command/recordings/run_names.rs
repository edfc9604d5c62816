//! Names of runs that are told apart.

use crate::command::options::telemetry_source::RecordingSource;

/// Adds the file to the names that several runs have: without its ending and folder where that tells them apart, else whole.
pub(crate) fn tell_apart<'n>(names: impl IntoIterator<Item = &'n mut String>, sources: &[&RecordingSource]) {
    let mut named: Vec<(&mut String, &RecordingSource)> = names.into_iter().zip(sources.iter().copied()).collect();
    let all: Vec<(String, String)> = named.iter().map(|(name, source)| ((*name).clone(), source.stem())).collect();
    for (name, source) in &mut named {
        let stems: Vec<&String> = all.iter().filter(|(other, _)| other == *name).map(|(_, stem)| stem).collect();
        if stems.len() < 2 {
            continue;
        }
        let own = source.stem();
        let file = if stems.iter().filter(|stem| ***stem == own).count() < 2 { own } else { source.file.display().to_string() };
        **name = format!("{name} ({file})");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::options::telemetry_source::RecordingKind;

    #[test]
    fn runs_of_one_name_have_that_of_their_file_too() {
        let sources = ["a/one.csv", "a/two.csv", "b/two.csv", "b/three.csv"]
            .map(|file| RecordingSource::whole(file.into(), RecordingKind::ByContent));
        let mut names = ["10", "10", "10", "11"].map(str::to_owned);
        tell_apart(&mut names, &sources.iter().collect::<Vec<_>>());
        assert_eq!(names, ["10 (one)", "10 (a/two.csv)", "10 (b/two.csv)", "11"]);
    }
}
