//! The largest residual of each category and where it is.

use std::collections::BTreeMap;

use crate::categories::Category;
use crate::report::Location;

/// The largest residual found so far in each category that was looked at.
#[derive(Debug, Default)]
pub(crate) struct Measurements {
    worst: BTreeMap<Category, (f64, Location)>,
    /// Largest residual by category and node; `None`: not kept.
    by_node: Option<BTreeMap<(Category, usize), f64>>,
}

impl Measurements {
    /// Keeps the largest residual of every node as well.
    pub fn by_node() -> Self {
        Self {
            by_node: Some(BTreeMap::new()),
            ..Self::default()
        }
    }

    /// Takes note of a residual; one that is not finite counts as the largest number. Zero has no place.
    pub fn add(&mut self, category: Category, value: f64, location: impl FnOnce() -> Location) {
        let value = if value.is_finite() { value } else { f64::MAX };
        let worst = self.worst.entry(category).or_default();
        let is_worst = value > worst.0;
        if let Some(by_node) = &mut self.by_node {
            let place = location();
            if let Some(node) = place.node {
                let here = by_node.entry((category, node)).or_default();
                *here = here.max(value);
            }
            if is_worst {
                *worst = (value, place);
            }
        } else if is_worst {
            *worst = (value, location());
        }
    }

    /// Takes note that a counting category was looked at.
    pub fn looked_at(&mut self, category: Category) {
        self.worst.entry(category).or_default();
    }

    /// Counts one fault of a counting category.
    pub fn count(&mut self, category: Category, fault: &str) {
        /// Faults named in the report; more are only counted.
        const NAMED: f64 = 8.0;
        let (count, location) = self.worst.entry(category).or_default();
        if *count < NAMED {
            let separator = if location.what.is_empty() { "" } else { "; " };
            location.what.push_str(separator);
            location.what.push_str(fault);
        }
        *count += 1.0;
    }

    /// Largest residual of a category at each of `n` nodes, zero where it was not measured; `None` if it was at no node.
    pub fn over_time(&self, category: Category, n: usize) -> Option<Vec<f64>> {
        let by_node = self.by_node.as_ref()?;
        let mut values = vec![0.0; n];
        let mut measured = false;
        for ((_, node), value) in by_node.range((category, 0)..=(category, usize::MAX)) {
            if let Some(here) = values.get_mut(*node) {
                (*here, measured) = (*value, true);
            }
        }
        measured.then_some(values)
    }

    /// The largest residual of a category, if it was looked at.
    pub fn get(&self, category: Category) -> Option<&(f64, Location)> {
        self.worst.get(&category)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_residual_stays_with_its_place() {
        let mut found = Measurements::default();
        for (value, name) in [(0.1, "a"), (0.3, "b"), (0.2, "c")] {
            found.add(Category::Cop, value, || Location::of(name));
        }
        assert_eq!(found.get(Category::Cop), Some(&(0.3, Location::of("b"))));
        found.add(Category::Cop, f64::NAN, || Location::of("d"));
        assert_eq!(
            found.get(Category::Cop),
            Some(&(f64::MAX, Location::of("d")))
        );
        assert_eq!(found.get(Category::Torsion), None);
    }

    #[test]
    fn the_largest_residual_of_each_node_is_kept_on_demand() {
        let mut found = Measurements::by_node();
        for (value, node) in [(0.1, 0), (0.3, 2), (0.2, 2)] {
            found.add(Category::Cop, value, || Location {
                node: Some(node),
                ..Location::of("a")
            });
        }
        let values = found.over_time(Category::Cop, 4);
        assert_eq!(values, Some(vec![0.1, 0.0, 0.3, 0.0]));
        assert_eq!(found.over_time(Category::Torsion, 4), None);
        assert_eq!(found.get(Category::Cop).unwrap().1.node, Some(2));
        assert_eq!(Measurements::default().over_time(Category::Cop, 4), None);
    }

    #[test]
    fn faults_are_counted_and_the_first_are_named() {
        let mut found = Measurements::default();
        found.looked_at(Category::Goal);
        assert_eq!(found.get(Category::Goal).unwrap().0, 0.0);
        for i in 0..20 {
            found.count(Category::Goal, &i.to_string());
        }
        assert_eq!(
            found.get(Category::Goal),
            Some(&(20.0, Location::of("0; 1; 2; 3; 4; 5; 6; 7")))
        );
    }
}
