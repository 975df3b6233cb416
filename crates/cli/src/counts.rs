//! How many contact sequences were tried and how far they got: one count for progress and summary.

use locotamp::Reached;
use std::fmt;

/// Sequences that were tried, by how far they got.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    pub tried: usize,
    impossible: usize,
    alike: usize,
    coarse: usize,
    optimised: usize,
}

impl Counts {
    /// Counts one more.
    pub fn add(&mut self, reached: Reached) {
        self.tried += 1;
        *match reached {
            Reached::Keyframes => &mut self.impossible,
            Reached::Alike => &mut self.alike,
            Reached::Coarse => &mut self.coarse,
            Reached::Optimised | Reached::Feasible => &mut self.optimised,
        } += 1;
    }
}

impl FromIterator<Reached> for Counts {
    fn from_iter<T: IntoIterator<Item = Reached>>(all: T) -> Self {
        let mut counts = Self::default();
        all.into_iter().for_each(|reached| counts.add(reached));
        counts
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let plural = if self.tried == 1 { "" } else { "s" };
        write!(f, "{} sequence{plural} tried", self.tried)?;
        let parts = [
            (self.impossible, "without keyframes"),
            (self.alike, "left out"),
            (self.coarse, "with a coarse motion only"),
            (self.optimised, "optimised"),
        ];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        if parts.is_empty() {
            return Ok(());
        }
        write!(f, " ({})", parts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_are_counted_by_how_far_they_got() {
        assert_eq!(Counts::default().to_string(), "0 sequences tried");
        let one: Counts = [Reached::Feasible].into_iter().collect();
        assert_eq!(one.to_string(), "1 sequence tried (1 optimised)");
        let reached = [
            Reached::Keyframes,
            Reached::Optimised,
            Reached::Alike,
            Reached::Feasible,
        ];
        let four: Counts = reached.into_iter().collect();
        assert_eq!(
            four.to_string(),
            "4 sequences tried (1 without keyframes, 1 left out, 2 optimised)"
        );
    }
}
