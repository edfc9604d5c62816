//! The page of a diagnosis: the answer and its evidence stand in it, nothing comes from elsewhere, and names are text.

use crate::support::program::{RunFile, ended, folder, own, path, sideslip};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A name that a page may not take for its own language.
const NAME: &str = "<script src=x>&\"3211";
/// The same as text.
const SAFE: &str = "&lt;script src=x&gt;&amp;&quot;3211";

fn flown(folder: &Path, name: &str, model: &Path, input: &str, seed: &str) -> PathBuf {
    let file = folder.join(name);
    let args = ["simulate", "--model", path(model), "--input", input, "--out", path(&file), "--duration", "12", "--seed", seed];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &["--noise", "--rate", "64", "--pilot", "attitude"]].concat()));
    assert_eq!(status, 0, "{said}");
    let mut run = RunFile::read(&file);
    run.preamble.retain(|line| !line.starts_with("# run"));
    run.preamble.push(format!("# run = '{NAME} {name}'"));
    run.write(&file);
    file
}

/// Diagnoses two flights of an aircraft, one of them a hold-out run, and gives the page and the answer.
fn diagnosed(folder: &Path, aircraft: &Path) -> (String, Value) {
    let model = own("replay/models/puma-like.toml");
    let fit = flown(folder, "fit.csv", aircraft, "pedal:3211:0.02:0.7", "1");
    let holdout = flown(folder, "holdout.csv", aircraft, "pedal:doublet:0.02:0.8", "2");
    let (html, json) = (folder.join("page.html"), folder.join("answer.json"));
    let args = ["diagnose", "--model", path(&model), "--fit", path(&fit), "--holdout", path(&holdout), "--html", path(&html)];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &["--json", path(&json)]].concat()));
    assert_eq!(status, 0, "{said}");
    let page = std::fs::read_to_string(&html).unwrap();
    // Nothing from elsewhere, and nothing that runs.
    for word in ["http", "<script", "url(", "@import", "javascript:", "NaN", "<img", "<link"] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains(&format!("{SAFE} fit.csv")) && page.contains(&format!("{SAFE} holdout.csv")));
    for tag in ["svg", "figure", "section", "table", "ul", "ol", "li", "div", "figcaption", "body", "html"] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    (page, serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap())
}

fn titles(page: &str, title: &str) -> usize {
    page.matches(&format!("<figcaption><b>{title}")).count()
}

#[test]
fn a_cause_is_said_and_shown() {
    let folder = folder("diagnose-page");
    let lagging = folder.join("lagging.toml");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    std::fs::write(&lagging, format!("{text}\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.2\n")).unwrap();
    let (page, answer) = diagnosed(&folder, &lagging);
    let sentence = answer["verdict"]["statement"].as_str().unwrap().replace("+-", "\u{b1}");
    assert!(sentence.contains("lag"), "{sentence}");
    let head = page.find("class=\"answer\"").unwrap();
    assert!(page[head..].find(&sentence).is_some_and(|at| at < 300), "{sentence}");
    for (title, count) in [
        ("Without the cause", 1),
        ("With the cause", 1),
        ("r</b>", 2),
        ("controls that moved", 2),
        ("Spectrum of the residual ", 6),
        ("Coherence of the residual ", 2),
        ("Roots", 1),
    ] {
        assert_eq!(titles(&page, title), count, "{title}");
    }
    for words in ["measured", "model as given", "model extended", "instrument noise", "class=\"bar\"", "[[effect]]"] {
        assert_eq!(page.contains(words), words != "[[effect]]", "{words}");
    }
    for table in ["ranking", "residuals", "gain", "roots", "limits"] {
        assert!(page.contains(&format!("class=\"{table}\"")), "{table}");
    }
    // The lag is seen on the axis that the pedal turns: with the pedal, and no more when it is in the model.
    let yaw = &answer["discrepancy"]["N"];
    assert!(yaw["explained"].as_f64().unwrap() > 0.8, "{yaw:#}");
    assert!(yaw["coherence"]["before"]["coherence"].as_f64().unwrap() > yaw["coherence"]["level"].as_f64().unwrap(), "{yaw:#}");
    assert!(yaw["coherence"]["after"].is_null(), "{yaw:#}");
    let lines = yaw["spectrum"]["lines"].as_array().unwrap();
    assert!((1..=3).contains(&lines.len()) && yaw["spectrum"]["unit"] == "(rad/s^2)^2/Hz", "{yaw:#}");
    assert!(lines[0]["before"].as_f64().unwrap() > 4.0 * lines[0]["after"].as_f64().unwrap(), "{yaw:#}");
}

#[test]
fn that_nothing_is_wrong_is_a_page_too() {
    let (page, answer) = diagnosed(&folder("diagnose-page-none"), &own("replay/models/puma-like.toml"));
    assert_eq!(answer["verdict"]["kind"], "none");
    assert!(page.contains("The model explains these runs within their noise and its own tolerance"));
    assert!(page.contains("Closest hypotheses") && !page.contains("model extended"));
    for (title, count) in
        [("controls that moved", 2), ("Spectrum of the residual ", 6), ("Coherence of the residual ", 2), ("Roots", 1)]
    {
        assert_eq!(titles(&page, title), count, "{title}");
    }
    for axis in ["X", "Y", "Z", "L", "M", "N"] {
        assert!(answer["discrepancy"][axis]["coherence"]["after"].is_null(), "{axis}: {answer:#}");
    }
}
