//! Small domains that the tests share.

use symbolic::{Contact, ContactState, ContactType, Domain, Interface, InterfaceId, Owner, Role};

/// An interface by name with one contact type or more.
pub fn interface(name: &str, owner: Owner, role: Role, kinds: &[ContactType]) -> Interface {
    let patch = kinds.iter().any(|kind| kind.is_patch());
    Interface {
        name: name.to_owned(),
        owner,
        role,
        patch,
        lands: false,
        bears_feet: true,
        contact_types: kinds.to_vec(),
    }
}

/// An object's surface on which it can rest.
pub fn bottom(name: &str, object: usize) -> Interface {
    Interface {
        lands: true,
        ..interface(
            name,
            Owner::Object(object),
            Role::Surface,
            &[ContactType::UnilateralPatch],
        )
    }
}

/// A table top, the ground, or the top or side of an object.
pub fn surface(name: &str, owner: Owner) -> Interface {
    interface(name, owner, Role::Surface, &[ContactType::UnilateralPatch])
}

/// Two feet and two hands that can also grasp.
pub fn robot() -> Vec<Interface> {
    let hand = [ContactType::UnilateralPatch, ContactType::BilateralPatch];
    vec![
        interface(
            "left_foot",
            Owner::Robot,
            Role::Foot,
            &[ContactType::UnilateralPatch],
        ),
        interface(
            "right_foot",
            Owner::Robot,
            Role::Foot,
            &[ContactType::UnilateralPatch],
        ),
        interface("left_hand", Owner::Robot, Role::Hand, &hand),
        interface("right_hand", Owner::Robot, Role::Hand, &hand),
    ]
}

/// A handle that one hand holds.
pub fn handle(name: &str, object: usize) -> Interface {
    interface(
        name,
        Owner::Object(object),
        Role::Surface,
        &[ContactType::BilateralPatch],
    )
}

/// Robot, ground, tables `a`, `b`, …, and the red box with bottom and handle.
pub fn one_box(n_tables: usize) -> Domain {
    let mut interfaces = robot();
    interfaces.push(bottom("red_box_bottom", 0));
    interfaces.push(handle("red_box_handle", 0));
    interfaces.extend(statics(n_tables));
    Domain::new(interfaces, vec!["red_box".to_owned()], vec![]).expect("the domain is valid")
}

/// As [`one_box`] with a green box, which two hands squeeze.
pub fn two_boxes(n_tables: usize) -> Domain {
    let mut interfaces = robot();
    interfaces.push(bottom("red_box_bottom", 0));
    interfaces.push(handle("red_box_handle", 0));
    interfaces.push(bottom("green_box_bottom", 1));
    interfaces.push(surface("green_box_left", Owner::Object(1)));
    interfaces.push(surface("green_box_right", Owner::Object(1)));
    interfaces.extend(statics(n_tables));
    let objects = vec!["red_box".to_owned(), "green_box".to_owned()];
    Domain::new(interfaces, objects, vec![(InterfaceId(7), InterfaceId(8))])
        .expect("the domain is valid")
}

fn statics(n_tables: usize) -> Vec<Interface> {
    let tables = ('a'..).take(n_tables).enumerate();
    let mut statics = vec![surface("ground_top", Owner::Static(0))];
    statics.extend(
        tables.map(|(n, letter)| surface(&format!("table_{letter}_top"), Owner::Static(n + 1))),
    );
    statics
}

/// The interface of that name.
pub fn id(domain: &Domain, name: &str) -> InterfaceId {
    domain
        .find(name)
        .unwrap_or_else(|| panic!("no interface {name}"))
}

/// The contact `a on b`, or `a holds b` if the pair supports only that.
pub fn contact(domain: &Domain, a: &str, b: &str) -> Contact {
    let (a, b) = (id(domain, a), id(domain, b));
    *domain
        .landings(a)
        .iter()
        .find(|contact| contact.b == b)
        .expect("the pair can touch")
}

/// The state with these contacts, `a on b` separated by commas.
pub fn state(domain: &Domain, contacts: &str) -> ContactState {
    let parse = |text: &str| {
        let (a, b) = text.trim().split_once(" on ").expect("`a on b`");
        contact(domain, a, b)
    };
    contacts
        .split(',')
        .filter(|text| !text.trim().is_empty())
        .map(parse)
        .collect()
}

/// Both feet on the ground and each box on its table.
pub fn standing(domain: &Domain, rests: &str) -> ContactState {
    state(
        domain,
        &format!("left_foot on ground_top, right_foot on ground_top, {rests}"),
    )
}
