//! What must hold at the end.

use crate::draft::Draft;
use crate::file::{
    GoalContactEntry, GoalEntry, ObjectiveEntry, ObjectiveKindEntry, RegionEntry, SceneFile,
};
use crate::robot::unknown_name;
use crate::source::At;
use crate::{Fault, GoalContact, Objective, RegionGoal, SceneError};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A shorter direction is taken for zero.
const SHORTEST_DIRECTION: f64 = 1e-9;

/// Smallest limit of a tilt [rad]: a limit of zero has no gradient.
const LEAST_TILT: f64 = 0.01;

/// Name of the robot's floating base in goal regions.
pub(crate) const BASE_NAME: &str = "base";

/// Goal and objective of a scene.
pub(crate) struct Goal {
    pub contacts: Vec<GoalContact>,
    pub regions: Vec<RegionGoal>,
    pub objective: Objective,
}

/// Reads `[goal]` and `[objective]`; at least one of them must ask for something.
pub(crate) fn goal(draft: &Draft, file: &SceneFile) -> Result<Goal, SceneError> {
    let entry = file.goal.as_deref();
    let objective = match &file.objective {
        Some(entry) => objective(draft, entry)?,
        None => Objective::Time,
    };
    let (contacts, regions) = match entry {
        Some(entry) => demands(draft, entry)?,
        None => (vec![], vec![]),
    };
    if contacts.is_empty() && regions.is_empty() && objective == Objective::Time {
        let (span, found) = match (&file.goal, &file.objective) {
            (Some(goal), _) => (goal.span(), "[goal] names neither a contact nor a region"),
            (None, Some(objective)) => (
                objective.kind.span(),
                "least time without a goal is reached by doing nothing",
            ),
            (None, None) => (file.name.span(), "it has neither [goal] nor [objective]"),
        };
        return Err(draft.source.fault(span, Fault::EmptyGoal { found }));
    }
    Ok(Goal {
        contacts,
        regions,
        objective,
    })
}

/// Contacts and regions of a `[goal]`; it may be empty.
pub(crate) fn demands(
    draft: &Draft,
    entry: &GoalEntry,
) -> Result<(Vec<GoalContact>, Vec<RegionGoal>), SceneError> {
    let mut regions: Vec<RegionGoal> = Vec::new();
    for given in &entry.region {
        let region = region_goal(draft, given)?;
        for other in regions.iter().filter(|other| other.body == region.body) {
            check_overlap(draft, given, (&region, other))?;
        }
        regions.push(region);
    }
    Ok((contacts(draft, entry)?, regions))
}

/// Two regions of one body have a place in common.
fn check_overlap(
    draft: &Draft,
    given: &At<RegionEntry>,
    (region, other): (&RegionGoal, &RegionGoal),
) -> Result<(), SceneError> {
    let axes = [("x", &given.x), ("y", &given.y), ("z", &given.z)];
    for (i, (name, axis)) in axes.into_iter().enumerate() {
        let Some(axis) = axis else { continue };
        let (lower, upper) = (other.lower[i], other.upper[i]);
        if region.lower[i] > upper || region.upper[i] < lower {
            let fault = Fault::Value {
                what: format!("{name} of goal region of {:?}", region.body),
                value: format!("{:?} m", **axis),
                expected: format!(
                    "something in common with [{lower}, {upper}] m, which another region demands of the same body"
                ),
            };
            return Err(draft.source.fault(axis.span(), fault));
        }
    }
    Ok(())
}

fn contacts(draft: &Draft, entry: &GoalEntry) -> Result<Vec<GoalContact>, SceneError> {
    let mut contacts: Vec<GoalContact> = Vec::new();
    for pair in &entry.contacts {
        let contact = goal_contact(draft, pair)?;
        if let Some(other) = contacts
            .iter()
            .find(|c| c.a == contact.a && c.b != contact.b)
        {
            let name = |id: symbolic::InterfaceId| draft.interfaces[id.0].name.clone();
            let fault = Fault::Impossible {
                a: name(contact.a),
                b: name(contact.b),
                reason: format!("it is to land on {:?} as well", name(other.b)),
                remedy: "demand one of the two".to_owned(),
            };
            return Err(draft.source.fault(pair.span(), fault));
        }
        if !contacts.contains(&contact) {
            contacts.push(contact);
        }
    }
    Ok(contacts)
}

fn goal_contact(draft: &Draft, pair: &At<GoalContactEntry>) -> Result<GoalContact, SceneError> {
    let [first, second] = pair.0.as_slice() else {
        let problem = "expected a pair [interface, interface]";
        return Err(draft.source.bad_keys(pair.span(), "goal contact", problem));
    };
    let ids = (
        draft.interface(first, "goal contact")?,
        draft.interface(second, "goal contact")?,
    );
    let (a, b, _) = draft.landing_pair(pair.span(), ids, None)?;
    Ok(GoalContact { a, b })
}

/// The objective; only "reach" has a body and a direction.
fn objective(draft: &Draft, entry: &ObjectiveEntry) -> Result<Objective, SceneError> {
    let plain = match *entry.kind {
        ObjectiveKindEntry::Time => Objective::Time,
        ObjectiveKindEntry::BaseHeight => Objective::BaseHeight,
        ObjectiveKindEntry::Reach => return reach(draft, entry),
    };
    let body = entry.body.as_ref().map(At::span);
    let unused = body.or_else(|| entry.direction.as_ref().map(At::span));
    unused.map_or(Ok(plain), |span| {
        let problem = "body and direction go with kind = \"reach\" only";
        Err(draft.source.bad_keys(span, "objective", problem))
    })
}

fn reach(draft: &Draft, entry: &ObjectiveEntry) -> Result<Objective, SceneError> {
    let (Some(body), Some(given)) = (&entry.body, &entry.direction) else {
        let problem = "kind = \"reach\" needs body = \"…\" and direction = [x, y, z]";
        return Err(draft
            .source
            .bad_keys(entry.kind.span(), "objective", problem));
    };
    check_body(draft, body, "objective")?;
    let direction = draft.source.point("direction of the objective", given)?;
    let direction = direction.try_normalize(SHORTEST_DIRECTION).ok_or_else(|| {
        let fault = Fault::Value {
            what: "direction of the objective".to_owned(),
            value: format!("{:?}", **given),
            expected: "three numbers that are not all zero".to_owned(),
        };
        draft.source.fault(given.span(), fault)
    })?;
    Ok(Objective::Reach {
        body: (**body).clone(),
        direction,
    })
}

/// The body of a region or an objective can move and has a place in the world.
fn check_body(draft: &Draft, body: &At<String>, user: &str) -> Result<(), SceneError> {
    let objects = draft.objects.iter().map(|object| object.name.as_str());
    let interfaces = draft.interfaces.iter();
    let movable = interfaces.filter(|i| !matches!(i.owner, crate::Owner::Static(_)));
    let frames = draft.robot.model.frames.iter();
    let names: Vec<&str> = [BASE_NAME]
        .into_iter()
        .chain(objects)
        .chain(movable.map(|interface| interface.name.as_str()))
        .chain(frames.map(|frame| frame.name.as_str()))
        .collect();
    if names.contains(&body.as_str()) {
        return Ok(());
    }
    let kind = "object, robot link or interface that can move";
    Err(unknown_name(
        draft.source,
        body,
        user,
        kind,
        names.into_iter(),
    ))
}

fn region_goal(draft: &Draft, region: &At<RegionEntry>) -> Result<RegionGoal, SceneError> {
    let what = format!("goal region of {:?}", *region.body);
    check_body(draft, &region.body, "goal region")?;
    let mut lower = Vector3::repeat(f64::NEG_INFINITY);
    let mut upper = Vector3::repeat(f64::INFINITY);
    let axes = [&region.x, &region.y, &region.z];
    if axes.iter().all(|axis| axis.is_none()) && region.yaw.is_none() && region.tilt.is_none() {
        let problem = "expected at least one of x, y, z, yaw, each [smallest, largest], or tilt";
        return Err(draft.source.bad_keys(region.span(), &what, problem));
    }
    for (i, axis) in axes.into_iter().enumerate() {
        let Some(axis) = axis else { continue };
        let [from, to] = **axis;
        // also false for NaN
        let is_range = from <= to && from < f64::INFINITY && to > f64::NEG_INFINITY;
        if !is_range {
            let fault = Fault::Value {
                what: what.clone(),
                value: format!("{:?}", **axis),
                expected: "[smallest, largest] with smallest ≤ largest; -inf and inf are allowed"
                    .to_owned(),
            };
            return Err(draft.source.fault(axis.span(), fault));
        }
        (lower[i], upper[i]) = (from, to);
    }
    Ok(RegionGoal {
        body: (*region.body).clone(),
        lower,
        upper,
        yaw: region
            .yaw
            .as_ref()
            .map(|yaw| heading(draft, &what, yaw))
            .transpose()?,
        tilt: region
            .tilt
            .as_ref()
            .map(|tilt| largest_tilt(draft, &what, tilt))
            .transpose()?,
    })
}

fn heading(draft: &Draft, what: &str, yaw: &At<[f64; 2]>) -> Result<[f64; 2], SceneError> {
    let [from, to] = **yaw;
    // also false for NaN and infinities
    if from <= to && to - from < TAU {
        return Ok([from, to]);
    }
    let fault = Fault::Value {
        what: format!("yaw of {what}"),
        value: format!("{:?} rad", **yaw),
        expected:
            "[smallest, largest] with smallest ≤ largest, less than a full turn of 2π rad apart"
                .to_owned(),
    };
    Err(draft.source.fault(yaw.span(), fault))
}

fn largest_tilt(draft: &Draft, what: &str, tilt: &At<f64>) -> Result<f64, SceneError> {
    if (LEAST_TILT..=FRAC_PI_2).contains(&**tilt) {
        return Ok(**tilt);
    }
    let fault = Fault::Value {
        what: format!("tilt of {what}"),
        value: format!("{} rad", **tilt),
        expected: format!("a number from {LEAST_TILT} to π/2"),
    };
    Err(draft.source.fault(tilt.span(), fault))
}
