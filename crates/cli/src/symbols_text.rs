//! The symbolic problem of a scene for people.

use crate::symbols_command::{BODIES, SHOWN_SKELETONS, Symbols, bodies, owner, role, rounded};
use std::fmt::Write;
use symbolic::Contact;
use symbolic::statistics::Count;

/// Interfaces, contacts, limits, what the rules leave, skeletons.
pub(crate) fn write(symbols: &Symbols) -> String {
    let mut text = String::new();
    interfaces(symbols, &mut text);
    contacts(symbols, &mut text);
    limits(symbols, &mut text);
    rules(symbols, &mut text);
    skeletons(symbols, &mut text);
    text
}

fn interfaces(symbols: &Symbols, text: &mut String) {
    let all = symbols.domain().interfaces();
    let _ = writeln!(text, "{} interfaces", all.len());
    let width = |of: &dyn Fn(usize) -> usize| (0..all.len()).map(of).max().unwrap_or(0);
    let name = width(&|n| all[n].name.chars().count());
    let body = width(&|n| owner(&symbols.scene, &all[n]).chars().count());
    for interface in all {
        let types: Vec<&str> = interface
            .contact_types
            .iter()
            .map(|kind| kind.name())
            .collect();
        let _ = writeln!(
            text,
            "  {:name$}  {:body$}  {:15}  {}  {}",
            interface.name,
            owner(&symbols.scene, interface),
            role(interface),
            if interface.patch { "patch" } else { "point" },
            types.join(", ")
        );
    }
}

/// Grouped by what they join, one line per landing side and type.
fn contacts(symbols: &Symbols, text: &mut String) {
    let domain = symbols.domain();
    let all = domain.contacts();
    let _ = writeln!(text, "\n{} possible contacts", all.len());
    for kind in BODIES {
        let group: Vec<&Contact> = all.iter().filter(|c| bodies(domain, c) == kind).collect();
        if group.is_empty() {
            let _ = writeln!(text, "  {kind}: none");
            continue;
        }
        let _ = writeln!(text, "  {kind}: {}", group.len());
        let mut lines: Vec<(&Contact, Vec<&str>)> = Vec::new();
        for contact in group {
            let partner = domain.interface(contact.b).name.as_str();
            let same = |(c, _): &&mut (&Contact, _)| (c.a, c.kind) == (contact.a, contact.kind);
            match lines.iter_mut().find(same) {
                Some((_, partners)) => partners.push(partner),
                None => lines.push((contact, vec![partner])),
            }
        }
        for (contact, partners) in lines {
            let name = &domain.interface(contact.a).name;
            let _ = writeln!(
                text,
                "    {name} ({}): {}",
                contact.kind.name(),
                partners.join(", ")
            );
        }
    }
}

fn limits(symbols: &Symbols, text: &mut String) {
    let (search, optimiser) = (&symbols.scene.search, &symbols.scene.optimiser);
    let from = |given: bool| if given { "given" } else { "from the scene" };
    let n = symbols.graph.skeletons().max_actions();
    let _ = writeln!(text, "\nlimits");
    let _ = writeln!(
        text,
        "  phases (K_max)             {:>6}  {}",
        symbols.max_phases,
        from(search.max_phases.is_some())
    );
    let _ = writeln!(
        text,
        "  skeleton actions (N_PDDL)  {n:>6}  {}",
        from(search.max_skeleton.is_some())
    );
    let _ = writeln!(
        text,
        "  duration of a phase        {} to {} s",
        rounded(optimiser.min_duration),
        rounded(optimiser.max_duration)
    );
    let hands = if search.support_hands {
        "support"
    } else {
        "only grasp"
    };
    let _ = writeln!(
        text,
        "  changes of free interfaces {:>6}  per action; hands {hands}{}",
        search.max_changes,
        if search.flights { "" } else { "; no flights" }
    );
}

fn rules(symbols: &Symbols, text: &mut String) {
    let _ = writeln!(
        text,
        "\n{:>9}  {:>12}  {:>12}  after the rule",
        "contacts", "states", "transitions"
    );
    let number = |count: Option<Count>| count.map_or_else(|| "?".into(), |c| c.to_string());
    for row in &symbols.rules {
        let (states, transitions) = (number(row.states), number(row.transitions));
        let _ = writeln!(
            text,
            "{:>9}  {states:>12}  {transitions:>12}  {}",
            row.contacts, row.rule
        );
    }
    let contacts = symbols.domain().contacts().len();
    let (states, transitions) = match symbols.along_skeletons {
        Some(count) => (count.states.to_string(), count.transitions.to_string()),
        None => ("many".to_owned(), "many".to_owned()),
    };
    let _ = writeln!(
        text,
        "{contacts:>9}  {states:>12}  {transitions:>12}  along skeletons from the start"
    );
}

fn skeletons(symbols: &Symbols, text: &mut String) {
    let total: usize = symbols.lengths.iter().map(|(_, count)| count).sum();
    let n = symbols.graph.skeletons().max_actions();
    let more = if symbols.all_counted {
        ""
    } else {
        "more than "
    };
    let _ = writeln!(text, "\n{more}{total} skeletons of at most {n} actions");
    for lift in &symbols.too_heavy {
        let _ = writeln!(text, "  none with a lift where {}", lift.reason);
    }
    if total == 0 {
        let _ = writeln!(text, "  no sequence of actions reaches the goal");
        return;
    }
    for (length, count) in &symbols.lengths {
        let _ = writeln!(text, "  {count:>9} of {length}");
    }
    for labels in &symbols.first {
        let words = if labels.is_empty() {
            "nothing to do".to_owned()
        } else {
            labels.join(", ")
        };
        let _ = writeln!(text, "  {words}");
    }
    if total > SHOWN_SKELETONS {
        let _ = writeln!(text, "  …");
    }
}
