//! The archive, read back with a reader that takes sizes from the headers alone.

use crate::plans::{changed, moving};
use arrays::{Values, npz, sample};
use plan::Integrator;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

/// Type, shape and bytes of all arrays of an archive.
fn read(bytes: &[u8]) -> BTreeMap<String, (String, Vec<usize>, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut arrays = BTreeMap::new();
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).unwrap();
        let name = file.name().strip_suffix(".npy").unwrap().to_owned();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!(start % 64, 0, "{name}");
        let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
        let between = |from: &str, to: &str| {
            let (_, rest) = header.split_once(from).unwrap();
            rest.split_once(to).unwrap().0.to_owned()
        };
        let sizes = between("'shape': (", ")");
        let sizes = sizes.split(',').map(str::trim).filter(|x| !x.is_empty());
        let shape = sizes.map(|x| x.parse().unwrap()).collect();
        arrays.insert(
            name,
            (between("'descr': '", "'"), shape, bytes.split_off(start)),
        );
    }
    arrays
}

#[test]
fn the_file_has_every_array_with_its_type_and_shape() {
    let arrays = sample(&moving(Integrator::Euler), 50.0).unwrap();
    let found = read(&npz(&arrays).unwrap());
    let shapes: BTreeMap<_, _> = found
        .iter()
        .map(|(name, (_, shape, _))| (name.as_str(), shape.as_slice()))
        .collect();
    let expected: [(&str, &[usize]); 21] = [
        ("fps", &[1]),
        ("time", &[26]),
        ("phase", &[26]),
        ("joint_names", &[2]),
        ("joint_pos", &[26, 2]),
        ("joint_vel", &[26, 2]),
        ("joint_acc", &[26, 2]),
        ("joint_torque", &[26, 2]),
        ("body_names", &[4]),
        ("body_pos_w", &[26, 4, 3]),
        ("body_quat_w", &[26, 4, 4]),
        ("body_lin_vel_w", &[26, 4, 3]),
        ("body_ang_vel_w", &[26, 4, 3]),
        ("object_names", &[1]),
        ("object_pos_w", &[26, 1, 3]),
        ("object_quat_w", &[26, 1, 4]),
        ("object_lin_vel_w", &[26, 1, 3]),
        ("object_ang_vel_w", &[26, 1, 3]),
        ("contact_names", &[2]),
        ("contact_active", &[26, 2]),
        ("contact_wrench", &[26, 2, 6]),
    ];
    assert_eq!(shapes, BTreeMap::from(expected));
    for array in &arrays {
        let (kind, shape, bytes) = &found[array.name];
        let n: usize = shape.iter().product();
        let (type_name, size) = match &array.values {
            Values::Real(_) => ("<f8".to_owned(), 8),
            Values::Whole(_) => ("<i8".to_owned(), 8),
            Values::Truth(_) => ("|b1".to_owned(), 1),
            Values::Text(texts) => {
                let longest = texts.iter().map(String::len).max().unwrap();
                (format!("<U{longest}"), 4 * longest)
            }
        };
        assert_eq!(
            (kind, bytes.len()),
            (&type_name, n * size),
            "{}",
            array.name
        );
    }
    let (_, _, bytes) = &found["joint_pos"];
    let Values::Real(values) = &arrays
        .iter()
        .find(|x| x.name == "joint_pos")
        .unwrap()
        .values
    else {
        panic!("joint_pos is no float array");
    };
    let numbers = bytes
        .chunks(8)
        .map(|x| f64::from_le_bytes(x.try_into().unwrap()));
    assert!(numbers.eq(values.iter().copied()));
}

#[test]
fn sizes_stand_before_each_file_for_readers_without_the_directory() {
    let bytes = npz(&sample(&moving(Integrator::Euler), 50.0).unwrap()).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(&bytes)).unwrap();
    for i in 0..archive.len() {
        let file = archive.by_index_raw(i).unwrap();
        let head = &bytes[file.header_start() as usize..];
        assert_eq!(head[6] & 8, 0, "a descriptor after the file");
        assert_eq!(
            u64::from(u32::from_le_bytes(head[22..26].try_into().unwrap())),
            file.size()
        );
    }
}

#[test]
fn the_same_plan_gives_the_same_file() {
    let bytes = || npz(&sample(&moving(Integrator::Euler), 50.0).unwrap()).unwrap();
    assert!(bytes() == bytes());
}

#[test]
fn without_objects_their_arrays_are_empty() {
    let plan = changed(|plan| {
        for key in ["objects", "object_states"] {
            plan.as_object_mut().unwrap().remove(key);
        }
        plan["interfaces"].as_array_mut().unwrap().remove(1);
        plan["phases"][1]["contacts"] = serde_json::json!([]);
    });
    let found = read(&npz(&sample(&plan, 50.0).unwrap()).unwrap());
    assert_eq!(found["object_names"], ("<U1".to_owned(), vec![0], vec![]));
    assert_eq!(
        found["object_quat_w"],
        ("<f8".to_owned(), vec![26, 0, 4], vec![])
    );
    assert_eq!(found["contact_active"].1, [26, 1]);
}
