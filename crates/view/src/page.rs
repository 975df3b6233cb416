//! One HTML file with everything in it.

use crate::ViewError;
use crate::convert::plan_data;
use crate::meshes::{MeshData, Meshes};
use crate::motion::Motion;
use crate::page_data::PlanData;
use check::Options;
use plan::Plan;
use serde::Serialize;

/// The built page of `viewer/`, with a place for the data.
const PAGE: &str = include_str!("../../../viewer/dist/page.html");

/// Where the data goes in [`PAGE`].
const PLACE: &str = "__LOCOTAMP_DATA__";

/// A plan and how the reader calls it.
#[derive(Debug, Clone, Copy)]
pub struct Named<'a> {
    /// A short name, the tab's title.
    pub name: &'a str,
    /// The plan.
    pub plan: &'a Plan,
}

#[derive(Serialize)]
struct PageData {
    format: &'static str,
    meshes: Vec<MeshData>,
    plans: Vec<PlanData>,
}

/// A page that shows one or several plans, each judged by the checker's `accept` profile. The text is the same for the same
/// plans and meshes and needs nothing else, no network either. Robots are drawn with `meshes`, where these have theirs.
///
/// # Errors
/// A plan contradicts itself, or its robot cannot be read.
pub fn plan_page(plans: &[Named], meshes: &Meshes) -> Result<String, ViewError> {
    let data = PageData {
        format: "locotamp.page/1",
        meshes: meshes.data(),
        plans: plan_datas(plans, meshes)?,
    };
    Ok(fill(&serde_json::to_string(&data)?))
}

/// The data of plans with the verdicts on them.
pub(crate) fn plan_datas(plans: &[Named], meshes: &Meshes) -> Result<Vec<PlanData>, ViewError> {
    let one = |named: &Named| {
        let motion = Motion::new(named.plan, named.name)?;
        let verdict = check::check_over_time(named.plan, &Options::accept());
        Ok(plan_data(&motion, meshes, named.name, &verdict))
    };
    plans.iter().map(one).collect()
}

/// Puts JSON into the page. Inside a script element only `</script` and `<!--` could end it early, so `<` is escaped.
pub(crate) fn fill(json: &str) -> String {
    let (before, after) = PAGE
        .split_once(PLACE)
        .expect("the built page has a place for the data, see viewer/build.mjs");
    let json = json.replace('<', "\\u003c");
    [before, &json, after].concat()
}
