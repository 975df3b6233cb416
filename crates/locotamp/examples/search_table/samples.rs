//! Records for tests.

use crate::record::{Effort, Feet, Judged, Record, Returned, Solution, Verdict};
use crate::runs::{Extent, Part, Until, all};

fn judged(accepted: bool, feet: Option<Feet>) -> Judged {
    Judged {
        verdict: Verdict {
            accepted,
            failed: if accepted { vec![] } else { vec!["cop".into()] },
        },
        feet,
        cost: Some(12.5),
        duration: 7.25,
        height: 0.78,
        phases: 15,
    }
}

/// A run of a part; with a plan after so many seconds.
pub fn of(part: Part, until: Until, seed: u64, first: Option<f64>) -> Record {
    let extent = Extent {
        parts: vec![part],
        ..Extent::default()
    };
    let mut runs = all(&extent).into_iter();
    let run = runs.find(|run| run.group.until == until);
    let mut run = run.expect("such a run");
    run.seed = seed;
    let effort = |seconds: f64| Effort {
        seconds,
        processor_seconds: 2.0 * seconds,
        drawn: 8,
        begun: 4,
        optimised: seed as usize,
        iterations: 100,
        seen: 200,
    };
    let climbs = run.group.scene == "climb";
    let feet = climbs.then_some(Feet {
        on_platform: true,
        over_box: seed != 1,
    });
    let solution = |seconds| Solution {
        number: 3,
        effort: effort(seconds),
        different: true,
        judged: judged(false, feet),
    };
    Record {
        run,
        begun_at: 0,
        threads: 2,
        error: None,
        left_out: false,
        ended: "the end".into(),
        seconds: 20.0,
        search: effort(10.0),
        refinement_iterations: 50,
        returned: first.map(|_| Returned {
            feasible: true,
            refined: "yes".into(),
            judged: judged(seed != 2, feet),
        }),
        solutions: first.map(solution).into_iter().collect(),
    }
}

/// A run of two-box until the first plan.
pub fn record(seed: u64, first: Option<f64>) -> Record {
    of(Part::TwoBox, Until::Plan, seed, first)
}
