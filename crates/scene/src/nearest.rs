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
}
