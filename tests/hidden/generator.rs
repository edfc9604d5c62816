//! The generator itself: a seed gives the same case again, what is hidden is in the data, and nothing where nothing was hidden.

use super::case::{FAMILIES, Sort, case, peak_difference, plan};
use super::flights::fly;
use super::outside;
use super::written::write_case;
use crate::support::manoeuvre::over_seeds;
use crate::support::recorded_samples::samples_of;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::{Effect, EffectKind};
use sideslip::flight::file::effect_file::parse_effects;
use sideslip::flight::file::model_file::ModelFile;
use std::path::Path;

fn sorts() -> Vec<Sort> {
    FAMILIES.into_iter().map(Sort::Single).chain([Sort::Double, Sort::Healthy, Sort::Outside]).collect()
}

#[test]
fn a_seed_gives_the_same_case_and_another_another() {
    for sort in [Sort::Single(FAMILIES[2]), Sort::Outside] {
        assert_eq!(case(sort, 4), case(sort, 4));
        assert_ne!(case(sort, 4).fit, case(sort, 5).fit);
    }
}

#[test]
fn what_is_hidden_is_in_the_data() {
    let sorts = sorts();
    over_seeds(sorts.len() as u64, |place| {
        let sort = sorts[place as usize];
        let plan = plan(sort, place);
        let (fit, holdout) = fly(&plan).unwrap();
        let (clean, _) = fly(&plan.without()).unwrap();
        let peak = peak_difference(&fit, &clean);
        let said = plan.hidden.law.as_ref().map(|law| law.said.clone());
        eprintln!("{sort:?} {:?} {said:?} at {:?} of large: {peak:.1} noise std", plan.hidden.effects, plan.hidden.share);
        assert_eq!((fit.len(), holdout.len()), (4, 2));
        let hidden = plan.hidden.effects.len() + usize::from(plan.hidden.law.is_some());
        match sort {
            Sort::Healthy => assert!(hidden == 0 && peak == 0.0),
            Sort::Double => {
                assert!(hidden == 2 && plan.hidden.effects[0].kind().family() != plan.hidden.effects[1].kind().family())
            }
            Sort::Outside => assert!(hidden == 1 && plan.hidden.effects.is_empty()),
            Sort::Single(family) => assert!(hidden == 1 && plan.hidden.effects[0].kind().family() == family),
        }
        assert!(hidden == 0 || peak >= 4.0, "{peak}");
    });
}

/// Half of the cases are off, every kind takes its turn, and sizes reach from a quarter to the whole.
#[test]
fn kinds_and_sizes_take_turns() {
    let plans = over_seeds(12, |place| plan(Sort::Single(FAMILIES[2]), 12 * place + 2));
    let kinds: std::collections::BTreeSet<&str> = plans.iter().map(|plan| plan.hidden.effects[0].kind().name()).collect();
    assert_eq!(kinds.len(), EffectKind::ALL.iter().filter(|kind| kind.family() == FAMILIES[2]).count(), "{kinds:?}");
    let shares: Vec<f64> = plans.iter().map(|plan| plan.hidden.share[0]).collect();
    assert!(shares.iter().all(|share| (0.25..=1.0).contains(share)), "{shares:?}");
    assert!(shares.iter().any(|&share| share < 0.5) && shares.iter().any(|&share| share > 0.5), "{shares:?}");
    for family in 0..6 {
        let off = (0..24).filter(|turn| super::case::is_off(6 * turn + family)).count();
        assert_eq!(off, 12);
    }
}

/// A healthy aircraft that is not off is its model: flown again on the controls as they were recorded, the motion stays within
/// what the controls' noise lets it drift.
#[test]
fn a_healthy_aircraft_is_its_model() {
    let seed = (0..).find(|&seed| !super::case::is_off(seed)).unwrap();
    let case = case(Sort::Healthy, seed);
    let model = ModelFile::parse(&case.model_text).unwrap().linear;
    for recorded in &case.fit {
        let truth = super::flights::again(recorded, &model);
        for (channel, allowed) in [(Channel::P, 0.01), (Channel::R, 0.01), (Channel::Phi, 0.06), (Channel::Beta, 0.03)] {
            let (sum, count) = recorded
                .samples
                .iter()
                .filter_map(|sample| {
                    let there = truth.iter().find(|there| (there.time_s - sample.time_s).abs() < 1e-9)?;
                    Some(sample.get(channel)? - there.get(channel)?)
                })
                .fold((0.0, 0.0), |(sum, count), apart| (sum + apart * apart, count + 1.0));
            let rms = (sum / count).sqrt();
            eprintln!("{} {channel:?}: {rms:.4} apart", recorded.name);
            assert!(count > 500.0 && rms < allowed, "{} {channel:?}: {rms}", recorded.name);
        }
    }
}

/// The files are read back as they were written.
#[test]
fn a_case_as_files_is_the_case() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hidden-case");
    let case = case(Sort::Single(FAMILIES[5]), 53);
    write_case(&case, &folder);
    for recorded in case.fit.iter().chain(&case.holdout) {
        let samples = samples_of(&folder.join(format!("{}.csv", recorded.name)));
        assert_eq!(samples, recorded.samples);
    }
    let text = std::fs::read_to_string(folder.join("truth.toml")).unwrap();
    let effects = &text[text.find("[[effect]]").unwrap()..];
    let read: Vec<Effect> = parse_effects(effects).unwrap().into_iter().map(|declared| declared.effect).collect();
    assert_eq!(read, case.hidden);
    assert!(ModelFile::parse(&std::fs::read_to_string(folder.join("model.toml")).unwrap()).is_ok());
}

/// What one term of the library makes up is no cause outside.
#[test]
fn a_cause_outside_is_outside() {
    let plans = over_seeds(8, |seed| plan(Sort::Outside, seed));
    let said: Vec<&str> = plans.iter().map(|plan| plan.hidden.law.as_ref().unwrap().said.as_str()).collect();
    eprintln!("{said:#?}");
    assert!(
        outside::TURNS == 8
            && ["hysteresis", "memory", "onset", "shaking"].iter().all(|word| said.iter().any(|s| s.contains(word)))
    );
}
