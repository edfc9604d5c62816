//! What stands beside the commands: examples of `--help`, completions, manual pages.

use crate::support::help_examples::{examples, run_examples};
use crate::support::program::{ended, folder, path, sideslip};

#[test]
fn examples_of_help_run_as_they_are_pasted() {
    run_examples("examples", |name| name != "diagnose");
}

#[test]
fn completions_know_commands_and_options_and_every_command_has_its_manual_page() {
    let pages = folder("manual");
    for (shell, word) in [("bash", "_sideslip()"), ("zsh", "#compdef sideslip"), ("fish", "complete -c sideslip")] {
        let (status, script, said) = ended(&sideslip(&["completions", shell]));
        assert_eq!(status, 0, "{said}");
        assert!(
            script.contains(word) && ["diagnose", "holdout", "manoeuvres"].iter().all(|word: &&str| script.contains(word)),
            "{shell}: {script}"
        );
    }
    let (status, _, said) = ended(&sideslip(&["completions", "tcl"]));
    assert!(status == 2 && said.contains("bash"), "{said}");
    let (status, _, said) = ended(&sideslip(&["man", "--out", path(&pages)]));
    assert_eq!(status, 0, "{said}");
    let of_program = std::fs::read_to_string(pages.join("sideslip.1")).unwrap();
    for (name, lines) in examples() {
        let page = std::fs::read_to_string(pages.join(format!("sideslip-{name}.1"))).unwrap();
        assert!(page.contains(".TH sideslip-") && page.contains(".SH SYNOPSIS"), "{page}");
        assert!(of_program.contains(&name) && page.contains(lines[0].split_whitespace().nth(1).unwrap()), "{name}");
    }
    let (status, page, said) = ended(&sideslip(&["man", "check"]));
    assert!(status == 0 && page.contains("vane_position_m"), "{said}");
    let (status, _, said) = ended(&sideslip(&["man", "chekc"]));
    assert!(status == 2 && said.contains("found `chekc`"), "{said}");
}
