//! Pages and figures of a small plan: what is in them, and what is said of plans that cannot be shown.

mod sample;

use sample::{changed, sample};
use serde_json::Value;
use view::{FigureOptions, Meshes, Named, figures, plan_page};

fn page(plan: &plan::Plan) -> String {
    plan_page(&[Named { name: "it", plan }], &Meshes::default()).unwrap()
}

/// The data of the plan inside a page.
fn data(plan: &plan::Plan) -> Value {
    data_of(&page(plan))["plans"][0].take()
}

/// The data inside a page.
fn data_of(page: &str) -> Value {
    let start = r#"<script id="data" type="application/json">"#;
    let (_, rest) = page.split_once(start).unwrap();
    let (json, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(json).unwrap()
}

/// Column `column` of a table of the page.
fn column(table: &Value, column: usize) -> Vec<f64> {
    let columns = table["columns"].as_u64().unwrap() as usize;
    let numbers = table["data"].as_array().unwrap();
    let mut sum = 0;
    let changes = numbers.iter().skip(column).step_by(columns);
    let values = changes.map(|change| {
        sum += change.as_i64().unwrap();
        sum as f64 * table["step"].as_f64().unwrap()
    });
    values.collect()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (x, y) in found.iter().zip(expected) {
        assert!(
            (x - y).abs() <= tolerance,
            "{found:?}, expected {expected:?}"
        );
    }
}

#[test]
fn the_page_has_the_motion_to_what_can_be_seen() {
    let data = data(&sample());
    assert_near(&column(&data["time"], 0), &[0.0, 0.1, 0.2, 0.35, 0.5], 1e-5);
    assert_near(&column(&data["q"], 2), &[0.5, 0.49, 0.48, 0.49, 0.5], 2e-5);
    assert_near(&column(&data["tau"], 0), &[50.0, 60.0, -150.0, 70.0], 0.02);
    // Trunk 8 kg at z, leg 2 kg at 0.2: (8 z + 0.4) / 10.
    assert_near(
        &column(&data["com"], 2),
        &[0.44, 0.432, 0.424, 0.432, 0.44],
        2e-5,
    );
}

#[test]
fn loads_are_those_worked_by_hand() {
    // Normal force 100 N, 10 N sideways with μ = 0.5. The sole's axes are turned by π about x: a moment of 2 N m about the
    // world's x is 2 about its own x, 1 about the world's y is −1 about its own; the centre of pressure is at
    // x = −k_y / f_z of the world, −0.01, and y = k_x / f_z, 0.02, which is −0.02 on the sole.
    let load = &data(&sample())["phases"][0]["contacts"][0]["load"];
    assert_near(&column(load, 0), &[0.1, 0.1], 1e-4);
    assert_near(&column(load, 1), &[0.2, 0.2], 1e-4);
    assert_near(&column(load, 2), &[-0.01, -0.01], 1e-4);
    assert_near(&column(load, 3), &[-0.02, -0.02], 1e-4);
}

#[test]
fn the_robot_looks_as_its_urdf_says() {
    let robot = &data(&sample())["robot"];
    let trunk = &robot["shapes"][0];
    assert_eq!(trunk["color"], "#ff0033");
    assert_eq!(trunk["box"], serde_json::json!([0.1, 0.05, 0.15]));
    let pose: Vec<f64> = serde_json::from_value(trunk["pose"].clone()).unwrap();
    assert_near(
        &pose,
        &[0.0, 0.0, 0.1, 0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()],
        1e-6,
    );
    assert_eq!(
        robot["shapes"][1]["cylinder"],
        serde_json::json!([0.03, 0.2])
    );
    assert_eq!(robot["notes"], serde_json::json!([]));
}

/// The sample with a mesh in the place of the trunk's box.
fn with_mesh(scale: &str) -> plan::Plan {
    changed(|plan| {
        let urdf = plan["robot"]["urdf"].as_str().unwrap();
        let mesh = format!(r#"<mesh filename="package://robot/trunk.obj"{scale}/>"#);
        plan["robot"]["urdf"] = urdf.replace(r#"<box size="0.2 0.1 0.3"/>"#, &mesh).into();
    })
}

#[test]
fn links_with_meshes_alone_become_rods_and_the_page_says_so() {
    let robot = &data(&with_mesh(""))["robot"];
    assert!(
        robot["shapes"][0]["capsule"].is_array(),
        "{}",
        robot["shapes"]
    );
    let note = robot["notes"][0].as_str().unwrap();
    assert!(note.contains("1 link has only meshes") && note.contains("--meshes DIR"));
}

#[test]
fn meshes_that_are_given_are_drawn_in_page_and_figures() {
    let folder = tempfile::tempdir().unwrap();
    // A tetrahedron in millimetres.
    let tetrahedron =
        "v 0 0 0\nv 300 0 0\nv 0 300 0\nv 0 0 600\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.path().join("trunk.obj"), tetrahedron).unwrap();
    let plan = with_mesh(r#" scale="0.001 -0.001 0.001""#);
    let folders = [folder.path().to_owned()];
    let meshes = Meshes::load([plan.robot.urdf.as_str()], &folders, Meshes::PAGE);
    assert_eq!(meshes.warnings(), [""; 0]);
    let named = [Named {
        name: "it",
        plan: &plan,
    }];
    let page = data_of(&plan_page(&named, &meshes).unwrap());
    let mesh = &page["meshes"][0];
    assert_eq!(mesh["size"], serde_json::json!([4, 4]));
    // Corners in the order of the triangles: 1, 3, 2, 4. Whole numbers are 0 or 65535.
    assert_eq!(mesh["places"], "AAAAAAAAAAD//wAA//8AAAAAAAAAAP//");
    assert_eq!(mesh["faces"], "AAABAAIAAAACAAMAAAADAAEAAgABAAMA");
    assert_near(
        &[mesh["step"][2].as_f64().unwrap()],
        &[0.6 / 65535.0],
        1e-12,
    );
    let robot = &page["plans"][0]["robot"];
    assert_eq!(robot["shapes"][0]["mesh"], 0);
    assert_eq!(
        robot["shapes"][0]["mirror"],
        serde_json::json!([1.0, -1.0, 1.0])
    );
    assert_eq!(robot["shapes"][0]["color"], "#ff0033", "the URDF's colour");
    assert_eq!(robot["notes"], serde_json::json!([]));
    let options = FigureOptions {
        snapshots: 2,
        ..FigureOptions::default()
    };
    let drawn = |meshes: &Meshes| figures(&named, meshes, &options).unwrap();
    let (with, without) = (drawn(&meshes), drawn(&Meshes::default()));
    assert_eq!(with[0], without[0], "charts are the same");
    assert_ne!(with[5], without[5], "snapshots are not");
    assert_ne!(with[6], without[6], "nor is the motion");
}

#[test]
fn the_page_looks_from_where_no_wall_is_in_the_way() {
    let view = |wall: Option<Value>| {
        let plan = changed(|plan| plan["environment"].as_array_mut().unwrap().extend(wall));
        let view = data(&plan)["view"].take();
        [0, 1].map(|k| view[k].as_f64().unwrap())
    };
    let wall = |x: f64, y: f64| {
        let shape = serde_json::json!({"box": [0.5, 0.1, 0.8], "pose": [x, y, 0.8, 0, 0, 0, 1]});
        Some(serde_json::json!({"name": "wall", "geometry": [shape]}))
    };
    // The robot looks along x.
    assert_eq!(view(None), [-0.95, 0.34]);
    assert_eq!(view(wall(0.5, 0.8)), [-0.95, 0.34], "on the other side");
    assert_eq!(view(wall(0.5, -0.8)), [0.95, 0.34]);
}

#[test]
fn text_of_the_plan_cannot_end_the_data() {
    let plan = sample();
    assert_eq!(page(&plan).matches("</script>").count(), 2);
    assert_eq!(data(&plan)["phases"][1]["action"], "stay </script> & go");
}

#[test]
fn the_same_plan_gives_the_same_page_and_figures() {
    let plan = sample();
    assert_eq!(page(&plan), page(&plan));
    let named = [Named {
        name: "it",
        plan: &plan,
    }];
    let options = FigureOptions {
        snapshots: 2,
        ..FigureOptions::default()
    };
    assert_eq!(
        figures(&named, &Meshes::default(), &options).unwrap(),
        figures(&named, &Meshes::default(), &options).unwrap()
    );
}

#[test]
fn residuals_stand_beside_the_checkers_verdict() {
    let plan = changed(|plan| plan["q"][2][2] = 0.45.into());
    let check = &data(&plan)["check"];
    assert_eq!(check["ok"], false);
    let rows = check["rows"].as_array().unwrap();
    let row = rows
        .iter()
        .find(|row| row["category"] == "contact_distance")
        .unwrap();
    assert_eq!(
        (row["status"].as_str(), row["node"].as_u64()),
        (Some("FAIL"), Some(2))
    );
    let curve = column(&row["over_time"], 0);
    assert!(curve[2] > 100.0 && curve[1] < 1.0, "{curve:?}");
}

#[test]
fn what_cannot_be_shown_is_said_with_its_place() {
    let message = |plan: &plan::Plan| {
        plan_page(&[Named { name: "it", plan }], &Meshes::default())
            .unwrap_err()
            .to_string()
    };
    let joint = changed(|plan| plan["robot"]["joints"][0] = "knee".into());
    assert_eq!(
        message(&joint),
        "it: robot.joints[0]: the URDF has no moving joint \"knee\""
    );
    let body = changed(|plan| plan["interfaces"][0]["body"] = "toe".into());
    let text = message(&body);
    assert!(
        text.starts_with("it: interfaces[0].body: no ") && text.contains("\"toe\""),
        "{text}"
    );
    let urdf = changed(|plan| {
        let text = plan["robot"]["urdf"].as_str().unwrap();
        let text = text.replace("value=\"8\"", "value=\"heavy\"");
        plan["robot"]["urdf"] = text.into();
    });
    assert!(
        message(&urdf).starts_with("it: robot.urdf: "),
        "{}",
        message(&urdf)
    );
    let short = changed(|plan| {
        plan["time"].as_array_mut().unwrap().pop();
    });
    assert!(
        message(&short).contains("`locotamp check` lists all faults"),
        "{}",
        message(&short)
    );
}

#[test]
fn figures_are_svg_png_and_gif() {
    let plan = sample();
    let named = [
        Named {
            name: "left",
            plan: &plan,
        },
        Named {
            name: "right",
            plan: &plan,
        },
    ];
    let figures = figures(&named, &Meshes::default(), &FigureOptions::default()).unwrap();
    let files: Vec<_> = figures.iter().map(|figure| figure.file.as_str()).collect();
    let expected = [
        "contacts.svg",
        "contacts.png",
        "torques.svg",
        "torques.png",
        "snapshots.svg",
        "snapshots.png",
        "motion.gif",
    ];
    assert_eq!(files, expected);
    for figure in &figures {
        let head: &[u8] = match figure.file.rsplit('.').next() {
            Some("svg") => b"<svg xmlns",
            Some("png") => b"\x89PNG",
            _ => b"GIF89a",
        };
        assert!(figure.bytes.starts_with(head), "{}", figure.file);
    }
    let torques = String::from_utf8(figures[2].bytes.clone()).unwrap();
    assert!(
        torques.contains(">slide<") && torques.contains(">left<") && torques.contains(">right<")
    );
}

#[test]
fn torques_of_unknown_joints_are_refused_by_name() {
    let plan = sample();
    let options = FigureOptions {
        joints: vec!["knee".into()],
        ..FigureOptions::default()
    };
    let error = figures(
        &[Named {
            name: "it",
            plan: &plan,
        }],
        &Meshes::default(),
        &options,
    )
    .unwrap_err();
    assert_eq!(error.to_string(), "no joint \"knee\"; the plan has slide");
}

#[test]
fn a_joint_gives_less_at_speed_where_the_plan_says_so() {
    let shares = |plan: &plan::Plan| column(&data(plan)["torque_share"], 0);
    assert_near(&shares(&sample()), &[0.25, 0.3, 0.75, 0.35], 1e-3);
    // At 2 rad/s, half way from the corner to the end, half of the 200 N m is left for driving, all for braking.
    let fast = changed(|plan| {
        plan["robot"]["torque_speed"] = serde_json::json!({"slide": {"corner": 1.0, "max": 3.0}});
        plan["v"][1][6] = 2.0.into();
        plan["v"][2][6] = 2.0.into();
    });
    assert_near(&shares(&fast), &[0.25, 0.6, 0.75, 0.35], 1e-3);
    let free = changed(|plan| plan["robot"]["torque_limits"] = serde_json::json!([null]));
    assert_near(&shares(&free), &[1.0 / 6.0, 0.2, 0.5, 70.0 / 300.0], 1e-3);
    assert_eq!(data(&free)["robot"]["joints"][0]["enforced"], false);
}
