//! How strictly to judge.

use std::collections::BTreeMap;

use plan::Dynamics;

use crate::categories::{Category, Level, SPECS};

/// A set of tolerances.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Profile {
    /// For plans from anywhere.
    #[default]
    Default,
    /// What a plan must reach to be reported as feasible.
    Accept,
}

/// How strictly to judge.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The set of tolerances.
    pub profile: Profile,
    /// Factor on every tolerance of the profile.
    pub tolerance_scale: f64,
    /// Tolerances that replace those of the profile, by category name; set by [`Options::set_tolerance`], which refuses
    /// unknown names (here they have no effect).
    pub tolerances: BTreeMap<String, f64>,
    /// Measurements beyond their tolerance fail too.
    pub strict: bool,
    /// Which form of the dynamics must hold; `None`: the one that the plan names.
    pub dynamics: Option<Dynamics>,
    /// Whether to look for collisions.
    pub collisions: bool,
    /// Collision samples per interval: the node itself and `substeps − 1` between it and the next.
    pub substeps: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            profile: Profile::Default,
            tolerance_scale: 1.0,
            tolerances: BTreeMap::new(),
            strict: false,
            dynamics: None,
            collisions: true,
            substeps: 2,
        }
    }
}

/// Why an option cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    /// No category has this name.
    #[error("unknown category {name:?}, expected one of {known}")]
    UnknownCategory {
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
}

impl Options {
    /// The tolerances that a plan must reach to be reported as feasible.
    pub fn accept() -> Self {
        Self {
            profile: Profile::Accept,
            ..Self::default()
        }
    }

    /// Replaces the tolerance of one category, in its unit.
    ///
    /// # Errors
    /// No category has this name.
    pub fn set_tolerance(&mut self, category: &str, tolerance: f64) -> Result<(), OptionsError> {
        let Some(spec) = SPECS.iter().find(|spec| spec.name == category) else {
            let known = SPECS
                .iter()
                .map(|spec| spec.name)
                .collect::<Vec<_>>()
                .join(", ");
            return Err(OptionsError::UnknownCategory {
                name: category.to_owned(),
                known,
            });
        };
        self.tolerances.insert(spec.name.to_owned(), tolerance);
        Ok(())
    }

    /// Tolerance of a category for a plan that names `dynamics`.
    pub(crate) fn tolerance(&self, dynamics: Dynamics, category: Category) -> f64 {
        let judged_as = self.counterpart(dynamics, category).spec();
        let base = match self.profile {
            Profile::Default => judged_as.tolerance,
            Profile::Accept => judged_as.accept,
        };
        let own = self.tolerances.get(category.spec().name).copied();
        own.unwrap_or(base * self.tolerance_scale)
    }

    /// Level of a category for a plan that names `dynamics`.
    pub(crate) fn level(&self, dynamics: Dynamics, category: Category) -> Level {
        self.counterpart(dynamics, category).spec().level
    }

    /// The category whose tolerance and level apply: a plan that satisfies the base rows is judged by them, and the
    /// momentum rows become the measurement of the time step's error.
    fn counterpart(&self, dynamics: Dynamics, category: Category) -> Category {
        use Category as C;
        match (self.dynamics.unwrap_or(dynamics), category) {
            (Dynamics::BaseRows, C::CentroidalForce) => C::UnactuatedForce,
            (Dynamics::BaseRows, C::CentroidalMoment) => C::UnactuatedMoment,
            (Dynamics::BaseRows, C::UnactuatedForce) => C::CentroidalForce,
            (Dynamics::BaseRows, C::UnactuatedMoment) => C::CentroidalMoment,
            (_, other) => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_rows_and_momentum_rows_change_places() {
        let options = Options::accept();
        let (force, base) = (Category::CentroidalForce, Category::UnactuatedForce);
        assert_eq!(options.tolerance(Dynamics::Momentum, force), 0.05);
        assert_eq!(options.tolerance(Dynamics::BaseRows, force), 40.0);
        assert_eq!(options.tolerance(Dynamics::BaseRows, base), 0.05);
        assert_eq!(options.level(Dynamics::BaseRows, base), Level::Fail);
        assert_eq!(options.level(Dynamics::BaseRows, force), Level::Warn);
        let forced = Options {
            dynamics: Some(Dynamics::Momentum),
            ..Options::accept()
        };
        assert_eq!(forced.tolerance(Dynamics::BaseRows, force), 0.05);
    }

    #[test]
    fn own_tolerances_win_and_unknown_names_are_refused() {
        let mut options = Options {
            tolerance_scale: 2.0,
            ..Options::default()
        };
        options.set_tolerance("cop", 0.7).unwrap();
        assert_eq!(options.tolerance(Dynamics::Momentum, Category::Cop), 0.7);
        assert_eq!(
            options.tolerance(Dynamics::Momentum, Category::Torsion),
            0.1
        );
        let message = options.set_tolerance("copp", 1.0).unwrap_err().to_string();
        assert!(
            message.starts_with("unknown category \"copp\", expected one of schema, "),
            "{message}"
        );
    }
}
