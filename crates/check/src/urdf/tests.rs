use super::*;

const LINK: &str = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";

fn text(links: &[&str], joints: &[(&str, &str, &str, &str)]) -> String {
    let links = links
        .iter()
        .map(|name| format!("<link name='{name}'>{LINK}</link>"));
    let joints = joints.iter().map(|(name, kind, parent, child)| {
            format!("<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><axis xyz='0 0 3'/></joint>")
        });
    format!(
        "<robot name='r'>{}</robot>",
        links.chain(joints).collect::<String>()
    )
}

fn error(text: &str, joints: &[&str]) -> String {
    let joints: Vec<_> = joints.iter().map(ToString::to_string).collect();
    read(text, &joints).unwrap_err().to_string()
}

#[test]
fn parents_come_first_and_fixed_links_share_a_group() {
    let text = text(
        &["c", "b", "a", "d"],
        &[
            ("j1", "revolute", "a", "b"),
            ("j2", "fixed", "b", "c"),
            ("j3", "prismatic", "c", "d"),
        ],
    );
    let robot = read(&text, &["j3".to_owned(), "j1".to_owned()]).unwrap();
    let names: Vec<_> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c", "d"]);
    assert_eq!(
        robot
            .links
            .iter()
            .map(|link| link.group)
            .collect::<Vec<_>>(),
        [0, 1, 1, 2]
    );
    assert_eq!(
        robot.links[1].motion,
        JointMotion::Turns {
            axis: Vector3::z(),
            column: 1
        }
    );
    assert_eq!(
        (
            robot.joints_between(0, 2),
            robot.joints_between(2, 1),
            robot.joints_between(1, 1)
        ),
        (2, 1, 0)
    );
    assert!(
        robot.limits[0].effort.is_infinite(),
        "no limit element means no limit"
    );
}

#[test]
fn joints_that_the_plan_does_not_list_are_fixed() {
    let text = text(&["a", "b"], &[("j1", "revolute", "a", "b")]);
    assert_eq!(read(&text, &[]).unwrap().links[1].group, 0);
}

#[test]
fn the_child_of_a_floating_joint_at_the_root_is_the_base() {
    let text = text(
        &["world", "pelvis", "leg"],
        &[
            ("float", "floating", "world", "pelvis"),
            ("j", "revolute", "pelvis", "leg"),
        ],
    );
    let robot = read(&text, &["j".to_owned()]).unwrap();
    assert_eq!(
        (robot.links[0].name.as_str(), robot.links.len()),
        ("pelvis", 2)
    );
}

#[test]
fn what_is_no_tree_is_refused_by_name() {
    let two_parents = text(
        &["a", "b", "c"],
        &[("j1", "fixed", "a", "c"), ("j2", "fixed", "b", "c")],
    );
    assert!(error(&two_parents, &[]).contains("link \"c\" has two parents"));
    let ring = text(
        &["a", "b", "c"],
        &[("j1", "fixed", "b", "c"), ("j2", "fixed", "c", "b")],
    );
    assert!(
        error(&ring, &[]).contains("links b, c hang in a loop"),
        "{}",
        error(&ring, &[])
    );
    let own = text(&["a"], &[("j1", "revolute", "a", "a")]);
    assert!(error(&own, &[]).contains("0 links have no parent"));
    assert!(error(&text(&["a", "b"], &[]), &[]).contains("2 links have no parent"));
    assert!(
        error(&text(&["a"], &[("j", "fixed", "a", "x")]), &[])
            .contains("joint \"j\" names link \"x\"")
    );
    assert!(error(&text(&["a", "a"], &[]), &[]).contains("\"a\" is used twice"));
    assert!(
        error(&text(&["a", "b"], &[("j", "planar", "a", "b")]), &[])
            .contains("joint \"j\" is planar")
    );
    assert!(error(&text(&["a"], &[]), &["knee"]).contains("\"knee\" is not a movable joint"));
    assert!(error("<robot", &[]).starts_with("URDF: "));
}

#[test]
fn absurd_numbers_are_refused() {
    let good = text(&["a", "b"], &[("j1", "revolute", "a", "b")]);
    for (from, to, message) in [
        ("mass value='1'", "mass value='-1'", "mass of -1 kg"),
        ("mass value='1'", "mass value='NaN'", "mass of NaN kg"),
        ("mass value='1'", "mass value='0'", "no mass"),
        ("iyy='1'", "iyy='-1'", "moments of inertia"),
        ("0 0 3", "0 0 0", "axis of length zero"),
        ("0 0 3", "inf 0 0", "finite numbers"),
    ] {
        let found = error(&good.replace(from, to), &["j1"]);
        assert!(found.contains(message), "{found}");
    }
    let limited = good.replace(
        "</joint>",
        "<limit lower='nan' upper='1' effort='1' velocity='1'/></joint>",
    );
    assert!(error(&limited, &["j1"]).contains("joint \"j1\" has limits [NaN, 1.0, 1.0, 1.0]"));
    let deep = format!(
        "<robot name='r'>{}{}</robot>",
        "<x>".repeat(100_000),
        "</x>".repeat(100_000)
    );
    assert!(error(&deep, &[]).contains("nested 100001 deep"));
}

#[test]
fn roll_pitch_and_yaw_turn_about_the_fixed_axes_in_this_order() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let origin = urdf_rs::Pose {
        xyz: urdf_rs::Vec3([1.0, 2.0, 3.0]),
        rpy: urdf_rs::Vec3([quarter, 0.0, quarter]),
    };
    let pose = pose(&origin, "x").unwrap();
    // y goes to z by the roll and stays there; x goes to y by the yaw.
    assert!((pose.rotate(Vector3::y()) - Vector3::z()).norm() < 1e-15);
    assert!((pose.rotate(Vector3::x()) - Vector3::y()).norm() < 1e-15);
    assert_eq!(pose.origin(), Vector3::new(1.0, 2.0, 3.0));
}

#[test]
fn moments_of_inertia_that_should_be_zero_may_be_rounded_below_it() {
    let text = text(&["a"], &[]);
    let with = |ixx: &str| text.replace("ixx='1'", &format!("ixx='{ixx}'"));
    assert!(read(&with("-5e-20"), &[]).is_ok());
    assert!(
        read(&with("-0.1"), &[])
            .unwrap_err()
            .to_string()
            .contains("moments of inertia")
    );
}

#[test]
fn textures_without_a_file_are_passed_over_and_others_are_kept() {
    for texture in [
        "<texture/>",
        "<texture />",
        "<texture></texture>",
        "<texture>\n</texture>",
        "<texture filename='a.png'/>",
    ] {
        let visual = format!(
            "<visual><geometry><sphere radius='1'/></geometry><material name='m'>{texture}</material></visual>"
        );
        let text = format!("<robot name='r'><link name='a'>{LINK}{visual}</link></robot>");
        let robot = read(&text, &[]).unwrap();
        assert_eq!((robot.links.len(), robot.shapes.len()), (1, 1), "{texture}");
    }
    let named = "<texture filename='a.png'></texture><texture filename='b.png'/>";
    assert_eq!(without_nameless_textures(named), named);
}
