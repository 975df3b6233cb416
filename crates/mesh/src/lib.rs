//! Mesh files of robots: found by the names in their URDFs ([`locate`]), read with their colours ([`load`]).
//!
//! Frames: `file`, that of a mesh file; numbers are in metres once they are scaled.

mod collada;
mod load;
mod locate;

pub use collada::Group;
pub use load::load;
pub use locate::locate;
