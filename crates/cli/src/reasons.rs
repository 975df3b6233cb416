//! The most frequent reasons why sequences were given up.

use locotamp::{Attempt, Impossible, Reached, Refusal};
use std::collections::BTreeMap;

/// A reason and how often it decided.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reason {
    /// Number of sequences, or of what was refused before there were any.
    pub count: usize,
    /// How far they got, in words.
    pub stage: &'static str,
    /// What resisted, without the amount.
    pub what: String,
    /// One of them in full.
    pub example: String,
}

/// Reasons of all attempts that are no plan and of contacts that were refused, the most frequent first; amounts and phases
/// aside, equal reasons are one.
pub(crate) fn most_frequent(attempts: &[Attempt], impossible: &[Impossible]) -> Vec<Reason> {
    let mut groups: BTreeMap<(&str, &str), (usize, &str)> = BTreeMap::new();
    for attempt in attempts {
        let stage = match attempt.reached {
            Reached::Keyframes => "no keyframes",
            Reached::Alike => "left out",
            Reached::Optimised => "no motion",
            Reached::Coarse | Reached::Feasible => continue,
        };
        let example = attempt.reason.as_deref().unwrap_or("no reason known");
        let what = match attempt.reached {
            Reached::Alike => example.split(['(', ')']).nth(1).unwrap_or(example),
            _ => example.split(':').next().unwrap_or(example),
        };
        groups.entry((stage, what)).or_insert((0, example)).0 += 1;
    }
    let mut reasons: Vec<Reason> = groups
        .into_iter()
        .map(|((stage, what), (count, example))| Reason {
            count,
            stage,
            what: what.into(),
            example: example.into(),
        })
        .collect();
    reasons.extend(impossible.iter().map(|refusal| Reason {
        count: refusal.refused,
        stage: match refusal.what {
            Refusal::Contacts => "refused",
            Refusal::Lift => "too heavy",
            Refusal::Beginning => "beginnings refused",
        },
        what: refusal.contacts.join(", "),
        example: refusal.reason.clone(),
    }));
    reasons.sort_by_key(|reason| std::cmp::Reverse(reason.count));
    reasons
}

/// What is likely wrong where no sequence came as far as a motion and all beginnings fail at the alignment of contacts, unless other
/// refusals are as many.
pub(crate) fn remedy(attempts: &[Attempt], impossible: &[Impossible]) -> Option<String> {
    let moved = |a: &Attempt| matches!(a.reached, Reached::Optimised | Reached::Feasible);
    let (beginnings, others): (Vec<_>, Vec<_>) =
        (impossible.iter()).partition(|x| x.what == Refusal::Beginning);
    let aligned = beginnings
        .iter()
        .map(|x| x.contacts.first()?.strip_prefix(ALIGNMENT));
    let contacts: Vec<&str> = aligned.collect::<Option<_>>()?;
    let refused = |all: &[&Impossible]| all.iter().map(|x| x.refused).sum::<usize>();
    if attempts.iter().any(moved) || refused(&beginnings) <= refused(&others) {
        return None;
    }
    let interface = |c: &&str| c.split(" on ").next().unwrap_or(c).to_owned();
    let interfaces: Vec<String> = contacts.iter().map(interface).collect();
    Some(format!(
        "every beginning that was refused fails at the alignment of {}: do the z axes of {} and of what they touch point \
         outwards, from the body into the free? `pose` of an interface turns it",
        contacts.join(" or "),
        interfaces.join(", ")
    ))
}

/// How the reason of a contact begins whose normals do not meet.
const ALIGNMENT: &str = "contact alignment of ";

#[cfg(test)]
mod tests {
    use super::*;

    fn attempt(reached: Reached, reason: &str) -> Attempt {
        let reason = Some(reason.to_owned());
        Attempt {
            number: 1,
            labels: vec![],
            reached,
            reason,
            cost: None,
            iterations: 0,
            seconds: 0.0,
        }
    }

    fn refused_beginning(what: &str, refused: usize) -> Impossible {
        Impossible {
            what: Refusal::Beginning,
            contacts: vec![what.into()],
            reason: format!("{what}: 1.5 rad off"),
            refused,
        }
    }

    #[test]
    fn beginnings_that_all_fail_at_alignments_come_first_with_the_axis_as_remedy() {
        let left = refused_beginning("contact alignment of left_hand on box_handle", 593);
        let right = refused_beginning("contact alignment of right_hand on box_handle", 596);
        let refused = [left, right];
        let reasons = most_frequent(&[attempt(Reached::Keyframes, "too far")], &refused);
        assert_eq!(
            (reasons[0].count, reasons[0].stage),
            (596, "beginnings refused")
        );
        let remedy =
            |attempts: &[Attempt], refused: &[Impossible]| super::remedy(attempts, refused);
        let text = remedy(&[], &refused).expect("a remedy");
        assert!(
            text.contains("left_hand on box_handle or right_hand on box_handle"),
            "{text}"
        );
        assert!(text.contains("z axes of left_hand, right_hand"), "{text}");
        assert_eq!(
            remedy(&[attempt(Reached::Optimised, "torque")], &refused),
            None
        );
        let far = refused_beginning("contact distance of left_hand on box_handle", 1);
        assert_eq!(remedy(&[], &[far, refused[0].clone()]), None);
        assert_eq!(remedy(&[], &[]), None);
        let thumb = Impossible {
            what: Refusal::Contacts,
            ..refused_beginning("right_hand on box_left", 600)
        };
        assert!(
            remedy(
                &[],
                &[refused[0].clone(), refused[1].clone(), thumb.clone()]
            )
            .is_some()
        );
        assert_eq!(remedy(&[], &[refused[0].clone(), thumb]), None);
    }

    #[test]
    fn reasons_that_differ_by_amount_only_are_counted_together() {
        let attempts = [
            attempt(
                Reached::Keyframes,
                "bounds of left_foot on ground_top: 2.0e-1 m off, in phase 3",
            ),
            attempt(Reached::Feasible, "unused"),
            attempt(
                Reached::Alike,
                "sequences 1, 2 have no motion at the contacts of phase 3 (left_foot off stone)",
            ),
            attempt(
                Reached::Alike,
                "sequences 1, 2, 4 have no motion at the contacts of phase 5 (left_foot off stone)",
            ),
            attempt(
                Reached::Optimised,
                "torque of knee: 1.0e0 N·m off, in phase 1",
            ),
            attempt(
                Reached::Optimised,
                "torque of knee: 2.0e0 N·m off, in phase 2",
            ),
        ];
        let refused = Impossible {
            what: Refusal::Contacts,
            contacts: vec!["left_foot on moon".into()],
            reason: "too far".into(),
            refused: 3,
        };
        let mut reasons = most_frequent(&attempts, &[refused]);
        let first = reasons.remove(0);
        assert_eq!((first.count, first.example.as_str()), (3, "too far"));
        assert_eq!(reasons.len(), 3);
        let found: Vec<_> = reasons
            .iter()
            .map(|x| (x.count, x.stage, &*x.what))
            .collect();
        assert_eq!(found[0], (2, "left out", "left_foot off stone"));
        assert_eq!(found[1], (2, "no motion", "torque of knee"));
        assert_eq!(found[2].1, "no keyframes");
        assert_eq!(
            reasons[1].example,
            "torque of knee: 1.0e0 N·m off, in phase 1"
        );
    }
}
