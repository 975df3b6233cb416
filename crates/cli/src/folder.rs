//! The folder that a run writes into.

use crate::failure::Failure;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Folder of one run.
pub(crate) struct Folder {
    path: PathBuf,
    /// Made by this run, so to be removed if nothing is put into it.
    made: bool,
}

impl Folder {
    /// `given`, or a fresh folder under runs/. It exists afterwards.
    pub fn open(given: Option<&Path>, scene: &str) -> Result<Self, Failure> {
        match given {
            Some(path) => {
                let made = !path.exists();
                fs::create_dir_all(path)
                    .map_err(|error| Failure::path("make the folder", path, &error))?;
                Ok(Self {
                    path: path.into(),
                    made,
                })
            }
            None => Self::fresh(Path::new("runs"), scene),
        }
    }

    /// A folder below `parent` that did not exist.
    fn fresh(parent: &Path, scene: &str) -> Result<Self, Failure> {
        let failed = |error: &std::io::Error| Failure::path("make a folder in", parent, error);
        fs::create_dir_all(parent).map_err(|error| failed(&error))?;
        let since = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or(Duration::ZERO);
        let name = format!("{}-{}", stamp(since.as_secs()), file_name(scene));
        for attempt in 1.. {
            let path = parent.join(if attempt == 1 {
                name.clone()
            } else {
                format!("{name}-{attempt}")
            });
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path, made: true }),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(&error)),
            }
        }
        unreachable!("some number is free")
    }

    /// Where the plan goes.
    pub fn plan(&self) -> PathBuf {
        self.path.join("plan.json")
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the page of the search goes.
    pub fn page(&self) -> PathBuf {
        self.path.join("search.html")
    }

    /// Where the search's answers go.
    pub fn journal(&self) -> PathBuf {
        self.path.join("journal.jsonl")
    }

    /// Where the plan of a sequence goes.
    pub fn solution(&self, number: usize) -> PathBuf {
        self.path.join("plans").join(format!("{number:04}.json"))
    }

    /// Where the report goes.
    pub fn report(&self) -> PathBuf {
        self.path.join("report.json")
    }

    /// Removes the folder if this run made it and put nothing into it.
    pub fn remove_if_unused(&self) {
        if self.made {
            // Fails, as it should, if there is something in it.
            let _ = fs::remove_dir(&self.path);
        }
    }
}

/// A scene's name as part of a file name.
fn file_name(scene: &str) -> String {
    scene
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || "-_".contains(c) {
                c
            } else {
                '_'
            }
        })
        .take(60)
        .collect()
}

/// Date and time, UTC, as 2026-11-21-071530.
fn stamp(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil(days);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}-{hour:02}{minute:02}{second:02}")
}

/// Year, month and day of a number of days since 1970-01-01 (Gregorian calendar).
///
/// Source: the calendar repeats every 400 years = 146097 days; years are counted from 1 March, so that the leap day
/// comes last, and (5 m + 2)/153 is the usual fit of the month lengths 31, 30, 31, 30, 31.
fn civil(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468; // since 0000-03-01
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153; // from March
    let day = day - (153 * month + 2) / 5 + 1;
    let january_to_february = month >= 10;
    let month = if january_to_february {
        month - 9
    } else {
        month + 3
    };
    (
        era * 400 + year + u64::from(january_to_february),
        month,
        day,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(stamp(0), "1970-01-01-000000");
        assert_eq!(stamp(951_782_399), "2000-02-28-235959");
        assert_eq!(stamp(951_782_400), "2000-02-29-000000");
        assert_eq!(stamp(4_107_542_400), "2100-03-01-000000");
        assert_eq!(stamp(1_795_245_330), "2026-11-21-071530");
    }

    #[test]
    fn two_runs_in_one_second_get_two_folders() {
        let parent = tempfile::tempdir().unwrap();
        let first = Folder::fresh(parent.path(), "a/b c").unwrap();
        let second = Folder::fresh(parent.path(), "a/b c").unwrap();
        assert_ne!(first.path, second.path);
        assert!(first.path.to_string_lossy().contains("-a_b_c"));
        first.remove_if_unused();
        assert!(!first.path.exists());
        fs::write(second.plan(), "x").unwrap();
        second.remove_if_unused();
        assert!(second.path.exists());
    }
}
