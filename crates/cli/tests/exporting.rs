//! Plans as NumPy arrays from outside: what the file holds, and what is said of files that cannot be read or written.

use crate::{locotamp, planned, refused, stderr, stdout};
use std::fs;
use std::io::Read;
use std::path::Path;

/// The last bytes of an array in an archive, as numbers.
fn last_numbers<const N: usize>(archive: &Path, array: &str) -> [f64; N] {
    let mut archive = zip::ZipArchive::new(fs::File::open(archive).unwrap()).unwrap();
    let mut bytes = Vec::new();
    let mut file = archive.by_name(&format!("{array}.npy")).unwrap();
    file.read_to_end(&mut bytes).unwrap();
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"), "{array}");
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
    let numbers: Vec<_> = bytes[bytes.len() - 8 * N..].chunks(8).map(number).collect();
    numbers.try_into().unwrap()
}

#[test]
fn the_arrays_of_a_plan_are_written_and_counted() {
    let folder = planned();
    let path = folder.path();
    let plan = plan::Plan::read(path.join("plan.json")).unwrap();
    let output = locotamp(
        path,
        &["export", "plan.json", "--out", "plan.npz", "--rate", "200"],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let samples = (plan.duration() * 200.0 + 1e-6).floor() as usize + 1;
    let said = stdout(&output);
    let expected =
        format!("plan.npz: {samples} samples at 200 Hz, 2 joints, 4 links, 0 objects, 1 contact\n");
    assert_eq!(said, expected);
    let archive = path.join("plan.npz");
    let [time] = last_numbers(&archive, "time");
    assert!((time - (samples - 1) as f64 / 200.0).abs() < 1e-12);
    // The last sample is at most 5 ms before the end.
    let [joint] = last_numbers(&archive, "joint_pos");
    let last = |rows: &[Vec<f64>]| *rows.last().unwrap().last().unwrap();
    let (q, v, a) = (last(&plan.q), last(&plan.v), last(&plan.a));
    let earlier = plan.duration() - time;
    let rest = 0.5 * a.abs() * earlier * earlier + 1e-6;
    assert!((joint - (q - v * earlier)).abs() <= rest, "{joint}");
    let [torque] = last_numbers(&archive, "joint_torque");
    assert_eq!(torque, last(&plan.tau));
}

#[test]
fn a_plan_that_is_infeasible_by_its_own_status_is_exported_with_a_note() {
    let folder = planned();
    let path = folder.path();
    let text = fs::read_to_string(path.join("plan.json")).unwrap();
    let mut plan: serde_json::Value = serde_json::from_str(&text).unwrap();
    plan["status"] = "infeasible".into();
    fs::write(path.join("bad.json"), plan.to_string()).unwrap();
    let output = locotamp(path, &["export", "bad.json", "--out", "bad.npz"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(
        stderr(&output),
        "note: bad.json is infeasible by its own status\n"
    );
    assert!(path.join("bad.npz").exists());
}

#[test]
fn what_cannot_be_exported_is_refused_with_its_name() {
    let folder = planned();
    let path = folder.path();
    let says = |arguments: &[&str], part: &str| {
        let message = refused(path, &[&["export"], arguments].concat());
        assert!(message.contains(part), "{message}");
    };
    says(&["none.json", "--out", "a.npz"], "none.json");
    fs::write(path.join("bad.json"), "{\"format\": 3}").unwrap();
    says(&["bad.json", "--out", "a.npz"], "is it a plan file?");
    says(
        &["plan.json", "--out", "a.json"],
        "error: --out a.json: expected a file name that ends in .npz",
    );
    says(
        &["plan.json", "--out", "no/such/a.npz"],
        "error: cannot write no/such/a.npz: ",
    );
    let text = fs::read_to_string(path.join("plan.json")).unwrap();
    let mut plan: serde_json::Value = serde_json::from_str(&text).unwrap();
    plan["tau"].as_array_mut().unwrap().pop();
    fs::write(path.join("short.json"), plan.to_string()).unwrap();
    says(
        &["short.json", "--out", "a.npz"],
        "error: short.json: tau: ",
    );
    assert!(!path.join("a.npz").exists());
}

#[test]
fn a_rate_that_is_no_rate_is_bad_usage() {
    let folder = tempfile::tempdir().unwrap();
    for rate in ["0", "-50", "nan", "1e9", "fast"] {
        let arguments = ["export", "plan.json", "--out", "a.npz", "--rate", rate];
        let message = refused(folder.path(), &arguments);
        assert!(
            message.contains("--rate")
                && message.contains("expected a number of samples per second from 1 to 1000"),
            "{message}"
        );
    }
}
