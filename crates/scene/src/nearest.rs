//! The name that was probably meant.

/// The most similar of `names`, if one is similar enough to be what was meant.
pub(crate) fn nearest<'a>(
    wrong: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let longest = wrong.chars().count();
    names
        .into_iter()
        .map(|name| (edits(&wrong.to_lowercase(), &name.to_lowercase()), name))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, name)| *distance <= longest.max(name.chars().count()) / 2)
        .map(|(_, name)| name)
}

/// Names beyond this number are not listed.
const MOST_LISTED: usize = 12;

/// The known names for a message, the first ones if there are many.
pub(crate) fn list(names: &[&str]) -> String {
    let shown = names[..names.len().min(MOST_LISTED)].join(", ");
    match names.len().saturating_sub(MOST_LISTED) {
        0 if names.is_empty() => "none".to_owned(),
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Levenshtein distance: fewest insertions, deletions and replacements.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_textbook_words() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("same", "same"), 0);
    }

    #[test]
    fn a_typing_error_is_recognised_and_nonsense_is_not() {
        let names = ["table_a_top", "table_b_top", "ground_top"];
        assert_eq!(nearest("grund_top", names), Some("ground_top"));
        assert_eq!(nearest("Table_B_Top", names), Some("table_b_top"));
        assert_eq!(nearest("xyz", names), None);
        assert_eq!(nearest("anything", []), None);
    }

    #[test]
    fn long_lists_are_cut() {
        assert_eq!(list(&[]), "none");
        assert_eq!(list(&["a", "b"]), "a, b");
        assert!(list(&["x"; 15]).ends_with("x and 3 more"));
    }
}
