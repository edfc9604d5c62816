//! The answer in words at the head of the page, and at its foot the limits of the data.

use crate::command::diagnose::answer::{Answer, Flights};
use crate::command::diagnose::rejection::{explained, holdout_word, rejection, share_of_error};
use sideslip::io::outputs::html::page::{escaped, words};
use sideslip::io::outputs::words::cause_sentence::{manoeuvre, statement, unknown};
use sideslip::io::outputs::words::set_aside::reason;
use sideslip::io::outputs::words::trim_difference::trim_differences;
use sideslip::postflight::diagnosis::diagnose::Finding;
use sideslip::postflight::diagnosis::holdout::horizon_prediction::HORIZON_S;
use sideslip::postflight::diagnosis::record::RankedCause;
use sideslip::postflight::validation::improvement::ImprovementVerdict;
use std::fmt::Write;

/// One sentence a cause, with what else it may be, and its improvement on hold-out runs.
pub(super) fn section(page: &mut String, answer: &Answer) {
    let diagnosis = &answer.diagnosis;
    page.push_str("<section class=\"answer\">\n");
    if let Some(one) = &diagnosis.unknown {
        let _ = writeln!(page, "<p class=\"cause\">Unknown: {}.</p>", words(&unknown(one)));
        if !diagnosis.findings.is_empty() {
            page.push_str("<p>Closest hypotheses, which do not explain it:</p>\n");
        }
    } else if diagnosis.findings.is_empty() {
        let (probability, _) = &diagnosis.none;
        let tolerance = 100.0 * answer.model.file.tolerance;
        let _ =
            writeln!(page, "<p class=\"cause\">{} ({tolerance:.1} %): probability {probability:.2}.</p>", explained(diagnosis));
    }
    if !diagnosis.findings.is_empty() {
        page.push_str("<ol>\n");
        diagnosis.findings.iter().for_each(|finding| cause(page, answer, finding));
        page.push_str("</ol>\n");
    }
    if !diagnosis.rejected.is_empty() {
        page.push_str("<p>These fit, and are not relied upon:</p>\n<ul>\n");
        for one in &diagnosis.rejected {
            let (said, why) = (said(answer, &one.finding.cause), words(&rejection(one, answer.controls)));
            let _ = writeln!(page, "<li>{said}: {why}.</li>");
        }
        page.push_str("</ul>\n");
    }
    worth(page, answer);
    page.push_str("</section>\n");
}

/// The sentence that the terminal says, too.
pub(super) fn said(answer: &Answer, one: &RankedCause) -> String {
    words(&statement(one, answer.model.linear(), answer.controls))
}

fn cause(page: &mut String, answer: &Answer, finding: &Finding) {
    let probability = finding.cause.probability;
    let _ = write!(
        page,
        "<li><span class=\"cause\">{}</span> (probability {probability:.2}; {}",
        said(answer, &finding.cause),
        share_of_error(finding, &answer.diagnosis.findings)
    );
    if let Some(own) = &finding.held_out {
        let _ = write!(page, "; on the hold-out runs {}", holdout_word(own));
    }
    page.push(')');
    let class = finding.plausible();
    if let [first, second, ..] = class.as_slice() {
        page.push_str("<br>These data do not rule out:<ul>");
        for rival in class.iter().skip(1) {
            let _ = write!(page, "<li>{} (probability {:.2})</li>", said(answer, rival), rival.probability);
        }
        let _ = write!(page, "</ul>To distinguish them, fly {}.", escaped(manoeuvre(&first.effect, &second.effect)));
    } else {
        page.push_str("<br><span class=\"faint\">No other hypothesis is more probable than 0.05.</span>");
    }
    page.push_str("</li>\n");
}

/// The improvement on the hold-out runs.
fn worth(page: &mut String, answer: &Answer) {
    let diagnosis = &answer.diagnosis;
    let Some(pooled) = diagnosis.gain.as_ref().and_then(|(gain, _)| gain.pooled.as_ref()) else {
        page.push_str("<p>There is no hold-out run, so the improvement is not measured.</p>\n");
        return;
    };
    let [before, after] = &pooled.rms;
    if diagnosis.findings.is_empty() {
        let _ = writeln!(
            page,
            "<p>On the hold-out runs, predicted {HORIZON_S} s ahead, the error is {:.2} times the noise.</p>",
            before.value
        );
        return;
    }
    let [low, high] = pooled.ratio.interval;
    let judged = match pooled.ratio.verdict() {
        ImprovementVerdict::Gain => "a gain",
        ImprovementVerdict::NoGain if pooled.is_not_seen() => "not seen there: the runs do not tell",
        ImprovementVerdict::NoGain => "no gain",
        ImprovementVerdict::Loss => "worse",
    };
    let _ = write!(
        page,
        "<p>On the hold-out runs, predicted {HORIZON_S} s ahead, the error over noise changes from {:.2} to {:.2}: ratio {:.3}, 95 % interval \
         {low:.3} to {high:.3}, {judged}.",
        before.value, after.value, pooled.ratio.value
    );
    if answer.extension.is_empty() {
        page.push_str(" The model is not extended.");
    }
    page.push_str("</p>\n");
}

/// What the data do not identify, and what was not used.
pub(super) fn limits(page: &mut String, answer: &Answer, flights: &Flights<'_>) {
    let diagnosis = &answer.diagnosis;
    page.push_str("<h2>Limits of these data</h2>\n<ul class=\"limits\">\n");
    for (run, why) in &diagnosis.set_aside {
        let _ = writeln!(page, "<li>{} was set aside: {}.</li>", escaped(run), escaped(&reason(why)));
    }
    if !diagnosis.trim_differences.is_empty() {
        let _ = writeln!(
            page,
            "<li>The runs do not begin in the model's trim ({}): forces are taken about the runs' own trim, and a bias of a control or a \
             constant error of a force is not identifiable.</li>",
            escaped(&trim_differences(&diagnosis.trim_differences, answer.controls))
        );
    }
    let tolerance = 100.0 * answer.model.file.tolerance;
    let _ = writeln!(
        page,
        "<li>An error of a derivative within the model's own tolerance, {tolerance:.1} % of it, is no finding.</li>\n\
         <li>Probabilities are among the effects that a model file can have; where none of them fits, the answer is unknown.</li>"
    );
    for finding in &diagnosis.findings {
        if finding.plausible().len() > 1 {
            let _ = writeln!(
                page,
                "<li>Which of {} hypotheses is the cause: {}.</li>",
                finding.plausible().len(),
                said(answer, &finding.cause)
            );
        }
    }
    if flights.holdout.is_empty() {
        page.push_str("<li>Whether the extension predicts runs that it was not fitted to: there is no hold-out run.</li>\n");
    }
    let pairs = diagnosis.gain.iter().flat_map(|(_, pairs)| pairs).zip(flights.holdout);
    for ((before, after), run) in pairs {
        for (which, at) in [("the model", before.diverged_at_s), ("the extended model", after.diverged_at_s)] {
            if let Some(at_s) = at {
                let _ = writeln!(
                    page,
                    "<li>On {} {which} diverges at {at_s:.1} s and is compared up to there.</li>",
                    escaped(&run.name)
                );
            }
        }
        if !before.not_predicted.is_empty() {
            let names: Vec<&str> = before.not_predicted.iter().map(|channel| channel.name(answer.controls)).collect();
            let why = "the model has no derivative of their axis";
            let _ = writeln!(page, "<li>On {} not predicted: {} ({why}).</li>", escaped(&run.name), names.join(", "));
        }
    }
    page.push_str("</ul>\n");
}
