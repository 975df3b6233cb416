//! One array, and its bytes in NumPy's format (`.npy`, version 1.0).
//!
//! Source: NEP 1 and the documentation of `numpy.lib.format`: magic, version, length of the header, the header as a Python
//! dictionary padded with blanks to a multiple of 64 bytes, the values in C order, little-endian.

/// The values of an array in C order (last index fastest).
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// float64
    Real(Vec<f64>),
    /// int64
    Whole(Vec<i64>),
    /// bool
    Truth(Vec<bool>),
    /// Unicode strings.
    Text(Vec<String>),
}

/// A named array.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Its key in the archive.
    pub name: &'static str,
    /// Its sizes; their product is the number of values.
    pub shape: Vec<usize>,
    /// What is in it.
    pub values: Values,
}

impl Array {
    /// The array as an `.npy` file; of a handful of sizes, as all arrays of this crate are.
    pub(crate) fn to_npy(&self) -> Vec<u8> {
        let sizes: Vec<_> = self.shape.iter().map(usize::to_string).collect();
        // A tuple of one is written (n,).
        let comma = if sizes.len() == 1 { "," } else { "" };
        let header = format!(
            "{{'descr': '{}', 'fortran_order': False, 'shape': ({}{comma}), }}",
            self.values.descriptor(),
            sizes.join(", ")
        );
        // Magic, version and length take 10 bytes, the line break one.
        let padded = (header.len() + 11).next_multiple_of(64) - 11;
        let length = u16::try_from(padded + 1).expect("a handful of sizes is short");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(length.to_le_bytes());
        bytes.extend(format!("{header:padded$}\n").into_bytes());
        self.values.write(&mut bytes);
        bytes
    }
}

impl Values {
    /// Type in NumPy's notation.
    fn descriptor(&self) -> String {
        match self {
            Self::Real(_) => "<f8".to_owned(),
            Self::Whole(_) => "<i8".to_owned(),
            Self::Truth(_) => "|b1".to_owned(),
            Self::Text(texts) => format!("<U{}", width(texts)),
        }
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::Real(values) => bytes.extend(values.iter().flat_map(|x| x.to_le_bytes())),
            Self::Whole(values) => bytes.extend(values.iter().flat_map(|x| x.to_le_bytes())),
            Self::Truth(values) => bytes.extend(values.iter().map(|x| u8::from(*x))),
            Self::Text(texts) => {
                let width = width(texts);
                for text in texts {
                    let padded = text.chars().map(u32::from).chain(std::iter::repeat(0));
                    bytes.extend(padded.take(width).flat_map(u32::to_le_bytes));
                }
            }
        }
    }
}

/// Characters of the longest text, at least one: NumPy has no type for empty texts in files.
fn width(texts: &[String]) -> usize {
    let lengths = texts.iter().map(|text| text.chars().count());
    lengths.max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_those_that_numpy_writes() {
        let array = Array {
            name: "x",
            shape: vec![2],
            values: Values::Text(vec!["knee".to_owned(), "ä".to_owned()]),
        };
        let bytes = array.to_npy();
        // numpy.save of numpy.array(["knee", "ä"]), version 2.4.
        let head =
            b"\x93NUMPY\x01\x00v\x00{'descr': '<U4', 'fortran_order': False, 'shape': (2,), }";
        assert!(bytes.starts_with(head));
        assert!(bytes[head.len()..127].iter().all(|x| *x == b' '));
        assert_eq!(bytes[127], b'\n');
        assert_eq!(
            &bytes[128..],
            b"k\0\0\0n\0\0\0e\0\0\0e\0\0\0\xe4\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
        );
    }

    #[test]
    fn numbers_are_little_endian_in_c_order() {
        let array = |shape: &[usize], values| Array {
            name: "x",
            shape: shape.to_vec(),
            values,
        };
        let real = array(&[1, 2], Values::Real(vec![1.0, -2.0])).to_npy();
        assert!(
            String::from_utf8_lossy(&real)
                .contains("'<f8', 'fortran_order': False, 'shape': (1, 2), }")
        );
        assert_eq!(
            real[128..],
            [1.0f64.to_le_bytes(), (-2.0f64).to_le_bytes()].concat()
        );
        let whole = array(&[1], Values::Whole(vec![-3])).to_npy();
        assert_eq!(whole[128..], (-3i64).to_le_bytes());
        let truth = array(&[0, 2], Values::Truth(vec![])).to_npy();
        assert_eq!(truth.len(), 128);
    }
}
