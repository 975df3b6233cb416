//! Arrays in one NumPy archive (`.npz`): a zip file with one `.npy` file per array.

use crate::{Array, ArraysError};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// The archive of some arrays, uncompressed, as `numpy.savez` writes it: sizes stand before each file, for readers that do not
/// look at the directory at the end. The same arrays give the same bytes.
///
/// # Errors
/// An array of more than 4 GB.
pub fn npz(arrays: &[Array]) -> Result<Vec<u8>, ArraysError> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for array in arrays {
        archive.start_file(format!("{}.npy", array.name), options)?;
        archive
            .write_all(&array.to_npy())
            .map_err(zip::result::ZipError::Io)?;
    }
    Ok(archive.finish()?.into_inner())
}
