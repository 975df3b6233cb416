//! Meshes of robots: found by the names in their URDFs, read, simplified together to a size, written short.
//!
//! Frames: `file`, that of a mesh file. A surface is in its file's frame, scaled to metres; the signs of a URDF's `scale`
//! (mirrored parts) are left to who draws it, so that left and right share a surface.

mod encode;
mod load;
mod quadric;
mod simplify;
mod surface;

pub(crate) use encode::MeshData;
pub(crate) use surface::{Corner, Triangle};

use crate::robot::mesh_names;
use load::{Piece, load};
use mesh::locate;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::PathBuf;
use surface::Surface;

/// A mesh file at a size: its name in the URDF and the absolute scale, as bits to have an order.
type Key = (String, [u64; 3]);

/// A surface with the colour that its file gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Part {
    /// Index into the surfaces.
    pub surface: usize,
    /// Red, green, blue, from 0 to 1.
    pub color: Option<[f64; 3]>,
}

/// The mesh files of robots, ready to be drawn.
#[derive(Debug, Clone, Default)]
pub struct Meshes {
    parts: BTreeMap<Key, Vec<Part>>,
    surfaces: Vec<Surface>,
    warnings: Vec<String>,
    state: State,
}

/// What became of the meshes as a whole.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum State {
    /// Nobody asked for them.
    #[default]
    NotAsked,
    /// Drawn; so many triangles in the files, and after simplification.
    Drawn([usize; 2]),
    /// Too large for the page, however much they are simplified; the size that was allowed [bytes].
    TooLarge(usize),
}

impl Meshes {
    /// All meshes of a page together take at most so much of it [bytes].
    pub const PAGE: usize = 1_500_000;

    /// The same for figures, whose pictures show less and are drawn without a graphics card [bytes].
    pub const FIGURE: usize = 400_000;

    /// Reads the visual meshes that `urdfs` name, below `folders`, and simplifies them until they take at most `budget` bytes of
    /// a page.
    ///
    /// A name is looked for with all of its path below each folder, then with ever less of its beginning: for
    /// `package://robot/meshes/arm.stl` any folder will do that has `robot/meshes/arm.stl`, `meshes/arm.stl` or `arm.stl`.
    /// What cannot be read is left out, see [`Meshes::warnings`].
    pub fn load<'a>(
        urdfs: impl IntoIterator<Item = &'a str>,
        folders: &[PathBuf],
        budget: usize,
    ) -> Self {
        let mut meshes = Self::default();
        let mut missing = Vec::new();
        for (name, scale) in urdfs.into_iter().flat_map(mesh_names) {
            let key = key(&name, &scale);
            if meshes.parts.contains_key(&key) {
                continue;
            }
            let pieces = match locate(&name, folders) {
                Ok(Some(path)) => load(&path, &scale.abs()).map_err(|what| {
                    format!(
                        "mesh {name:?}: {}: {what}; drawn without it",
                        path.display()
                    )
                }),
                Ok(None) => {
                    missing.push(name);
                    Ok(Vec::new())
                }
                Err(what) => Err(format!("mesh {name:?}: {what}; drawn without it")),
            };
            let pieces = pieces.unwrap_or_else(|warning| {
                meshes.warnings.push(warning);
                Vec::new()
            });
            meshes.add(key, pieces);
        }
        meshes.warn_of_missing(&missing, folders);
        meshes.fit(budget);
        meshes
    }

    fn add(&mut self, key: Key, pieces: Vec<Piece>) {
        let mut parts = Vec::new();
        for piece in pieces {
            parts.push(Part {
                surface: self.surfaces.len(),
                color: piece.color,
            });
            self.surfaces.push(piece.surface);
        }
        self.parts.insert(key, parts);
    }

    fn warn_of_missing(&mut self, missing: &[String], folders: &[PathBuf]) {
        let Some(first) = missing.first() else {
            return;
        };
        let what = match missing.len() {
            1 => format!("the mesh {first:?} is"),
            n => format!("{n} meshes (the first: {first:?}) are"),
        };
        let folders: Vec<_> = folders.iter().map(|x| x.display().to_string()).collect();
        self.warnings.push(format!(
            "{what} not below {}; give the folder of the robot's package with --meshes; drawn without",
            folders.join(", ")
        ));
    }

    /// Simplifies until all surfaces fit; where that would spoil them, there are none.
    fn fit(&mut self, budget: usize) {
        let before = self.surfaces.iter().map(|x| x.faces.len()).sum();
        if simplify::simplify(&mut self.surfaces, encode::plain_bytes(budget)) {
            let after = self.surfaces.iter().map(|x| x.faces.len()).sum();
            self.state = State::Drawn([before, after]);
            return;
        }
        self.warnings.push(format!(
            "the robot's meshes do not fit into {:.1} MB, even simplified by as much as can be borne: drawn without them",
            budget as f64 / 1e6
        ));
        self.parts.clear();
        self.surfaces.clear();
        self.state = State::TooLarge(budget);
    }

    /// What could not be read or does not fit, and what to do: a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// The surfaces of a mesh of a URDF; none if its file was not read.
    pub(crate) fn parts(&self, name: &str, scale: &Vector3<f64>) -> &[Part] {
        self.parts.get(&key(name, scale)).map_or(&[], Vec::as_slice)
    }

    /// The surfaces for the page.
    pub(crate) fn data(&self) -> Vec<MeshData> {
        self.surfaces.iter().map(encode::encode).collect()
    }

    /// The triangles of a surface.
    pub(crate) fn triangles(&self, surface: usize) -> Vec<Triangle> {
        self.surfaces[surface].triangles()
    }
}

fn key(name: &str, scale: &Vector3<f64>) -> Key {
    (name.to_owned(), [0, 1, 2].map(|k| scale[k].abs().to_bits()))
}

#[cfg(test)]
mod tests;
