//! Given sequences.

use locotamp::{Event, Preset, Refinement, Request, Sticking, solve};
use scene::{Scene, Sequence, SequenceFile};
use std::path::Path;

/// A sequence of the repository and its scene.
fn given(path: &str) -> (Scene, Sequence) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
    let file = SequenceFile::load(folder.join(path)).expect("a file");
    let scene = file.load_scene().expect("its scene");
    let sequence = file.resolve(&scene).expect("a sequence of the scene");
    (scene, sequence)
}

/// All at once, the keyframes of these twelve phases end in a local minimum.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_long_sequence_has_keyframes_beginning_by_beginning() {
    let (scene, sequence) = given("climb/carry_and_climb.toml");
    let request = Request {
        explain: false,
        refinement: None,
        ..Request::default()
    };
    let mut until_a_motion = |event: &Event| !matches!(event, Event::Iteration { .. });
    let solved =
        solve(&scene, &sequence, &request, &mut until_a_motion).expect("a planning problem");
    assert!(solved.keyframes.possible, "{:?}", solved.reason);
    assert!(!solved.feasible, "stopped at once");
    let plan = solved.best.expect("the motion as far as it got").plan;
    let end = assert_costs_add_up(&plan);
    assert!(end.contains(&"goal".into()), "{end:?}");
}

/// The ground under the mat is nearer to the sole than swinging feet keep from it.
#[test]
fn a_robot_steps_onto_a_mat_that_is_thinner_than_feet_swing_high() {
    for height in [0.01, 0.02, 0.04] {
        let scene = format!(
            "name = 'mat'\nrobot = 'g1'\n[[static]]\nname = 'ground'\nplane = true\n\
             [[static]]\nname = 'mat'\nsize = [0.6, 0.8, {height}]\nposition = [0.6, 0.0, {}]\n\
             [goal]\ncontacts = [['left_foot', 'mat_top'], ['right_foot', 'mat_top']]\n",
            0.5 * height
        );
        let here = Path::new("");
        let scene = Scene::from_toml(&scene, "mat.toml", here).expect("a scene");
        let phase = |left: &str, right: &str| {
            let feet = [("left_foot", left), ("right_foot", right)];
            let stand = feet.iter().filter(|(_, surface)| !surface.is_empty());
            let pairs: Vec<_> = stand
                .map(|(foot, on)| format!("['{foot}', '{on}']"))
                .collect();
            format!("[[phase]]\ncontacts = [{}]\n", pairs.join(", "))
        };
        let (ground, mat) = ("ground_top", "mat_top");
        let phases = [
            (ground, ground),
            ("", ground),
            (mat, ground),
            (mat, ""),
            (mat, mat),
        ];
        let phases: String = phases
            .iter()
            .map(|(left, right)| phase(left, right))
            .collect();
        let text = format!("steps = 8\n{phases}");
        let file = SequenceFile::from_toml(&text, "steps.toml", here).expect("a sequence file");
        let sequence = file.resolve(&scene).expect("a sequence of the scene");
        let request = Request {
            explain: false,
            refinement: None,
            ..Request::default()
        };
        let solved = solve(&scene, &sequence, &request, &mut |_| true).expect("a problem");
        assert!(solved.feasible, "{height} m: {:?}", solved.reason);
    }
}

/// Configurations of the robot at the phase boundaries of a plan.
fn boundaries(plan: &plan::Plan) -> Vec<Vec<f64>> {
    let mut node = 0;
    let mut out = vec![plan.q[0].clone()];
    for phase in &plan.phases {
        node += phase.steps;
        out.push(plan.q[node].clone());
    }
    out
}

#[test]
fn keyframes_begin_at_configurations_that_are_known() {
    let (scene, sequence) = given("stairs/up_one.toml");
    let solved = |configurations: &[Vec<f64>], time_limit| {
        let sequence = Sequence {
            configurations: configurations.to_vec(),
            ..sequence.clone()
        };
        let request = Request {
            time_limit,
            explain: false,
            refinement: None,
            ..Request::default()
        };
        solve(&scene, &sequence, &request, &mut |_| true).expect("a planning problem")
    };
    let from_nothing = solved(&[], 60.0);
    let known = boundaries(&from_nothing.best.expect("a motion").plan);
    let from_known = solved(&known, 0.0).keyframes;
    assert!(from_known.possible);
    let of_nothing = from_nothing.keyframes.iterations;
    assert!(
        from_known.iterations < of_nothing,
        "{} and {of_nothing}",
        from_known.iterations
    );
    // Of another robot: of no use, and no harm.
    let short: Vec<_> = known.iter().map(|q| q[..8].to_vec()).collect();
    assert_eq!(solved(&short, 0.0).keyframes.iterations, of_nothing);
}

#[test]
fn a_sequence_without_a_motion_is_tried_twice_and_one_with_a_motion_once() {
    let attempts = |path: &str| {
        let (scene, sequence) = given(path);
        let request = Request {
            explain: false,
            refinement: None,
            ..Request::default()
        };
        let (mut begun, mut iterations) = (0, 0);
        let mut observe = |event: &Event| {
            if let Event::Iteration { iteration, .. } = event {
                begun += usize::from(*iteration == 0);
                iterations += usize::from(*iteration > 0);
            }
            true
        };
        let solved = solve(&scene, &sequence, &request, &mut observe).expect("a planning problem");
        let motion = solved.motion.expect("keyframes");
        assert_eq!(motion.iterations, iterations, "those of all attempts");
        (begun, solved.feasible)
    };
    assert_eq!(attempts("weak_leg/stand.toml"), (2, false));
    assert_eq!(attempts("flat/stand.toml"), (1, true));
}

/// The costs of a plan by interval and term, with those of the end, are its cost; the names of those of the end.
fn assert_costs_add_up(plan: &plan::Plan) -> Vec<String> {
    let costs = plan.costs.as_ref().expect("costs");
    let sum = costs.per_interval.iter().flatten().sum::<f64>() + costs.end.values().sum::<f64>();
    let objective = plan.objective.as_ref().expect("an objective");
    let cost = objective.cost.expect("a cost");
    let rounding = 0.5e-7 * (costs.per_interval.len() * costs.terms.len() + costs.end.len()) as f64;
    assert!((sum - cost).abs() < rounding, "{sum} of {cost}");
    let time = costs.terms.iter().position(|x| x == "time").expect("time");
    for (row, t) in costs.per_interval.iter().zip(plan.time.windows(2)) {
        assert!((row[time] - (t[1] - t[0])).abs() < 1e-7, "a second costs 1");
        assert!(row.iter().all(|cost| *cost >= 0.0), "{row:?}");
    }
    costs.end.keys().cloned().collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn the_costs_of_a_solved_sequence_by_interval_and_term_add_up_to_its_cost() {
    let (scene, sequence) = given("boxes/squeeze.toml");
    for refinement in [None, Some(Refinement::default())] {
        let request = Request {
            refinement,
            ..Request::default()
        };
        let solved = solve(&scene, &sequence, &request, &mut |_| true).expect("a planning problem");
        assert!(solved.feasible, "{:?}", solved.reason);
        let plan = solved.best.expect("a plan").plan;
        assert_eq!(assert_costs_add_up(&plan), ["final_posture"]);
        let terms = &plan.costs.as_ref().expect("costs").terms;
        assert!(
            ["object_velocity", "force"]
                .iter()
                .all(|x| terms.contains(&(*x).into()))
        );
        let rates = terms.contains(&"force_rate".into());
        assert_eq!(rates, request.refinement.is_some());
    }
}

/// Largest drift of a contact in the paper's problem over a phase [mm], and what the checker allows.
fn drift(sticking: Sticking) -> (f64, f64) {
    let (scene, sequence) = given("yardstick/fixed.toml");
    let request = Request {
        preset: Preset::Paper,
        sticking,
        ..Request::default()
    };
    let solved = solve(&scene, &sequence, &request, &mut |_| true).expect("a planning problem");
    assert!(solved.feasible, "{:?}", solved.reason);
    let plan = solved.best.expect("a plan").plan;
    let report = check::check(&plan, &check::Options::accept());
    let slip = report.row("slip_phase").expect("a row");
    (slip.value.expect("contacts"), slip.tolerance)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn contacts_of_the_papers_problem_drift_only_if_they_stick_by_velocity() {
    let (by_displacement, allowed) = drift(Sticking::Displacement);
    assert!(by_displacement < 0.1, "{by_displacement} mm");
    let (by_velocity, _) = drift(Sticking::Velocity);
    assert!(by_velocity > allowed, "{by_velocity} mm");
}

/// Height above the place where it lands below which a foot is nearly down, and how far from there it may be then [m].
const LOW: f64 = 0.01;
const BESIDE: f64 = 0.012;
/// Last part of a swing [s], and how high a foot may be at its beginning [m].
const LAST: f64 = 0.2;
const TOUCHING: f64 = 0.001;
/// Distance of the centre of pressure from the ankle, along the foot, while it takes up its first load [m].
const BELOW_ANKLE: f64 = 0.02;
/// The same from the middle of the foot that stands, in the last part of the other one's swing [m].
const NEAR_MIDDLE: f64 = 0.002;
/// Least share of the robot's weight on each foot at the end.
const SHARED: f64 = 0.25;

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_refined_foot_comes_down_straight_and_takes_up_its_load_below_the_ankle() {
    let (scene, sequence) = given("flat/forward_2.toml");
    let request = Request::default();
    let solved = solve(&scene, &sequence, &request, &mut |_| true).expect("a planning problem");
    assert!(solved.feasible, "{:?}", solved.reason);
    let found = solved.best.expect("a plan");
    let plan = found.plan;
    let system = ocp::System::new(&scene).expect("a system");
    let mut kinematics = multibody::Kinematics::new(&system.model);
    let mut landings = 0;
    for foot in scene
        .interfaces
        .iter()
        .filter(|i| i.role == scene::Role::Foot)
    {
        let carrier = system.carrier(foot.owner, &foot.body_from_interface);
        let places = plan.q.iter().map(|q| {
            kinematics.update(&system.model, q);
            carrier.world_from_frame(&kinematics).origin()
        });
        let places: Vec<_> = places.collect();
        let first = |k: usize| plan.phases[..k].iter().map(|p| p.steps).sum::<usize>();
        let touches = |k: usize| {
            let contacts = &plan.phases[k].contacts;
            contacts.iter().any(|contact| contact.a == foot.name)
        };
        let comes = |&k: &usize| touches(k) && !touches(k - 1);
        let ankle = carrier.body_from_frame.inverse().origin();
        for k in (1..plan.phases.len()).filter(comes) {
            let landing = places[first(k)];
            let swing = &places[first(k - 1)..first(k)];
            let way = (swing[0] - landing).norm();
            let low = swing.iter().rev().take_while(|at| at.z - landing.z < LOW);
            let beside = |at: &nalgebra::Vector3<f64>| (at - landing).xy().norm();
            let farthest = low.map(beside).fold(0.0, f64::max);
            assert!(farthest < BESIDE.min(0.5 * way), "{farthest} of {way} m");
            let time = &plan.time[..first(k)];
            let last = time.partition_point(|t| *t < plan.time[first(k)] - LAST);
            let height = places[last].z - landing.z;
            assert!(height < TOUCHING, "{height} m, {LAST} s before");
            let steps = plan.phases[k - 1].steps;
            let until = steps + last - first(k);
            for standing in &plan.phases[k - 1].contacts {
                for wrench in &standing.wrench[until..steps] {
                    let center = (wrench[4] / wrench[2]).abs();
                    assert!(center < NEAR_MIDDLE, "{center} m on {}", standing.a);
                }
            }
            let mut contacts = plan.phases[k].contacts.iter();
            let wrench = contacts
                .find(|contact| contact.a == foot.name)
                .expect("it has landed")
                .wrench[0];
            let center = -wrench[4] / wrench[2];
            assert!(
                (center - ankle.x).abs() < BELOW_ANKLE,
                "{center} not {} m",
                ankle.x
            );
            landings += 1;
        }
    }
    assert_eq!(landings, 2, "two steps");
    let landing = found
        .quality
        .margins
        .iter()
        .find(|m| m.name == "landing")
        .expect("a margin");
    let reached = landing.reached.expect("contacts that begin");
    assert!(reached < landing.demanded + 1e-4, "{reached} m/s");
    let last = plan.phases.last().expect("a phase");
    for standing in &last.contacts {
        let wrenches = &standing.wrench;
        let weight = system.robot_mass * scene.gravity.norm();
        let share = wrenches[wrenches.len() / 2][2] / weight;
        assert!(share > SHARED, "{share} of the weight on {}", standing.a);
    }
    let mut margins = found.quality.margins.iter();
    let load = margins.find(|m| m.name == "foot_load").expect("a margin");
    let reached = load.reached.expect("feet in contact");
    assert!(reached > load.demanded - 1e-3, "{reached} N");
    let mut margins = found.quality.margins.iter();
    let spare = margins.find(|m| m.name == "spare_load").expect("a margin");
    let reached = spare.reached.expect("feet in contact");
    assert!(spare.demanded > load.demanded, "{} N", spare.demanded);
    assert!(reached > spare.demanded - 1e-2, "{reached} N");
}
