//! Surfaces for the page: places as whole numbers of 16 bits, all in base64.

use super::simplify::{bytes, index_bytes};
use super::surface::Surface;
use crate::compact::base64;
use nalgebra::Vector3;
use serde::Serialize;

/// A surface as viewer/src/data.ts reads it.
#[derive(Debug, Serialize)]
pub(crate) struct MeshData {
    /// Numbers of places and of triangles.
    pub size: [usize; 2],
    /// The place of three zeros [m].
    pub low: [f64; 3],
    /// What the whole numbers are multiples of [m], per axis.
    pub step: [f64; 3],
    /// Three numbers of 16 bits per place, the lower byte first.
    pub places: String,
    /// Three indices per triangle, of 16 bits; of 32 where there are more than 65536 places.
    pub faces: String,
}

/// So many bytes become at most `coded` in base64.
pub(super) fn plain_bytes(coded: usize) -> usize {
    coded / 4 * 3
}

/// A surface written short.
pub(super) fn encode(surface: &Surface) -> MeshData {
    let infinite = Vector3::repeat(f64::INFINITY);
    let (low, high) = surface
        .places
        .iter()
        .fold((infinite, -infinite), |(low, high), x| {
            (low.inf(x), high.sup(x))
        });
    let step = (high - low) / f64::from(u16::MAX);
    let whole = |place: &Vector3<f64>, k: usize| {
        let steps = (place[k] - low[k]) / step[k].max(f64::MIN_POSITIVE);
        (steps.round() as u16).to_le_bytes()
    };
    let places = surface
        .places
        .iter()
        .flat_map(|place| [0, 1, 2].map(|k| whole(place, k)));
    let width = index_bytes(surface.places.len());
    let faces = surface.faces.iter().flatten();
    let size = [surface.places.len(), surface.faces.len()];
    debug_assert_eq!(bytes(size[0], size[1]), 6 * size[0] + 3 * width * size[1]);
    MeshData {
        size,
        low: low.into(),
        step: step.into(),
        places: base64(&places.flatten().collect::<Vec<_>>()),
        faces: base64(
            &faces
                .flat_map(|x| x.to_le_bytes().into_iter().take(width))
                .collect::<Vec<_>>(),
        ),
    }
}
