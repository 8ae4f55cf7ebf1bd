//! True worlds, walks through them, and what abduction must find there.
//!
//! A world file holds a drawing, its places with their stars as a person gives them, a walk and the expected
//! counts; `README.md` beside this file describes it field by field. The files are part of the library, so that
//! tests, benches and the demo need nothing but the program.

mod fault;
mod format;
mod places;
mod random;
mod shapes;
mod walk;
pub mod corridor_grid;
pub mod detours;
pub mod drawing;
pub mod drift;
pub mod drive;
pub mod loader;
pub mod picture;
pub mod rendering;
pub mod simulator;
pub mod views;
pub mod world;

pub use corridor_grid::{corridor_grid, covering_walk};
pub use detours::Detours;
pub use drift::{Drift, Odometer};
pub use drive::{Explorer, drive};
pub use loader::{WorldError, load};
pub use picture::picture;
pub use rendering::{LpmTrace, lpm_trace};
pub use simulator::{StarTrace, drifting_trace, drifting_trace_by, star_trace};
pub use views::{Naming, ViewTrace, view_trace};
pub use world::{Exit, Expectation, Minimal, Place, PlaceSlot, SlotRef, Truth, Visit, Walk, World};

/// The bundled world files, name and text.
pub const FILES: [(&str, &str); 9] = [
    ("office", include_str!("office.toml")),
    ("ring3", include_str!("ring3.toml")),
    ("ring4", include_str!("ring4.toml")),
    ("ring4-marked", include_str!("ring4-marked.toml")),
    ("theta", include_str!("theta.toml")),
    ("figure-eight", include_str!("figure-eight.toml")),
    ("nested-loops", include_str!("nested-loops.toml")),
    ("dead-end", include_str!("dead-end.toml")),
    ("crossing", include_str!("crossing.toml")),
];

/// The names of the bundled worlds.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// The bundled world of a name.
pub fn bundled(name: &str) -> Result<World, WorldError> {
    match FILES.iter().find(|(known, _)| *known == name) {
        Some((name, text)) => load(name, text),
        None => {
            let known = FILES.map(|(name, _)| name).join(", ");
            let message = format!("no world is called so, expected one of {known}");
            Err(WorldError { file: name.into(), field: ".".into(), message })
        }
    }
}
