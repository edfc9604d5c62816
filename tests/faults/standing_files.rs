//! Files that stand where a command writes: refused before any work, unless `--force` is given, which leaves no trace in a
//! result.

use crate::support::program::{ended, folder, own, path, puma, sideslip};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Options and files of a call that writes.
struct WritingCall {
    args: Vec<String>,
    outputs: Vec<PathBuf>,
}

fn call(args: &[&str], outputs: &[&Path]) -> WritingCall {
    WritingCall {
        args: args.iter().map(|&arg| arg.to_owned()).collect(),
        outputs: outputs.iter().map(|&file| file.to_owned()).collect(),
    }
}

fn run(call: &WritingCall, more: &[&str]) -> (i32, String) {
    let args: Vec<&str> = call.args.iter().map(String::as_str).chain(more.iter().copied()).collect();
    let (status, _, said) = ended(&sideslip(&args));
    (status, said)
}

fn is_done(status: i32) -> bool {
    matches!(status, 0 | 3 | 4)
}

/// Runs it over what it wrote itself, a user's file and an empty one: refused, nothing changed; then with the option.
fn stands_the_test(call: &WritingCall) {
    let args = &call.args;
    let (status, said) = run(call, &[]);
    assert!(is_done(status), "{args:?}: {status} {said}");
    let written: Vec<Vec<u8>> = call.outputs.iter().map(|file| std::fs::read(file).unwrap()).collect();
    for (place, (file, bytes)) in call.outputs.iter().zip(&written).enumerate() {
        // The others are away, so that it is this one that is refused.
        let others = || call.outputs.iter().enumerate().filter(move |(other, _)| *other != place).map(|(_, file)| file);
        others().for_each(|file| drop(std::fs::remove_file(file)));
        for standing in [bytes.as_slice(), b"mine: notes of a day\n", b""] {
            std::fs::write(file, standing).unwrap();
            let (status, said) = run(call, &[]);
            assert!(
                status == 2 && said.contains(path(file)) && said.contains("--force replaces it"),
                "{args:?}: {status} {said}"
            );
            assert_eq!(std::fs::read(file).unwrap(), standing, "{args:?}");
            assert!(others().all(|other| !other.exists()), "{args:?}");
        }
        let (status, said) = run(call, &["--force"]);
        assert!(is_done(status), "with --force: {args:?}: {status} {said}");
        // Records of several threads stand in the log of a replay in the order in which they came.
        let is_same = std::fs::read(file).unwrap() == *bytes || file.ends_with("log.mcap");
        assert!(is_same, "with --force the bytes of {} are others: {args:?}", file.display());
    }
}

#[test]
fn results_on_models_replace_nothing_without_force() {
    let (folder, model) = (folder("standing-models"), own("replay/models/puma-like.toml"));
    let file = |name: &str| folder.join(name);
    let (json, svg) = (file("result.json"), file("result.svg"));
    stands_the_test(&call(&["linearise", "--model", path(&model), "--json", path(&json)], &[&json]));
    let design = ["design", "--model", path(&model), "--control", "pedal", "--longest", "2"];
    let (design_json, outputs) = (file("design.json"), ["--json", "--svg"]);
    let design = [&design[..], &[outputs[0], path(&design_json), outputs[1], path(&svg)]].concat();
    stands_the_test(&call(&design, &[&design_json, &svg]));
    for name in ["run.csv", "run.mcap", "run.tlog", "run.bin", "run.ulg", "run.pcm"] {
        let out = file(name);
        // The format of the frames stands beside the stream.
        let outputs = if name == "run.pcm" { vec![out.clone(), file("run.pcm.toml")] } else { vec![out.clone()] };
        let outputs: Vec<&Path> = outputs.iter().map(PathBuf::as_path).collect();
        let simulate = ["simulate", "--model", path(&model), "--input", "pedal:doublet:0.01:1", "--duration", "6", "--out"];
        stands_the_test(&call(&[&simulate[..], &[path(&out)]].concat(), &outputs));
    }
    let pages = file("pages");
    let manual = call(&["man", "--out", path(&pages)], &[]);
    assert_eq!(run(&manual, &[]).0, 0);
    let (status, said) = run(&manual, &[]);
    assert!(status == 2 && said.contains("--force replaces it"), "{status} {said}");
    assert_eq!(run(&manual, &["--force"]).0, 0);
}

#[test]
fn results_on_recordings_replace_nothing_without_force() {
    let (folder, model, puma) = (folder("standing-recordings"), own("replay/models/puma-like.toml"), puma());
    let (file, run, model) = (|name: &str| folder.join(name), path(&puma), path(&model));
    let json = file("result.json");
    for args in [["check", run].as_slice(), &["inspect", run], &["inspect", run, "--manoeuvres"], &["replay", run]] {
        let one = json.with_file_name(format!("{}.json", args.join("-").replace(['/', '.'], "_")));
        stands_the_test(&call(&[args, &["--json", path(&one)]].concat(), &[&one]));
    }
    let files = ["log.mcap", "states.csv", "history.csv"].map(file);
    let replay = ["replay", run, "--out", path(&files[0]), "--smoothed", path(&files[1]), "--derivatives", path(&files[2])];
    stands_the_test(&call(&replay, &[&files[0], &files[1], &files[2]]));
    let pictures = file("pictures");
    let svg = file("all.svg");
    let compare = ["compare", run, "--model", model, "--svg", path(&svg), "--out", path(&pictures)];
    stands_the_test(&call(&compare, &[&svg, &pictures.join("compare.json"), &pictures.join("puma-100kn-pedal-3211.svg")]));
    let result = file("result");
    let identify = ["identify", run, "--states", "v,p,phi,r", "--inputs", "lat_cyclic,pedal", "--out", path(&result)];
    let outputs = ["report.html", "derivatives.json", "model.toml"].map(|name| result.join(name));
    stands_the_test(&call(&identify, &[&outputs[0], &outputs[1], &outputs[2]]));
}

#[test]
fn a_diagnosis_refuses_before_it_searches() {
    let (folder, model, puma) = (folder("standing-diagnosis"), own("replay/models/puma-like.toml"), puma());
    for (option, name) in [("--json", "d.json"), ("--html", "d.html"), ("--extended", "d.toml")] {
        let out = folder.join(name);
        std::fs::write(&out, "mine\n").unwrap();
        let begun = std::time::Instant::now();
        let (status, _, said) =
            ended(&sideslip(&["diagnose", "--model", path(&model), "--fit", path(&puma), option, path(&out)]));
        assert!(status == 2 && said.contains(path(&out)) && said.contains("--force"), "{option}: {status} {said}");
        assert!(begun.elapsed().as_secs() < 2, "{option}");
    }
}

#[test]
fn a_demo_refuses_before_it_flies() {
    for name in ["diagnosis.json", "report-2.html", "puma-extended-3.toml", "level-fit/derivatives.json", "diagnosis.txt"] {
        let folder = folder("standing-demo");
        let file = folder.join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "mine\n").unwrap();
        let (status, _, said) = ended(&sideslip(&["demo", "--out", path(&folder)]));
        assert!(status == 2 && said.contains(path(&file)) && said.contains("--force"), "{name}: {status} {said}");
    }
}

/// A shell that directs standard output to a file has made that file for the program.
#[test]
fn a_stream_that_a_shell_directs_to_a_file_is_written() {
    let folder = folder("standing-stream");
    let model = own("replay/models/puma-like.toml");
    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        let file = folder.join("to.json");
        let to = std::fs::File::create(&file).unwrap();
        let mut call = Command::new(env!("CARGO_BIN_EXE_sideslip"));
        let done = call.args(["linearise", "--model", path(&model), "--json", name]).stdout(to).status().unwrap();
        assert!(done.success() && std::fs::read_to_string(&file).unwrap().starts_with('{'), "{name}");
    }
}

#[test]
fn every_command_that_writes_files_has_the_option() {
    let (_, help, _) = ended(&sideslip(&["--help"]));
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let mut writing = Vec::new();
    for name in listed.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
        let (_, help, _) = ended(&sideslip(&[name, "--help"]));
        let writes = help.contains("--json <FILE>") || help.contains("--out <") || help.contains("<OUT>");
        assert_eq!(writes, help.contains("--force"), "{name}");
        writing.extend(writes.then(|| name.to_owned()));
    }
    assert!(writing.len() >= 14, "{writing:?}");
}
