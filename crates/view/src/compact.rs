//! Numbers written short. Tables over time are whole multiples of a step, each row as its difference from the row before.
//!
//! Rounding is done before the differences are taken, so errors do not add up.

use serde::Serialize;

/// Rows of numbers, rounded to multiples of `step`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Table {
    /// What the whole numbers are multiples of.
    step: f64,
    /// Numbers per row.
    columns: usize,
    /// Row after row; all but the first are differences from the row before.
    data: Vec<i64>,
}

impl Table {
    /// Rounds rows of equal length.
    pub fn new(step: f64, rows: impl IntoIterator<Item = impl AsRef<[f64]>>) -> Self {
        let mut before: Vec<i64> = Vec::new();
        let mut data = Vec::new();
        for row in rows {
            let rounded: Vec<i64> = row
                .as_ref()
                .iter()
                .map(|x| (x / step).round() as i64)
                .collect();
            before.resize(rounded.len(), 0);
            data.extend(rounded.iter().zip(&before).map(|(x, y)| x - y));
            before = rounded;
        }
        Self {
            step,
            columns: before.len(),
            data,
        }
    }

    /// One column.
    pub fn column(step: f64, values: impl IntoIterator<Item = f64>) -> Self {
        Self::new(step, values.into_iter().map(|x| [x]))
    }
}

/// A number rounded to so many decimals.
pub(crate) fn rounded(x: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (x * scale).round() / scale
}

/// A list rounded to so many decimals.
pub(crate) fn all_rounded<const N: usize>(xs: [f64; N], decimals: i32) -> [f64; N] {
    xs.map(|x| rounded(x, decimals))
}

/// Bytes as text: RFC 4648, section 4.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len() * 4 / 3 + 4);
    for three in bytes.chunks(3) {
        let number = (0..3).fold(0u32, |n, k| {
            n << 8 | u32::from(three.get(k).copied().unwrap_or(0))
        });
        for k in 0..4 {
            let letter = LETTERS[(number >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= three.len() {
                char::from(letter)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        let cases = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn sums_of_the_rows_give_the_rounded_numbers() {
        let rows: Vec<[f64; 2]> = (0..500)
            .map(|i| [(0.013 * f64::from(i)).sin(), 1e-5 * f64::from(i)])
            .collect();
        let table = Table::new(1e-4, &rows);
        assert_eq!(table.columns, 2);
        let mut sum = [0i64; 2];
        for (row, change) in rows.iter().zip(table.data.chunks(2)) {
            for c in 0..2 {
                sum[c] += change[c];
                assert!((sum[c] as f64 * 1e-4 - row[c]).abs() < 0.501e-4);
            }
        }
    }
}
