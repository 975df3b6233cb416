//! The text layout of a plan file: one row of numbers per line, so that files diff and stay readable.
//!
//! Objects and lists that fit on one short line stay on one line; lists of numbers always do. Numbers are
//! written with the shortest decimals that read back to the same value.

use serde_json::Value;

/// Longest line for an object or list that is kept on one line.
const SHORT_LINE: usize = 120;

/// The JSON text of `value`, ending with a newline.
pub(crate) fn to_text(value: &Value) -> String {
    let mut out = String::new();
    write_value(value, 0, &mut out);
    out.push('\n');
    out
}

fn write_value(value: &Value, depth: usize, out: &mut String) {
    match value {
        Value::Object(map) if !map.is_empty() && !fits_on_one_line(value) => {
            let entries = map.iter().map(|(key, item)| (Some(key.as_str()), item));
            write_block('{', '}', entries, depth, out);
        }
        Value::Array(items) if !fits_on_one_line(value) => {
            write_block('[', ']', items.iter().map(|item| (None, item)), depth, out);
        }
        _ => write_compact(value, out),
    }
}

fn write_block<'a>(
    open: char,
    close: char,
    entries: impl Iterator<Item = (Option<&'a str>, &'a Value)>,
    depth: usize,
    out: &mut String,
) {
    out.push(open);
    for (i, (key, item)) in entries.enumerate() {
        if i > 0 {
            out.push(',');
        }
        newline(depth + 1, out);
        if let Some(key) = key {
            out.push_str(&Value::from(key).to_string());
            out.push_str(": ");
        }
        write_value(item, depth + 1, out);
    }
    newline(depth, out);
    out.push(close);
}

fn newline(depth: usize, out: &mut String) {
    out.push('\n');
    out.extend(std::iter::repeat_n(' ', depth));
}

fn write_compact(value: &Value, out: &mut String) {
    match value {
        Value::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                write_compact(item, out);
            }
            out.push(']');
        }
        Value::Object(map) => {
            out.push('{');
            for (i, (key, item)) in map.iter().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                out.push_str(&Value::from(key.as_str()).to_string());
                out.push_str(": ");
                write_compact(item, out);
            }
            out.push('}');
        }
        scalar => out.push_str(&scalar.to_string()),
    }
}

/// Lists of numbers fit always, lists of lists never, all else if it is short and flat enough to read.
fn fits_on_one_line(value: &Value) -> bool {
    match value {
        Value::Array(items) if items.iter().all(|item| item.is_number() || item.is_null()) => true,
        Value::Array(items) if items.iter().any(Value::is_array) => false,
        Value::Array(_) | Value::Object(_) => {
            !nests_rows(value) && length_up_to(value, SHORT_LINE) <= SHORT_LINE
        }
        _ => true,
    }
}

fn nests_rows(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().any(|item| item.is_array() || nests_rows(item)),
        Value::Object(map) => map.values().any(nests_rows),
        _ => false,
    }
}

/// Length of the compact text, or some number above `limit`.
fn length_up_to(value: &Value, limit: usize) -> usize {
    let items: Box<dyn Iterator<Item = (usize, &Value)>> = match value {
        Value::Array(items) => Box::new(items.iter().map(|item| (2, item))),
        Value::Object(map) => Box::new(map.iter().map(|(key, item)| (key.len() + 6, item))),
        Value::String(text) => return text.len() + 2,
        scalar => return scalar.to_string().len(),
    };
    let mut length = 2;
    for (overhead, item) in items {
        length += overhead + length_up_to(item, limit.saturating_sub(length));
        if length > limit {
            break;
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_of_numbers_take_one_line_each_and_short_objects_stay_together() {
        let value = json!({"goal": {"a": "x", "b": null}, "q": [[1.5, -0.0], [0.1, 2]], "none": [], "empty": {}});
        let text = "{\n \"goal\": {\"a\": \"x\", \"b\": null},\n \"q\": [\n  [1.5, -0.0],\n  [0.1, 2]\n ],\n \"none\": [],\n \"empty\": {}\n}\n";
        assert_eq!(to_text(&value), text);
    }

    #[test]
    fn any_value_reads_back_as_it_was() {
        let long = "x".repeat(300);
        let value = json!({"quote\"\n": [long, {"deep": [[[1]], []]}], "t": true, "rows": [{"w": [[1, 2]]}], "s": "\u{1F916}"});
        assert_eq!(
            serde_json::from_str::<Value>(&to_text(&value)).unwrap(),
            value
        );
    }
}
