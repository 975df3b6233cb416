//! Mesh files as surfaces with colours.

use super::surface::Surface;
use nalgebra::Vector3;
use std::path::Path;

/// A part of a file with one colour.
#[derive(Debug)]
pub(super) struct Piece {
    pub surface: Surface,
    /// Red, green, blue, from 0 to 1; `None`: the file says nothing.
    pub color: Option<[f64; 3]>,
}

/// The parts of a file, their numbers multiplied with `scale`, which must be positive.
///
/// # Errors
/// As [`mesh::load`], or there is no triangle: what is wrong.
pub(super) fn load(path: &Path, scale: &Vector3<f64>) -> Result<Vec<Piece>, String> {
    let mut pieces = Vec::new();
    for group in mesh::load(path, scale)? {
        let surface = Surface::welded(&group.places, &group.faces);
        if !surface.faces.is_empty() {
            let color = group.color;
            pieces.push(Piece { surface, color });
        }
    }
    if pieces.is_empty() {
        return Err("there is no triangle in it".into());
    }
    Ok(pieces)
}
