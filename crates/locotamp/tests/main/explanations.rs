//! Problems that are impossible by construction: the explanation names phase, cause and subject, and its first remedy, applied
//! to the files as a user would do it, makes the sequence feasible.

use locotamp::{Explanation, Request, Solved, solve};
use scene::{Scene, SequenceFile};
use std::path::{Path, PathBuf};

/// Files of a problem, as texts that tests edit.
#[derive(Clone)]
struct Problem {
    /// Scene file.
    scene: String,
    /// Sequence file.
    sequence: String,
    /// Robot file and URDF, if they are not the built-in ones.
    robot: Option<[String; 2]>,
    /// Is a motion asked for that can be refined.
    is_refined: bool,
}

fn repository(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::fs::read_to_string(root.join(path)).unwrap()
}

/// A text with one place changed.
fn edited(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from:?} is not in:\n{text}");
    text.replace(from, to)
}

impl Problem {
    fn new(scene: &str, sequence: &str) -> Self {
        Self {
            scene: repository(&format!("scenes/{scene}.toml")),
            sequence: repository(&format!("scenes/sequences/{sequence}.toml")),
            robot: None,
            is_refined: false,
        }
    }

    fn refined(mut self) -> Self {
        self.is_refined = true;
        self
    }

    /// The leg that can push with 60 N.
    fn weak_leg() -> Self {
        let mut problem = Self::new("weak-leg", "weak_leg/stand");
        problem.robot = Some([String::new(), repository("scenes/weak-leg.urdf")]);
        problem
    }

    /// The same with its own copy of the G1's files.
    fn with_own_g1(mut self) -> Self {
        self.scene = edited(&self.scene, "robot = \"g1\"", "robot = \"g1.toml\"");
        self.robot = Some([repository("robots/g1.toml"), repository("robots/g1.urdf")]);
        self
    }

    fn urdf(mut self, from: &str, to: &str) -> Self {
        let robot = self.robot.as_mut().expect("a robot of its own");
        robot[1] = edited(&robot[1], from, to);
        self
    }

    fn robot_file(mut self, from: &str, to: &str) -> Self {
        let robot = self.robot.as_mut().expect("a robot of its own");
        robot[0] = edited(&robot[0], from, to);
        self
    }

    fn scene(mut self, from: &str, to: &str) -> Self {
        self.scene = edited(&self.scene, from, to);
        self
    }

    fn sequence(mut self, from: &str, to: &str) -> Self {
        self.sequence = edited(&self.sequence, from, to);
        self
    }

    fn solve(&self, explain: bool) -> Solved {
        let folder = tempfile::tempdir().unwrap();
        let path: PathBuf = folder.path().into();
        if let Some([file, urdf]) = &self.robot {
            std::fs::write(path.join("g1.toml"), file).unwrap();
            std::fs::write(path.join("g1.urdf"), urdf).unwrap();
            std::fs::write(path.join("weak-leg.urdf"), urdf).unwrap();
        }
        let scene = Scene::from_toml(&self.scene, "scene.toml", &path).unwrap();
        let file = SequenceFile::from_toml(&self.sequence, "sequence.toml", &path).unwrap();
        let sequence = file.resolve(&scene).unwrap();
        let request = Request {
            explain,
            refinement: self.is_refined.then(ocp::Refinement::default),
            ..Request::default()
        };
        solve(&scene, &sequence, &request, &mut |_| true).unwrap()
    }
}

/// What an explanation must say.
struct Expected {
    phase: usize,
    group: &'static str,
    /// Part of the subject.
    subject: &'static str,
    /// The value of the first remedy must lie here.
    range: std::ops::RangeInclusive<f64>,
}

/// Checks the explanation of an impossible problem, and that the problem with the remedy applied is feasible.
fn check(problem: &Problem, expected: &Expected, apply: impl Fn(Problem, &str) -> Problem) {
    let solved = problem.solve(true);
    assert!(!solved.feasible);
    let explanation = solved.explanation.expect("an explanation");
    let text = &explanation.text;
    let cause = &explanation.cause;
    assert_eq!(cause.phase, expected.phase, "{text}");
    assert_eq!(cause.group, expected.group, "{text}");
    assert!(cause.subject.contains(expected.subject), "{text}");
    assert!(cause.amount > 0.0, "{text}");
    let remedy = explanation.remedies.first().expect(text);
    assert!(expected.range.contains(&remedy.to), "{text}");
    if let Some(found) = &solved.best {
        assert_eq!(found.plan.explanation.as_ref(), Some(&explanation));
        let read = plan::Plan::from_json(&found.plan.to_json().unwrap()).unwrap();
        let read: Explanation = read.explanation.expect("it is in the file");
        assert_eq!(read.remedies, explanation.remedies);
    }
    let repaired = apply(problem.clone(), &format!("{:?}", remedy.to)).solve(false);
    assert!(
        repaired.feasible,
        "{:?} in spite of\n{text}",
        repaired.reason
    );
}

#[test]
fn a_leg_that_is_too_weak_is_told_its_force() {
    let expected = Expected {
        phase: 1,
        group: "torque",
        subject: "slide",
        range: 87.2..=100.0, // 8 kg · 9.81 m/s² / 0.9
    };
    check(&Problem::weak_leg(), &expected, |problem, to| {
        problem.urdf("effort=\"60\"", &format!("effort=\"{to}\""))
    });
}

/// The leg with 500 N, which is to lift the trunk so that it is at least this high; it stands at 0.35 m and reaches 0.43 m.
fn rising_leg(height: &str) -> Problem {
    let goal = format!("[goal]\nregion = [{{ body = \"base\", z = [{height}, inf] }}]");
    let strong = Problem::weak_leg().urdf("effort=\"60\"", "effort=\"500\"");
    strong.sequence("[goal]", &goal)
}

#[test]
fn a_goal_that_is_too_high_is_told_what_can_be_reached() {
    let expected = Expected {
        phase: 1,
        group: "goal",
        subject: "base",
        range: 0.38..=0.43,
    };
    check(&rising_leg("0.6"), &expected, |problem, to| {
        problem.sequence("z = [0.6,", &format!("z = [{to},"))
    });
}

#[test]
fn a_phase_that_is_too_short_is_told_its_time() {
    let hurry = "[optimiser]\nmin_duration = 0.01\nmax_duration = 0.05\n\n[objective]";
    let problem = rising_leg("0.41").scene("[objective]", hurry);
    let expected = Expected {
        phase: 1,
        group: "duration",
        subject: "all phases",
        range: 0.06..=0.2,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene("max_duration = 0.05", &format!("max_duration = {to}"))
    });
}

#[test]
fn a_motion_that_does_not_hold_between_coarse_nodes_is_told_what_would_make_it_hold() {
    let hurry = "[optimiser]\nmin_duration = 0.1\nmax_duration = 0.3\n\n[objective]";
    let leg = rising_leg("0.42").urdf("effort=\"500\"", "effort=\"108\"");
    let problem = leg.scene("[objective]", hurry);
    let problem = problem.sequence("expect = ", "steps = 2\nexpect = ");
    assert!(problem.solve(false).feasible, "with two long steps");
    let expected = Expected {
        phase: 1,
        group: "goal",
        subject: "base",
        range: 0.36..=0.41,
    };
    check(&problem.clone().refined(), &expected, |problem, to| {
        problem.sequence("z = [0.42,", &format!("z = [{to},"))
    });
    let explanation = problem.refined().solve(true).explanation;
    let text = explanation.expect("an explanation").text;
    assert!(text.contains("that holds between coarse nodes"), "{text}");
    assert!(text.contains("raise the longest phase"), "{text}");
}

#[test]
fn an_object_that_nothing_touches_is_told_to_fall() {
    let ball = "[[object]]\nname = \"crate\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\non = \"ground_top\"\nposition = [2.0, 0.0]\n\n\
                [[object.interface]]\nname = \"crate_bottom\"\nside = \"-z\"\nlands = true\n\n[objective]";
    let resting = "label = \"stand\"\ncontacts = [[\"foot\", \"ground_top\"], [\"crate_bottom\", \"ground_top\"]]\n\n";
    let begin = format!("{resting}[[phase]]\nlabel = \"stand on\"");
    let problem = Problem::weak_leg().scene("[objective]", ball);
    let text = |problem: &Problem| {
        problem
            .solve(true)
            .explanation
            .expect("an explanation")
            .text
    };
    let falls = "nothing touches crate in phase 2";
    let forgotten = problem.clone().sequence("label = \"stand\"", &begin);
    assert!(text(&forgotten).contains(falls), "{}", text(&forgotten));
    let at_rest = problem.sequence(
        "label = \"stand\"\ncontacts = [[\"foot\", \"ground_top\"]]",
        &format!("{resting}[[phase]]\n{resting}"),
    );
    assert!(!text(&at_rest).contains("nothing touches"));
}

#[test]
fn contradicting_bounds_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let problem = Problem::weak_leg();
    let urdf = &problem.robot.as_ref().unwrap()[1];
    std::fs::write(folder.path().join("weak-leg.urdf"), urdf).unwrap();
    let mut scene = Scene::from_toml(&problem.scene, "scene.toml", folder.path()).unwrap();
    let sequence = &problem.sequence;
    let file = SequenceFile::from_toml(sequence, "sequence.toml", folder.path()).unwrap();
    let sequence = file.resolve(&scene).unwrap();
    // The scene file refuses this; a caller of the library can still ask for it.
    (scene.optimiser.min_duration, scene.optimiser.max_duration) = (2.0, 1.0);
    let request = Request {
        explain: true,
        ..Request::default()
    };
    let solved = solve(&scene, &sequence, &request, &mut |_| true).unwrap();
    assert_eq!(
        solved.motion.unwrap().status,
        locotamp::Status::Contradictory
    );
    let explanation = solved.explanation.unwrap();
    assert_eq!(explanation.stage, plan::FailedStage::Contradiction);
    let cause = &explanation.cause;
    assert_eq!(
        (cause.phase, cause.constraint.as_str()),
        (1, "phase duration")
    );
    assert_eq!((cause.amount, cause.unit.as_str()), (1.0, "s"));
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_slippery_box_is_told_its_friction() {
    let problem = Problem::new("slippery-box", "boxes/too_slippery");
    let expected = Expected {
        phase: 3,
        group: "friction",
        subject: "box_",
        range: 0.1..=0.25,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene("mu = 0.05", &format!("mu = {to}"))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_box_without_any_friction_is_told_its_friction() {
    let problem = Problem::new("slippery-box", "boxes/too_slippery").scene("mu = 0.05", "mu = 0.0");
    let expected = Expected {
        phase: 3,
        group: "friction",
        subject: "box_",
        range: 0.1..=0.25,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene("mu = 0.0\n", &format!("mu = {to}\n"))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_heavy_box_is_told_its_mass() {
    let problem = Problem::new("heavy-box", "boxes/too_heavy");
    let expected = Expected {
        phase: 3,
        group: "weight",
        subject: "box",
        range: 3.0..=6.9, // two palms of 60 N at 0.8 · 0.7 hold 6.9 kg
    };
    check(&problem, &expected, |problem, to| {
        problem.scene("mass = 12.0", &format!("mass = {to}"))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_box_that_is_too_wide_for_two_hands_is_told_its_width() {
    let size = |y: &str| format!("size = [0.10, {y}, 0.20]");
    let problem = Problem::new("lift-box", "boxes/squeeze").scene(&size("0.25"), &size("1.1"));
    let problem = problem.scene("size = [0.30, 0.60, 0.03]", "size = [0.30, 1.2, 0.03]");
    let expected = Expected {
        phase: 2,
        group: "geometry",
        subject: "_hand on box_",
        range: 0.3..=1.05,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene(&size("1.1"), &size(to))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_table_that_is_too_far_is_told_its_place() {
    let place = |y: &str| {
        format!("name = \"table_b\"\nsize = [0.34, 0.40, 0.04]\nposition = [0.45, {y}, 0.73]")
    };
    let problem =
        Problem::new("yardstick", "yardstick/fixed").scene(&place("-0.23"), &place("-1.6"));
    let expected = Expected {
        phase: 4,
        group: "geometry",
        subject: "red_box_bottom on table_b_top",
        range: -1.5..=-0.2,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene(&place("-1.6"), &place(to))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_table_that_is_too_high_is_told_its_height() {
    let place = |z: &str| {
        format!("name = \"table_b\"\nsize = [0.34, 0.40, 0.04]\nposition = [0.45, -0.23, {z}]")
    };
    let problem = Problem::new("yardstick", "yardstick/fixed").scene(&place("0.73"), &place("1.8"));
    let expected = Expected {
        phase: 4,
        group: "geometry",
        subject: "red_box_bottom on table_b_top",
        range: 0.7..=1.5,
    };
    check(&problem, &expected, |problem, to| {
        problem.scene(&place("1.8"), &place(to))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_stair_that_is_too_high_is_told_its_height() {
    let place = |z: &str| format!("position = [0.40, 0.20, {z}]");
    let problem = Problem::new("stairs", "stairs/up_one").scene(&place("0.05"), &place("0.95"));
    let expected = Expected {
        phase: 3,
        group: "geometry",
        subject: "left_foot on stair_1_top",
        range: 0.05..=0.85, // coarse motions step up to 0.88 m; those that refine up to about 0.75 m
    };
    check(&problem, &expected, |problem, to| {
        problem.scene(&place("0.95"), &place(to))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn feet_that_stay_are_told_how_far_the_base_can_lean() {
    let expected = Expected {
        phase: 2,
        group: "goal",
        subject: "base",
        range: 0.02..=0.4,
    };
    let problem = Problem::new("flat", "flat/no_swing");
    check(&problem, &expected, |problem, to| {
        problem.sequence("x = [1.0,", &format!("x = [{to},"))
    });
}

#[test]
#[ignore = "slow: up to a minute"]
fn a_weak_grasp_is_told_its_force_or_the_mass_it_can_hold() {
    let hands = "max_force = 60.0";
    let problem = Problem::new("yardstick", "yardstick/fixed").with_own_g1();
    let problem = problem
        .robot_file(hands, "max_force = 3.0")
        .scene("mass = 1.0", "mass = 1.00");
    let solved = problem.solve(true);
    let explanation = solved.explanation.expect("an explanation");
    let text = &explanation.text;
    assert_eq!(explanation.cause.phase, 3, "{text}");
    for remedy in &explanation.remedies {
        let to = remedy.to;
        let repaired = match remedy.quantity.as_str() {
            "largest force" => problem
                .clone()
                .robot_file("max_force = 3.0", &format!("max_force = {to:?}")),
            "mass" => problem
                .clone()
                .scene("mass = 1.00", &format!("mass = {to:?}")),
            _ => panic!("{text}"),
        };
        assert!(repaired.solve(false).feasible, "{text}");
    }
    let quantities = explanation.remedies.iter().map(|r| r.quantity.as_str());
    assert!(quantities.clone().any(|q| q == "largest force"), "{text}");
    assert!(quantities.clone().any(|q| q == "mass"), "{text}");
}
