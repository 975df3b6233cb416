//! Medians, and numbers as the tables show them.

/// The median; `None` counts as more than any number, and is the median if there are more of it.
pub fn median(values: &[Option<f64>]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().map(|v| v.unwrap_or(f64::INFINITY)).collect();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = sorted[(sorted.len() - 1) / 2];
    let middle = f64::midpoint(lower, upper);
    middle.is_finite().then_some(middle)
}

/// Median and all values, in words.
pub fn numbers(values: &[Option<f64>]) -> String {
    with_unit(values, "")
}

pub fn with_unit(values: &[Option<f64>], unit: &str) -> String {
    let each: Vec<String> = values.iter().map(|value| number(*value)).collect();
    let space = if unit.is_empty() { "" } else { " " };
    let (middle, each) = (number(median(values)), each.join(", "));
    format!("**{middle}**{space}{unit} ({each})")
}

pub fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() && (value.fract() == 0.0 || value >= 100.0) => {
            format!("{value:.0}")
        }
        Some(value) if value.is_finite() => format!("{value:.1}"),
        _ => "–".to_owned(),
    }
}

pub fn share(n: usize, all: usize) -> String {
    format!("{n} of {all}")
}

pub fn percent(n: usize, all: usize) -> f64 {
    100.0 * n as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_counts_what_is_missing_as_more_than_anything() {
        assert_eq!(median(&[Some(3.0), None, Some(1.0)]), Some(3.0));
        assert_eq!(median(&[Some(1.0), Some(2.0)]), Some(1.5));
        assert_eq!(median(&[None, None, Some(1.0)]), None);
        assert_eq!(median(&[None, Some(1.0)]), None);
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn numbers_show_the_median_first_and_then_all_in_turn() {
        let values = [Some(100.4), None, Some(2.0), Some(17.66)];
        assert_eq!(with_unit(&values, "s"), "**59.0** s (100, –, 2, 17.7)");
        assert_eq!(numbers(&[]), "**–** ()");
    }
}
