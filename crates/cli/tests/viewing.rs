//! Pages and figures from outside: what is written, and what is said of files that cannot be shown.

use crate::{locotamp, planned, refused, stderr, stdout};
use std::fs;

#[test]
fn a_page_is_one_file_without_links_to_the_network() {
    let folder = planned();
    let output = locotamp(folder.path(), &["view", "plan.json", "--out", "page.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("\"task\":\"hopper\""));
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    assert!(!page.contains("__LOCOTAMP_DATA__"));
}

#[test]
fn a_report_lists_the_figures_that_it_writes() {
    let folder = planned();
    let output = locotamp(
        folder.path(),
        &[
            "report",
            "plan.json",
            "--out",
            "figures",
            "--snapshots",
            "3",
            "--joints",
            "slide",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let files = stdout(&output);
    assert_eq!(files.lines().count(), 7, "{files}");
    for file in files.lines() {
        assert!(
            fs::metadata(folder.path().join(file)).unwrap().len() > 500,
            "{file}"
        );
    }
}

#[test]
fn meshes_are_drawn_where_they_are_found_and_named_where_not() {
    let folder = planned();
    let path = folder.path();
    let plan = fs::read_to_string(path.join("plan.json")).unwrap();
    let mut plan: serde_json::Value = serde_json::from_str(&plan).unwrap();
    let urdf = plan["robot"]["urdf"].as_str().unwrap();
    let visual = |name: &str| {
        format!(
            "<visual><geometry><mesh filename=\"package://hopper/{name}\"/></geometry></visual></link>"
        )
    };
    let urdf = urdf.replacen("</link>", &visual("good.obj"), 1);
    let urdf = urdf.replace("</link>", &visual("bad.stl"));
    plan["robot"]["urdf"] = urdf.into();
    fs::write(path.join("plan.json"), plan.to_string()).unwrap();
    for entry in fs::read_dir(path.join("plans")).unwrap() {
        fs::write(entry.unwrap().path(), plan.to_string()).unwrap();
    }
    fs::create_dir(path.join("hopper")).unwrap();
    fs::write(
        path.join("hopper/good.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    fs::write(path.join("hopper/bad.stl"), "solid nothing").unwrap();
    let output = locotamp(
        path,
        &["view", "plan.json", "--meshes", ".", "--out", "page.html"],
    );
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(
        said.starts_with("warning: mesh \"package://hopper/bad.stl\": "),
        "{said}"
    );
    let arguments = ["view", ".", "--meshes", ".", "--out", "search.html"];
    assert_eq!(stderr(&locotamp(path, &arguments)), said, "of the run too");
    for file in ["page.html", "search.html"] {
        let page = fs::read_to_string(path.join(file)).unwrap();
        assert!(page.contains("\"meshes\":[{\"size\":[3,1]"), "{file}");
        assert!(!page.contains(path.to_str().unwrap()), "a path in {file}");
    }
    let message = refused(
        path,
        &[
            "view",
            "plan.json",
            "--meshes",
            "none",
            "--out",
            "page.html",
        ],
    );
    assert!(
        message.contains("--meshes none: there is no such folder"),
        "{message}"
    );
}

#[test]
fn what_cannot_be_shown_is_refused_with_its_name() {
    let folder = planned();
    let path = folder.path();
    fs::write(path.join("bad.json"), "{\"format\": 3}").unwrap();
    let message = refused(path, &["view", "bad.json", "--out", "page.html"]);
    assert!(
        message.contains("bad.json") && message.contains("is it a plan file?"),
        "{message}"
    );
    assert!(!path.join("page.html").exists());
    assert!(refused(path, &["view", "none.json", "--out", "page.html"]).contains("none.json"));
    assert!(
        refused(path, &["view", "plan.json", "--out", "no/such/page.html"])
            .contains("cannot write no/such/page.html")
    );
    let message = refused(
        path,
        &[
            "report",
            "plan.json",
            "--out",
            "figures",
            "--joints",
            "knee",
        ],
    );
    assert!(
        message.contains("no joint \"knee\"; the plan has slide"),
        "{message}"
    );
    fs::create_dir(path.join("empty")).unwrap();
    let message = refused(path, &["watch", "empty"]);
    assert!(message.contains("there is no journal.jsonl"), "{message}");
}
