//! Hostile plans are judged, never a cause of panic: values replaced, rows cut, robot descriptions broken.

use check::{Options, check};
use plan::Plan;
use serde_json::{Value, json};
use spatial::Random;

use crate::toy::{lift, stand};

/// Judges the text if it is a plan at all; tells if it was and passed.
fn survives(text: &str) -> Option<bool> {
    let plan = Plan::from_json(text).ok()?;
    let report = check(&plan, &Options::default());
    // Both forms of the report must cope with whatever stands in it.
    assert!(!report.to_string().is_empty());
    assert!(serde_json::to_string(&report).is_ok());
    Some(report.ok())
}

fn as_json(plan: &Plan) -> Value {
    serde_json::from_str(&plan.to_json().unwrap()).unwrap()
}

/// Places of all values; of long lists only some.
fn places(value: &Value, at: &str, random: &mut Random, found: &mut Vec<String>) {
    found.push(at.to_owned());
    match value {
        Value::Object(map) => map
            .iter()
            .for_each(|(key, x)| places(x, &format!("{at}/{key}"), random, found)),
        Value::Array(items) => {
            for (i, x) in items.iter().enumerate() {
                if items.len() < 8 || random.uniform(0.0, 1.0) < 0.1 {
                    places(x, &format!("{at}/{i}"), random, found);
                }
            }
        }
        _ => {}
    }
}

/// Values that no plan should have.
fn absurd() -> Vec<Value> {
    vec![
        json!(null),
        json!(0),
        json!(-1),
        json!(1e-320),
        json!(1e9),
        json!(1e200),
        json!(-1.7e308),
        json!(u64::MAX),
        json!("\u{0}"),
        json!([]),
        json!([[]]),
        json!({}),
        json!(true),
    ]
}

#[test]
fn any_value_replaced_by_an_absurd_one() {
    let mut random = Random::new(1);
    let mut judged = 0;
    for plan in [stand(), lift()] {
        let value = as_json(&plan);
        let mut all = Vec::new();
        places(&value, "", &mut random, &mut all);
        for place in all {
            let absurd = absurd();
            for _ in 0..3 {
                let mut spoiled = value.clone();
                *spoiled.pointer_mut(&place).unwrap() = absurd[random.index(absurd.len())].clone();
                judged += usize::from(survives(&spoiled.to_string()).is_some());
            }
        }
    }
    assert!(judged > 300, "{judged}");
}

#[test]
fn all_numbers_of_an_array_made_absurd() {
    let arrays = [
        "/q",
        "/v",
        "/a",
        "/h",
        "/tau",
        "/time",
        "/object_states",
        "/interfaces",
        "/environment",
        "/objects",
        "/phases",
    ];
    for array in arrays {
        for factor in [0.0, -1.0, 1e-300, 1e12, 1e160, 1e308, f64::MAX] {
            let mut value = as_json(&lift());
            scale(value.pointer_mut(array).unwrap(), factor);
            if let Some(passed) = survives(&value.to_string()) {
                assert!(
                    !passed || factor == -1.0 || factor == 0.0,
                    "{array} times {factor} passes"
                );
            }
        }
    }
}

fn scale(value: &mut Value, factor: f64) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|x| scale(x, factor)),
        Value::Object(map) => map.values_mut().for_each(|x| scale(x, factor)),
        Value::Number(number) if number.is_f64() => {
            let scaled = number.as_f64().unwrap() * factor;
            *value = json!(scaled.clamp(f64::MIN, f64::MAX));
        }
        _ => {}
    }
}

#[test]
fn rows_lost_and_doubled() {
    let mut random = Random::new(2);
    let value = as_json(&lift());
    let mut all = Vec::new();
    places(&value, "", &mut random, &mut all);
    for place in all {
        let mut spoiled = value.clone();
        let Some(Value::Array(items)) = spoiled.pointer_mut(&place) else {
            continue;
        };
        match (random.index(3), items.len()) {
            (0, 1..) => drop(items.pop()),
            (1, 1..) => items.push(items[0].clone()),
            _ => items.clear(),
        }
        survives(&spoiled.to_string());
    }
}

#[test]
fn robot_descriptions_broken_anywhere() {
    let mut random = Random::new(3);
    let plan = stand();
    let pieces: Vec<&str> = vec![
        "<",
        ">",
        "/>",
        "</link>",
        "<link name=\"arm\">",
        "\"",
        "nan",
        "inf",
        "-",
        "1e308",
        "<joint>",
        "fixed",
        "floating",
        "planar",
        "continuous",
        "base",
        "world",
        "<!--",
        "]]>",
        "&#0;",
        "\u{FEFF}",
        "<capsule radius=\"-1\" length=\"nan\"/>",
    ];
    for _ in 0..3000 {
        let mut spoiled = plan.clone();
        let text = &mut spoiled.robot.urdf;
        for _ in 0..=random.index(3) {
            let place = |random: &mut Random, text: &str| {
                let at = random.index(text.len() + 1);
                (0..=at)
                    .rev()
                    .find(|i| text.is_char_boundary(*i))
                    .unwrap_or(0)
            };
            let (from, to) = (place(&mut random, text), place(&mut random, text));
            let (from, to) = (from.min(to), from.max(to));
            match random.index(4) {
                0 => text.insert_str(from, pieces[random.index(pieces.len())]),
                1 => {
                    let end = (from..=to.min(from + 12))
                        .rev()
                        .find(|i| text.is_char_boundary(*i));
                    text.replace_range(from..end.unwrap_or(from), "");
                }
                2 => replace_number(text, from, pieces[random.index(pieces.len())]),
                _ => {
                    let copy = text[from..to].to_owned();
                    text.insert_str(from, &copy);
                }
            }
        }
        let report = check(&spoiled, &Options::default());
        assert!(!report.rows.is_empty());
    }
}

/// Replaces the first quoted value after `from`.
fn replace_number(text: &mut String, from: usize, by: &str) {
    let Some(open) = text[from..].find("=\"").map(|i| from + i + 2) else {
        return;
    };
    let Some(close) = text[open..].find('"').map(|i| open + i) else {
        return;
    };
    text.replace_range(open..close, by);
}

#[test]
fn robots_that_are_loops_or_nothing() {
    let mut plan = stand();
    for urdf in [
        "",
        "<robot name=\"r\"/>",
        "<robot name=\"r\"><link name=\"base\"/></robot>",
        "<robot><joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"a\"/></joint><link name=\"a\"/></robot>",
        "not a robot",
    ] {
        plan.robot.urdf = urdf.to_owned();
        let report = check(&plan, &Options::default());
        assert_eq!(report.failed().collect::<Vec<_>>(), ["schema"], "{urdf}");
    }
}

#[test]
fn many_changes_at_once() {
    let mut random = Random::new(4);
    let value = as_json(&lift());
    let mut all = Vec::new();
    places(&value, "", &mut random, &mut all);
    let absurd = [
        json!(-1e9),
        json!(0.0),
        json!(1e100),
        json!(1e308),
        json!(0.3),
    ];
    let mut judged = 0;
    for _ in 0..300 {
        let mut spoiled = value.clone();
        for _ in 0..8 {
            let place = &all[random.index(all.len())];
            if let Some(x @ Value::Number(_)) = spoiled.pointer_mut(place) {
                *x = absurd[random.index(absurd.len())].clone();
            }
        }
        judged += usize::from(survives(&spoiled.to_string()).is_some());
    }
    assert!(judged > 30, "{judged}");
}
