//! The largest residual of each category and where it is.

use std::collections::BTreeMap;

use crate::categories::Category;
use crate::report::Location;

/// The largest residual found so far in each category that was looked at.
#[derive(Debug, Default)]
pub(crate) struct Measurements(BTreeMap<Category, (f64, Location)>);

impl Measurements {
    /// Takes note of a residual; one that is not finite counts as the largest number. Zero has no place.
    pub fn add(&mut self, category: Category, value: f64, location: impl FnOnce() -> Location) {
        let value = if value.is_finite() { value } else { f64::MAX };
        let worst = self.0.entry(category).or_default();
        if value > worst.0 {
            *worst = (value, location());
        }
    }

    /// Takes note that a counting category was looked at.
    pub fn looked_at(&mut self, category: Category) {
        self.0.entry(category).or_default();
    }

    /// Counts one fault of a counting category.
    pub fn count(&mut self, category: Category, fault: &str) {
        /// Faults named in the report; more are only counted.
        const NAMED: f64 = 8.0;
        let (count, location) = self.0.entry(category).or_default();
        if *count < NAMED {
            let separator = if location.what.is_empty() { "" } else { "; " };
            location.what.push_str(separator);
            location.what.push_str(fault);
        }
        *count += 1.0;
    }

    /// The largest residual of a category, if it was looked at.
    pub fn get(&self, category: Category) -> Option<&(f64, Location)> {
        self.0.get(&category)
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
