//! Wrong calls, recordings and models: one line that says what was expected, exit status 2, nothing written.

use crate::support::program::{RunFile, ended, folder, own, path, puma, sideslip};

fn refused(args: &[&str], words: &[&str]) {
    let (status, out, said) = ended(&sideslip(args));
    assert!(status == 2 && out.is_empty() && said.trim_end().lines().count() == 1, "{args:?}: {status} {out} {said}");
    for word in words {
        assert!(said.contains(word), "{args:?}: `{word}` in {said}");
    }
}

#[test]
fn what_cannot_be_compared_is_refused_with_a_line() {
    let (run, folder) = (puma(), folder("compare-calls"));
    let (run_file, model) = (path(&run), own("replay/models/puma-like.toml"));
    let model_file = path(&model);
    let with = |file: &str| ["compare", run_file, "--model", file].map(str::to_owned);
    let text = std::fs::read_to_string(&model).unwrap();
    let misspelt = folder.join("misspelt.toml");
    std::fs::write(&misspelt, text.replace("[derivatives.N]\nu = ", "[derivatives.N]\nuu = ")).unwrap();
    let call = with(path(&misspelt));
    refused(&call.each_ref().map(String::as_str), &["misspelt.toml:", "`uu`"]);
    refused(&["compare", run_file, "--model", "no-such.toml"], &["no-such.toml"]);
    refused(&["compare", "no-such.csv", "--model", model_file], &["no-such.csv"]);
    refused(&["compare", run_file, run_file, "--model", model_file], &["same file twice"]);
    refused(&["compare", run_file, "--model", model_file, "--trim-window", "0"], &["--trim-window"]);
    refused(&["compare", run_file, "--model", model_file, "--still", "pedals"], &["--still", "`pedals`"]);
    refused(&["compare", run_file, "--model", model_file, "--svg", run_file], &["--svg"]);
    refused(&["compare", run_file, "--model", model_file, "--json", "no-such/a.json"], &["--json", "no-such"]);
    let short = folder.join("short.csv");
    let mut cut = RunFile::read(&run);
    cut.rows.truncate(20);
    cut.write(&short);
    refused(&["compare", path(&short), "--model", model_file], &["short.csv", "20 rows"]);
    let without = folder.join("without.csv");
    RunFile::read(&run).without("pedal").write(&without);
    refused(&["compare", path(&without), "--model", model_file], &["without.csv", "`pedal`"]);
    let back = folder.join("back.csv");
    let mut backwards = RunFile::read(&run);
    backwards.rows[40][0] = backwards.rows[10][0].clone();
    backwards.write(&back);
    refused(&["compare", path(&back), "--model", model_file], &["back.csv", "row 41"]);
    let other = folder.join("other.csv");
    let mut other_aircraft = RunFile::read(&run);
    other_aircraft
        .preamble
        .iter_mut()
        .filter(|line| line.contains("aircraft"))
        .for_each(|line| *line = "# aircraft = \"Lynx\"".to_owned());
    other_aircraft.write(&other);
    refused(&["compare", run_file, path(&other), "--model", model_file], &["other.csv", "one aircraft", "`Lynx`"]);
}

/// A row that is cut short is data lost, and what is left is compared.
#[test]
fn a_damaged_row_is_data_lost() {
    let folder = folder("compare-damaged");
    let damaged = folder.join("damaged.csv");
    let text = std::fs::read_to_string(puma()).unwrap();
    std::fs::write(&damaged, &text[..text.len() - 40]).unwrap();
    let model = own("replay/models/puma-like.toml");
    let (status, out, said) = ended(&sideslip(&["compare", path(&damaged), "--model", path(&model)]));
    assert!(status == 3 && out.contains("pooled") && said.contains("1 of"), "{status} {out} {said}");
}
