//! A small moving plan as arrays: between the nodes, at the nodes, in the file; and what is said of plans without arrays.

mod file;
mod moving;
mod plans;
mod refused;

use arrays::{Array, Values, sample};
use plan::Plan;
use std::collections::BTreeMap;

/// Arrays of a plan by name.
struct Found(BTreeMap<&'static str, Array>);

impl Found {
    fn at(plan: &Plan, rate: f64) -> Self {
        let arrays = sample(plan, rate).expect("the plan has no fault");
        Self(arrays.into_iter().map(|x| (x.name, x)).collect())
    }

    fn samples(&self) -> usize {
        self.0["time"].shape[0]
    }

    /// All numbers of one sample of a float array.
    fn row(&self, name: &str, sample: usize) -> &[f64] {
        let Values::Real(values) = &self.0[name].values else {
            panic!("{name} is no float array");
        };
        let width: usize = self.0[name].shape[1..].iter().product();
        &values[sample * width..(sample + 1) * width]
    }

    fn text(&self, name: &str) -> Vec<&str> {
        let Values::Text(values) = &self.0[name].values else {
            panic!("{name} is no array of texts");
        };
        values.iter().map(String::as_str).collect()
    }
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (x, y) in found.iter().zip(expected) {
        assert!(
            (x - y).abs() <= tolerance,
            "{what}: {found:?}, expected {expected:?}"
        );
    }
}
