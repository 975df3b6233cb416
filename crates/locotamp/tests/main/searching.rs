//! Whole searches on a small scene: the same for a seed however many threads there are, and continued from their journal.

use locotamp::{Attempt, Error, Event, Outcome, Reached, Request, Search, Stop};
use ocp::Refinement;
use scene::Scene;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// A search for two plans of a side step, a few sequences long.
fn request(journal: Option<&Path>) -> Request {
    Request {
        solutions: 2,
        max_optimised: 8,
        refinement: None,
        journal: journal.map(Into::into),
        ..Request::default()
    }
}

fn plan(request: &Request) -> Outcome {
    let scene = Scene::builtin("side-step").expect("a built-in scene");
    locotamp::plan(&scene, request, &mut |_| true).expect("a planning problem")
}

/// What must be the same in two runs: number, contacts, how far they got.
fn results(attempts: &[Attempt]) -> Vec<(usize, Vec<String>, Reached)> {
    let one = |a: &Attempt| (a.number, a.labels.clone(), a.reached);
    attempts.iter().map(one).collect()
}

#[test]
fn the_observer_is_told_of_every_sequence_that_counts_as_tried() {
    let scene = Scene::builtin("side-step").expect("a built-in scene");
    let mut told = Vec::new();
    let mut observe = |event: &Event| {
        if let Event::Tried { number, reached } = event {
            told.push((*number, *reached));
        }
        true
    };
    let outcome = locotamp::plan(&scene, &request(None), &mut observe).expect("a planning problem");
    let tried: Vec<_> = outcome
        .attempts
        .iter()
        .map(|x| (x.number, x.reached))
        .collect();
    assert!(!tried.is_empty());
    assert_eq!(told, tried);
}

#[test]
fn a_plan_that_waits_for_its_turn_is_not_lost_when_the_search_is_stopped() {
    let scene = Scene::builtin("side-step").expect("a built-in scene");
    // The four sequences to choose the first from are drawn; the fifth while that is optimised.
    let stopped_after = |seconds| {
        let mut taken = 0;
        let mut observe = |event: &Event| match event {
            Event::Sequence { number: 5.., .. } => {
                std::thread::sleep(Duration::from_secs(seconds));
                false
            }
            Event::Optimised { .. } => {
                taken += 1;
                true
            }
            _ => true,
        };
        let two_threads = Request {
            threads: 2, // the one that draws sleeps
            ..request(None)
        };
        let outcome =
            locotamp::plan(&scene, &two_threads, &mut observe).expect("a planning problem");
        // Two are under way from the beginning; on a slow machine both may have ended.
        assert!(
            taken <= 2,
            "it was stopped before the first result was taken"
        );
        outcome.feasible
    };
    assert!([2, 8, 32, 128].into_iter().any(stopped_after));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_plan_whose_refinement_is_stopped_is_told_as_what_it_is() {
    let scene = Scene::builtin("side-step").expect("a built-in scene");
    let refined = Request {
        solutions: 1,
        ..Request::default()
    };
    let mut observe = |event: &Event| !matches!(event, Event::Refining { .. });
    let outcome = locotamp::plan(&scene, &refined, &mut observe).expect("a planning problem");
    assert!(outcome.feasible);
    let best = outcome.best.expect("a plan");
    assert!(matches!(best.refined, locotamp::Refined::Failed(_)));
    // On the grid on which it was found it keeps its margins, with some room: it ends at a large barrier parameter there.
    let violation = best.plan.violation.expect("it is told");
    assert!(violation < 1e-3, "{violation}");
    for name in ["clearance", "swing", "landing"] {
        let margin = (best.quality.margins.iter())
            .find(|margin| margin.name == name)
            .expect("a margin");
        let beyond = margin.reached.expect("a foot swings") - margin.demanded;
        let room = if name == "swing" { 5e-3 } else { 1e-3 };
        assert!(beyond < room || name == "clearance", "{margin:?}");
        assert!(beyond > -1e-3, "{margin:?}");
    }
}

#[test]
fn threads_change_nothing_and_a_seed_everything() {
    let with = |threads, seed| {
        plan(&Request {
            threads,
            seed,
            ..request(None)
        })
    };
    let (one, four, other) = (with(1, 0), with(4, 0), with(4, 7));
    assert!(one.feasible);
    assert_eq!(results(&one.attempts), results(&four.attempts));
    let plan = |outcome: &Outcome| outcome.best.as_ref().map(|found| found.plan.q.clone());
    assert_eq!(plan(&one), plan(&four));
    assert_ne!(results(&one.attempts), results(&other.attempts));
    assert!(!one.alternatives.is_empty());
}

#[test]
fn a_search_that_was_cut_off_goes_on_from_its_journal_and_comes_to_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.jsonl");
    let whole = plan(&request(Some(&path)));
    let text = std::fs::read_to_string(&path).expect("a journal");
    let lines: Vec<&str> = text.lines().collect();
    let sequences = |lines: &[&str]| {
        let is = |line: &&&str| line.contains("\"kind\":\"sequence\"");
        lines.iter().filter(is).count()
    };
    assert_eq!(sequences(&lines), whole.attempts.len());

    // As if killed while a line was being written, after the first sequence that was optimised.
    let cut = lines
        .iter()
        .position(|line| line.contains("\"promise\""))
        .expect("some sequence was optimised");
    let half = &lines[cut + 1][..lines[cut + 1].len() / 2];
    std::fs::write(&path, lines[..=cut].join("\n") + "\n" + half).expect("written");
    let resumed = plan(&Request {
        resume: true,
        ..request(Some(&path))
    });
    assert_eq!(results(&resumed.attempts), results(&whole.attempts));
    let after = std::fs::read_to_string(&path).expect("a journal");
    let after: Vec<&str> = after.lines().collect();
    assert_eq!(after[..=cut], lines[..=cut], "nothing is asked again");
    assert_eq!(sequences(&after), sequences(&lines));

    // Visits and values too are those of the uninterrupted run, and the last line that has the root counts every reward.
    let statistics = |lines: &[&str]| -> Vec<(u64, Vec<u64>, Vec<f64>, f64)> {
        let parse = |line: &&str| serde_json::from_str::<serde_json::Value>(line).expect("JSON");
        let all = lines.iter().map(parse).filter(|x| x["kind"] == "sequence");
        all.map(|x| {
            let list = |key: &str| x[key].as_array().cloned().unwrap_or_default();
            (
                x["number"].as_u64().expect("a number"),
                list("visits")
                    .iter()
                    .filter_map(serde_json::Value::as_u64)
                    .collect(),
                list("values")
                    .iter()
                    .filter_map(serde_json::Value::as_f64)
                    .collect(),
                x["reward"].as_f64().expect("a reward"),
            )
        })
        .collect()
    };
    let all = statistics(&lines);
    assert_eq!(statistics(&after), all);
    let mut told = 0.0;
    for (number, visits, values, reward) in &all {
        told += reward;
        assert!(!visits.is_empty() && visits.len() == values.len());
        assert!(visits.windows(2).all(|x| x[0] >= x[1]), "{visits:?}");
        let sum = visits[0] as f64 * values[0];
        assert!(sum > told - 1e-3, "sequence {number}: {sum}, {told} told");
    }
}

#[test]
fn motions_that_must_hold_on_a_finer_grid_are_the_same_for_all_threads_and_from_a_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.jsonl");
    let with = |threads, journal: Option<&Path>, resume| {
        plan(&Request {
            threads,
            resume,
            max_optimised: 5,
            refinement: Request::default().refinement,
            ..request(journal)
        })
    };
    let whole = with(1, Some(&path), false);
    assert!(whole.feasible);
    let text = std::fs::read_to_string(&path).expect("a journal");
    let lines: Vec<&str> = text.lines().collect();
    let is_coarse = |line: &&str| line.contains("\"kind\":\"coarse\"");
    let first = lines.iter().position(is_coarse).expect("a coarse motion");
    assert_eq!(
        results(&with(4, None, false).attempts),
        results(&whole.attempts)
    );

    // As if killed when one motion was known on the coarse grid alone.
    std::fs::write(&path, lines[..=first].join("\n") + "\n").expect("written");
    let resumed = with(2, Some(&path), true);
    assert_eq!(results(&resumed.attempts), results(&whole.attempts));
    let after = std::fs::read_to_string(&path).expect("a journal");
    let known = after.lines().filter(|line| line == &lines[first]).count();
    assert_eq!(known, 1, "it is not optimised again");
    let coarse = |text: &str| text.lines().filter(is_coarse).count();
    assert_eq!(coarse(&after), coarse(&text));

    // As if killed at the end: motions are set up again, and cost what they did.
    let again = with(1, Some(&path), true);
    let costs = |outcome: &Outcome| -> Vec<Option<f64>> {
        let costs = outcome.attempts.iter().map(|attempt| attempt.cost);
        costs.map(|cost| cost.map(|c| (c * 1e6).round())).collect()
    };
    assert!(costs(&whole).iter().any(Option::is_some));
    assert_eq!(costs(&again), costs(&whole));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn the_best_of_many_sequences_costs_no_more_than_the_first_and_is_the_same_for_all_threads() {
    const MANY: usize = 7;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.jsonl");
    let with = |min_optimised, threads, resume| {
        plan(&Request {
            solutions: 1,
            min_optimised,
            threads,
            resume,
            refinement: Some(Refinement {
                max_step: 0.06,
                ..Refinement::default()
            }),
            ..request(Some(&path))
        })
    };
    let cost = |outcome: &Outcome| outcome.alternatives[0].cost;
    let moved = |outcome: &Outcome| {
        let attempts = outcome.attempts.iter();
        attempts.filter(|attempt| attempt.iterations > 0).count()
    };
    let first = with(0, 1, false);
    let best = with(MANY, 1, false);
    assert!(moved(&first) < MANY && moved(&best) >= MANY);
    assert!(cost(&best) <= cost(&first));

    let text = std::fs::read_to_string(&path).expect("a journal");
    let lines: Vec<&str> = text.lines().collect();
    std::fs::write(&path, lines[..lines.len() / 2].join("\n") + "\n").expect("written");
    let resumed = with(MANY, 2, true);
    for other in [resumed, with(MANY, 4, false)] {
        assert_eq!(results(&other.attempts), results(&best.attempts));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn long_strides_get_more_steps_than_were_drawn_and_the_journal_knows_which() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.jsonl");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scene = Scene::load(scenes.join("carry-away.toml")).expect("a scene");
    let with = |resume| {
        let request = Request {
            solutions: 1,
            max_optimised: 1,
            resume,
            ..request(Some(&path))
        };
        locotamp::plan(&scene, &request, &mut |_| true).expect("a planning problem")
    };
    let whole = with(false);
    let text = std::fs::read_to_string(&path).expect("a journal");
    let is_steps = |line: &&str| line.contains("\"kind\":\"steps\"");
    let phases = |attempt: &Attempt| attempt.labels.len();
    let tried = whole.attempts.iter().filter(|a| a.iterations > 0);
    let tried: Vec<usize> = tried.map(phases).collect();
    assert_eq!(tried.len(), 1);
    let longer = text.lines().filter(is_steps).any(|line| {
        let steps: serde_json::Value = serde_json::from_str(line).expect("JSON");
        let count = |key: &str| steps[key].as_array().map_or(0, Vec::len);
        let rounds = count("rounds");
        rounds > 0 && count("states") + 4 * rounds == tried[0]
    });
    assert!(longer, "{tried:?} phases; {text}");

    // From the whole journal nothing is asked again; from the steps on, the rest is done again with the same steps.
    let again = with(true);
    assert_eq!(results(&again.attempts), results(&whole.attempts));
    assert_eq!(std::fs::read_to_string(&path).expect("a journal"), text);
    let lines: Vec<&str> = text.lines().collect();
    let cut = lines.iter().rposition(is_steps).expect("steps");
    std::fs::write(&path, lines[..=cut].join("\n") + "\n").expect("written");
    let resumed = with(true);
    assert_eq!(results(&resumed.attempts), results(&whole.attempts));
}

#[test]
fn the_journal_of_another_seed_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.jsonl");
    let stopped = Stop::default();
    stopped.0.store(true, Ordering::SeqCst);
    let now = |seed, resume| {
        let scene = Scene::builtin("side-step").expect("a built-in scene");
        let request = Request {
            seed,
            resume,
            stop: stopped.clone(),
            ..request(Some(&path))
        };
        locotamp::plan(&scene, &request, &mut |_| true)
    };
    assert!(now(1, false).is_ok());
    assert!(now(1, true).is_ok());
    let refused = now(2, true).expect_err("another seed");
    assert!(matches!(refused, Error::Journal { .. }), "{refused}");
}

#[test]
fn the_other_policies_find_plans_too() {
    for search in [Search::BestFirst, Search::Random] {
        let outcome = plan(&Request {
            search,
            solutions: 1,
            ..request(None)
        });
        assert!(outcome.feasible, "{search:?}: {}", outcome.ended);
    }
}

/// A search that comes as far as no motion, of a scene of the repository with some places changed.
fn in_vain(scene: &str, changes: &[(&str, &str)], seconds: f64) -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut text = std::fs::read_to_string(folder.join(scene)).expect("a scene");
    for (from, to) in changes {
        assert!(text.contains(from), "{from:?} is not in:\n{text}");
        text = text.replace(from, to);
    }
    let scene = Scene::from_toml(&text, "scene.toml", &folder).expect("a scene");
    let request = Request {
        explain: true,
        time_limit: seconds,
        ..request(None)
    };
    let outcome = locotamp::plan(&scene, &request, &mut |_| true).expect("a planning problem");
    assert!(outcome.best.is_none());
    outcome
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_search_in_vain_says_how_wide_a_box_may_be_for_two_hands() {
    let wide = ("size = [0.10, 0.25, 0.20]", "size = [0.10, 1.1, 0.20]");
    let table = ("size = [0.30, 0.60, 0.03]", "size = [0.30, 1.2, 0.03]");
    let outcome = in_vain("lift-box.toml", &[wide, table], 5.0);
    let [possible] = outcome.possible.as_slice() else {
        panic!("{:?}", outcome.possible);
    };
    assert_eq!(possible.contacts.len(), 2);
    assert_eq!(
        (possible.remedy.quantity.as_str(), &possible.remedy.of[..]),
        ("width", &["box".to_owned()][..])
    );
    assert!((0.3..1.1).contains(&possible.remedy.to), "{possible:?}");
    let explained = outcome.explained.expect("an explanation").explanation;
    let remedy = explained.remedies.first().expect(&explained.text);
    assert_eq!(remedy.quantity, "width", "{}", explained.text);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_search_in_vain_explains_a_sequence_that_lifts_what_the_goal_speaks_of() {
    let high = (
        "position = [0.45, 1.20, 0.735]",
        "position = [0.45, 1.20, 1.9]",
    );
    let outcome = in_vain("pick-place.toml", &[high], 8.0);
    let explained = outcome.explained.expect("an explanation");
    let cause = &explained.explanation.cause;
    assert_eq!(cause.group, "geometry", "{explained:?}");
    assert!(
        cause.action.starts_with("place red_box on table_b_top"),
        "{explained:?}"
    );
}
