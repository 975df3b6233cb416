//! The page of a search: its tree, what became of every contact sequence, and why.

mod journal;
mod tree;

use crate::ViewError;
use crate::meshes::{MeshData, Meshes};
use crate::page::{Named, fill, plan_datas};
use crate::page_data::PlanData;
use journal::Journal;
use plan::Plan;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use tree::{NodeData, RefusedData, SequenceData};

/// The journal's file in the folder of a run.
const JOURNAL: &str = "journal.jsonl";

/// So many solutions are in the page with their motion, the cheapest first.
const MOTIONS: usize = 6;

/// The data of the page of a search.
#[derive(Debug, Serialize)]
pub(crate) struct SearchData {
    format: &'static str,
    /// Changes when the run goes on.
    revision: String,
    /// True if the page asks for news.
    live: bool,
    scene: String,
    search: String,
    seed: u64,
    max_phases: usize,
    /// Contacts of the goal, with blanks for underscores.
    goal: Vec<String>,
    /// The tree of all beginnings that were looked at, parents first.
    nodes: Vec<NodeData>,
    /// Why nodes got no further, each text once.
    reasons: Vec<String>,
    /// In order of time.
    sequences: Vec<SequenceData>,
    /// Contacts that were refused wherever they occur.
    refused: Vec<RefusedData>,
    /// States and beginnings that were asked for, and how many of each were refused.
    asked: [[usize; 2]; 2],
    meshes: Vec<MeshData>,
    plans: Vec<PlanData>,
}

/// The folder of a run as a page.
#[derive(Debug, Clone)]
pub struct Run {
    folder: PathBuf,
    meshes: Meshes,
}

impl Run {
    /// The run in a folder.
    ///
    /// # Errors
    /// There is no journal in it.
    pub fn open(folder: &Path) -> Result<Self, ViewError> {
        let path = folder.join(JOURNAL);
        if path.is_file() {
            return Ok(Self {
                folder: folder.into(),
                meshes: Meshes::default(),
            });
        }
        Err(ViewError::Journal {
            path: folder.display().to_string(),
            what: format!("there is no {JOURNAL}; is it the folder of a run of `locotamp plan`?"),
        })
    }

    /// The run with its robot drawn with meshes below `folders`, as far as it has solutions yet.
    #[must_use]
    pub fn with_meshes(mut self, folders: &[PathBuf]) -> Self {
        let mut files = self.plan_files().into_iter();
        let plan = files.find_map(|(_, path)| Plan::read(&path).ok());
        let urdf = plan.iter().map(|plan| plan.robot.urdf.as_str());
        self.meshes = Meshes::load(urdf, folders, Meshes::PAGE);
        self
    }

    /// The meshes of the robot.
    pub fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// A text that changes when the run goes on.
    pub fn revision(&self) -> String {
        let length = |path: &Path| fs::metadata(path).map_or(0, |data| data.len());
        let plans = self.plan_files().len();
        format!("{}-{plans}", length(&self.folder.join(JOURNAL)))
    }

    /// The whole page. `live`: it asks its server for news, which another page must not.
    ///
    /// # Errors
    /// The journal cannot be read.
    pub fn page(&self, live: bool) -> Result<String, ViewError> {
        let page = fill(&self.data(live)?);
        Ok(if live {
            page.replacen("img-src data:", "img-src data:; connect-src 'self'", 1)
        } else {
            page
        })
    }

    /// The data of the page as JSON.
    ///
    /// # Errors
    /// The journal cannot be read.
    pub fn data(&self, live: bool) -> Result<String, ViewError> {
        let revision = self.revision();
        let path = self.folder.join(JOURNAL);
        let failed = |what: String| ViewError::Journal {
            path: path.display().to_string(),
            what,
        };
        let text = fs::read_to_string(&path).map_err(|error| failed(error.to_string()))?;
        let journal = Journal::parse(&text).map_err(failed)?;
        let mut tree = tree::build(&journal);
        let plans = self.plans(&mut tree.sequences);
        Ok(serde_json::to_string(&SearchData {
            format: "locotamp.search-page/1",
            revision,
            live,
            scene: journal.header.scene,
            search: journal.header.search,
            seed: journal.header.seed,
            max_phases: journal.header.max_phases,
            goal: (journal.header.goal.iter())
                .map(|x| x.replace('_', " "))
                .collect(),
            nodes: tree.nodes,
            reasons: tree.reasons,
            sequences: tree.sequences,
            refused: tree.refused,
            asked: tree.asked,
            meshes: self.meshes.data(),
            plans,
        })?)
    }

    /// Files of solutions, `plans/<number of the sequence>.json`, by number.
    fn plan_files(&self) -> Vec<(usize, PathBuf)> {
        let entries = fs::read_dir(self.folder.join("plans"))
            .into_iter()
            .flatten()
            .flatten();
        let mut files: Vec<_> = entries
            .filter_map(|entry| {
                let path = entry.path();
                let is_json = path.extension().is_some_and(|x| x == "json");
                let number = path.file_stem()?.to_str()?.parse().ok()?;
                is_json.then_some((number, path))
            })
            .collect();
        files.sort();
        files
    }

    /// The cheapest solutions with their motion; a file that is just being written is left out until the next time.
    fn plans(&self, sequences: &mut [SequenceData]) -> Vec<PlanData> {
        let files = self.plan_files();
        let cost = |number: usize| {
            let tried = sequences.iter().find(|x| x.number == number);
            tried.and_then(|x| x.cost).unwrap_or(f64::INFINITY)
        };
        let mut ranked: Vec<_> = files
            .iter()
            .map(|(number, path)| (cost(*number), *number, path))
            .collect();
        ranked.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut datas = Vec::new();
        for (_, number, path) in ranked.into_iter().take(MOTIONS) {
            let Ok(plan) = Plan::read(path) else { continue };
            let name = format!("sequence {number}");
            let named = Named {
                name: &name,
                plan: &plan,
            };
            let Ok(mut data) = plan_datas(&[named], &self.meshes) else {
                continue;
            };
            if let Some(tried) = sequences.iter_mut().find(|x| x.number == number) {
                tried.plan = Some(datas.len());
            }
            datas.append(&mut data);
        }
        datas
    }
}
