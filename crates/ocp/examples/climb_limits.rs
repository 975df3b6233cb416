//! How high the G1 gets onto a platform, with its actuation limits and without (benches/runs/2026-11-21-climb-limits.md).
//!
//! A platform before the robot, several contact sequences, several starts. Each begins on a low platform, which is then raised
//! in steps, every motion starting from the last one, else from nothing, until 5 cm more have none. The same goes on without
//! limits from where the limits ended it. One line per sequence and start goes to the file that is named; lines that are there
//! are not computed again.
//!
//! `cargo run --release -p ocp --example climb_limits -- FILE [SEQUENCES] [STARTS] [SECONDS]`

use ocp::{Motion, Phase, Planner, Preset, Settings};
use scene::{Scene, SequenceFile};
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

/// Intervals per phase, iterations of one solve; of sequences with a flight.
const EFFORT: (usize, usize) = (8, 120);
const FLIGHT_EFFORT: (usize, usize) = (12, 250);
/// Heights of which the first that works is taken, first and last step by which the platform rises, and where it ends [m].
const FIRST: [f64; 4] = [0.6, 0.45, 0.3, 0.15];
const FLIGHT_FIRST: [f64; 2] = [0.2, 0.1];
/// Heights that are tried from nothing too.
const TRIED: [f64; 3] = [0.80, 0.85, 0.90];
const FIRST_STEP: f64 = 0.1;
const LAST_STEP: f64 = 0.05;
const HIGHEST: f64 = 1.3;

/// Feet "l" and "r", hands "L" and "R"; lower level "g", platform "p". One word per phase.
const SEQUENCES: [(&str, &str); 9] = [
    ("step-left", "lg,rg rg lp,rg lp lp,rp"),
    ("step-right", "lg,rg lg lg,rp rp lp,rp"),
    (
        "step-hands",
        "lg,rg lg,rg,Lp,Rp rg,Lp,Rp lp,rg,Lp,Rp lp,Lp,Rp lp,rp,Lp,Rp lp,rp",
    ),
    (
        "step-hand",
        "lg,rg lg,rg,Lp rg,Lp lp,rg,Lp lp,Lp lp,rp,Lp lp,rp",
    ),
    ("jump", "lg,rg lg,rg 0 lp,rp lp,rp"),
    ("jump-one-foot", "lg,rg rg rg 0 lp lp,rp"),
    ("jump-left-right", "lg,rg lg,rg 0 lp lp,rp"),
    (
        "jump-hands",
        "lg,rg lg,rg,Lp,Rp lg,rg,Lp,Rp Lp,Rp lp,rp,Lp,Rp lp,rp",
    ),
    ("jump-then-hands", "lg,rg lg,rg 0 Lp,Rp lp,rp,Lp,Rp lp,rp"),
];

/// Where and how the robot stands before the platform.
struct Start {
    /// From the toes to the platform [m].
    gap: f64,
    /// Turn of the robot [rad].
    yaw: f64,
    /// To the side [m].
    aside: f64,
    /// Pitch of the shoulders and elbows [rad].
    arms: [f64; 2],
}

fn start(number: usize) -> Start {
    let gaps = [0.2, 0.3, 0.25, 0.4, 0.15];
    let yaws = [0.0, 0.15, -0.15, 0.3];
    let arms = [[0.6, -0.1], [0.2, 0.6], [-0.4, 0.3]];
    let asides = [0.0, 0.08, -0.08];
    Start {
        gap: gaps[number % 5],
        yaw: yaws[(number / 5 + number) % 4],
        aside: asides[(number / 2) % 3],
        arms: arms[(number / 3 + number) % 3],
    }
}

fn scene(start: &Start, height: f64) -> Scene {
    // The front edge of the soles is 0.097 m before the base.
    let edge = 0.097 + start.gap;
    let [shoulder, elbow] = start.arms;
    let text = format!(
        "name = \"climb\"\nrobot = \"g1\"\n[start]\nposition = [0, {}]\nyaw = {}\n[start.joints]\n\
         left_shoulder_pitch_joint = {shoulder}\nright_shoulder_pitch_joint = {shoulder}\n\
         left_elbow_joint = {elbow}\nright_elbow_joint = {elbow}\n\
         [[static]]\nname = \"ground\"\nplane = true\n\
         [[static]]\nname = \"platform\"\nsize = [1.0, 1.4, {height}]\nposition = [{}, 0, {}]\n\
         [goal]\ncontacts = [[\"left_foot\", \"platform_top\"], [\"right_foot\", \"platform_top\"]]\n",
        start.aside,
        start.yaw,
        edge + 0.5,
        0.5 * height,
    );
    Scene::from_toml(&text, "climb", Path::new(".")).expect("the scene is valid")
}

fn flies(words: &str) -> bool {
    words.split(' ').any(|word| word == "0")
}

fn effort(words: &str) -> (usize, usize) {
    if flies(words) { FLIGHT_EFFORT } else { EFFORT }
}

fn phases(words: &str, scene: &Scene) -> Vec<Phase> {
    let mut text = String::from("[goal]\n");
    for word in words.split(' ') {
        let contacts = word.split(',').filter_map(|pair| {
            let mut letters = pair.chars();
            let end = match letters.next()? {
                'l' => "left_foot",
                'r' => "right_foot",
                'L' => "left_hand",
                'R' => "right_hand",
                _ => return None,
            };
            let on = if letters.next()? == 'g' {
                "ground_top"
            } else {
                "platform_top"
            };
            Some(format!("[\"{end}\", \"{on}\", \"unilateral_patch\"]"))
        });
        let contacts: Vec<_> = contacts.collect();
        let _ = writeln!(text, "[[phase]]\ncontacts = [{}]", contacts.join(", "));
    }
    let file = SequenceFile::from_toml(&text, "sequence", Path::new(".")).expect("well formed");
    let sequence = file.resolve(scene).expect("the sequence fits the scene");
    let states = sequence.phases.into_iter().map(|phase| phase.state);
    states
        .map(|state| Phase {
            state,
            steps: effort(words).0,
        })
        .collect()
}

/// Solves of one sequence from one start.
struct Climb<'a> {
    words: &'a str,
    start: &'a Start,
    begin: Instant,
    seconds: f64,
    solves: usize,
    /// What resisted in the last solve that failed.
    resists: String,
}

impl Climb<'_> {
    /// The motion onto a platform, near one onto a lower platform or from nothing; `None` if there is none.
    fn solve(&mut self, height: f64, limits: bool, near: Option<&Motion>) -> Option<Motion> {
        self.solves += 1;
        let mut scene = scene(self.start, height);
        scene.optimiser.torque_limits = limits;
        scene.optimiser.max_iterations = effort(self.words).1;
        let phases = phases(self.words, &scene);
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let planner = Planner::new(&scene).expect("the robot is a model");
        let (begin, most) = (self.begin, self.seconds);
        let mut go_on = |_: &solver::Iteration| begin.elapsed().as_secs_f64() < most;
        let motion = if let Some(near) = near {
            planner.motion_near(&phases, &settings, near, &mut go_on)
        } else {
            let keyframes = planner.keyframes(&phases, &settings);
            if !keyframes.possible {
                let worst = keyframes.worst.map(|w| w.label.category);
                self.resists = format!("keyframes: {}", worst.unwrap_or("no convergence"));
                return None;
            }
            planner.motion(&phases, &settings, &keyframes.nodes, &mut go_on)
        };
        if motion.feasible {
            return Some(motion);
        }
        let name = |w: &ocp::Worst| match w.label.subject {
            ocp::Subject::Coordinate(v) => {
                let joints = &scene.robot.model.joints;
                let joint = joints.iter().find(|j| j.idx_v == v && v >= 6);
                let joint = joint.map_or("base", |j| j.name.as_str());
                format!("{} of {joint}", w.label.category)
            }
            _ => w.label.category.to_owned(),
        };
        let [worst, hardest] = [&motion.worst, &motion.hardest].map(|w| w.as_ref().map(name));
        let (worst, hardest) = (worst.unwrap_or_default(), hardest.unwrap_or_default());
        self.resists = format!("{worst} against {hardest}");
        None
    }

    /// Raises the platform from `height` with a motion known there.
    fn raise(&mut self, mut height: f64, mut motion: Motion, limits: bool) -> (f64, Motion) {
        let mut step = FIRST_STEP;
        while step > LAST_STEP - 1e-9 && self.begin.elapsed().as_secs_f64() < self.seconds {
            let next = height + step;
            let found = if next > HIGHEST {
                None
            } else {
                let near = self.solve(next, limits, Some(&motion));
                near.or_else(|| self.solve(next, limits, None))
            };
            match found {
                Some(found) => (height, motion) = (next, found),
                None => step *= 0.5,
            }
        }
        (height, motion)
    }
}

impl Climb<'_> {
    /// Goes on from heights above what was reached that have a motion from nothing.
    fn try_from_nothing(
        &mut self,
        mut reached: Option<(f64, Motion)>,
        limits: bool,
    ) -> Option<(f64, Motion)> {
        for height in TRIED.into_iter().filter(|_| !flies(self.words)) {
            if reached.as_ref().is_some_and(|(known, _)| *known >= height) {
                continue;
            }
            if let Some(motion) = self.solve(height, limits, None) {
                reached = Some(self.raise(height, motion, limits));
            }
        }
        reached
    }
}

/// The largest torques over their limits, by joint, the largest first.
fn loads(motion: &mut Motion) -> String {
    let point = motion.point.clone();
    let n = motion.trajectory.program.n_intervals();
    let joints = motion.trajectory.program.system.actuated();
    let mut most: Vec<(f64, String)> = joints.map(|j| (0.0, j.name.clone())).collect();
    for t in 0..n {
        let shares = motion.trajectory.torque_shares(&point, t, false);
        for ((most, _), share) in most.iter_mut().zip(shares) {
            *most = most.max(share);
        }
    }
    most.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = most.iter().take(3);
    let words: Vec<_> = most
        .map(|(share, joint)| format!("{joint} {share:.2}"))
        .collect();
    words.join(" ")
}

/// One line of the record.
fn line(name: &str, words: &str, number: usize, seconds: f64) -> String {
    let start = start(number);
    let mut climb = Climb {
        words,
        start: &start,
        begin: Instant::now(),
        seconds,
        solves: 0,
        resists: String::new(),
    };
    let mut out = format!(
        "{name};{number};{};{};{}",
        start.gap, start.yaw, start.aside
    );
    let heights = if flies(words) {
        &FLIGHT_FIRST[..]
    } else {
        &FIRST[..]
    };
    let first = heights.iter().find_map(|&height| {
        let motion = climb.solve(height, true, None)?;
        Some((height, motion))
    });
    let limited = first.map(|(height, motion)| climb.raise(height, motion, true));
    let limited = climb.try_from_nothing(limited, true);
    match &limited {
        Some((height, _)) => write!(out, ";{height:.3};{}", climb.resists),
        None => write!(out, ";0;{}", climb.resists),
    }
    .expect("a text takes everything");
    climb.seconds += seconds;
    let lowest = heights[heights.len() - 1];
    let first = limited.or_else(|| Some((lowest, climb.solve(lowest, false, None)?)));
    let free = first.map(|(height, motion)| climb.raise(height, motion, false));
    match climb.try_from_nothing(free, false) {
        Some((height, mut motion)) => {
            let loads = loads(&mut motion);
            write!(out, ";{height:.3};{};{loads}", climb.resists)
        }
        None => write!(out, ";0;{};", climb.resists),
    }
    .expect("a text takes everything");
    let seconds = climb.begin.elapsed().as_secs_f64();
    format!("{out};{};{seconds:.0}\n", climb.solves)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(file) = arguments.first() else {
        eprintln!("name the file for the record");
        std::process::exit(2);
    };
    let number = |i: usize, default: usize| {
        let text = arguments.get(i).map(|a| a.parse().expect("a number"));
        text.unwrap_or(default)
    };
    let wanted = arguments.get(1).map_or("", String::as_str);
    let (starts, seconds) = (number(2, 20), number(3, 60) as f64);
    let known = fs::read_to_string(file).unwrap_or_default();
    let mut record = fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(file)
        .expect("the record can be written");
    for start in 0..starts {
        for (name, words) in SEQUENCES {
            let is_wanted = wanted.is_empty() || wanted.split(',').any(|w| w == name);
            let is_known = known
                .lines()
                .any(|l| l.starts_with(&format!("{name};{start};")));
            if is_wanted && !is_known {
                let line = line(name, words, start, seconds);
                print!("{line}");
                record
                    .write_all(line.as_bytes())
                    .expect("the record can be written");
            }
        }
    }
}
