//! Pictures of a motion without a display: triangles, one light, a depth buffer.
//!
//! Frames: `world` (z up) and the picture, x to the right, y down, in pixels.

mod camera;
mod mesh;
mod painter;
mod scene;
mod shadow;

pub(crate) use painter::Picture;
pub(crate) use scene::Scenery;
