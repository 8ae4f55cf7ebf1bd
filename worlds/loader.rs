//! World files to worlds: everything is checked, and what is wrong is named by file and field.

use crate::worlds::fault::{Fault, fault};
use crate::worlds::format::WireWorld;
use crate::worlds::places::read_places;
use crate::worlds::shapes::read_drawing;
use crate::worlds::walk::{read_expectation, read_walk};
use crate::worlds::world::World;
use thiserror::Error;

/// Why a world file was refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}: {field}: {message}")]
pub struct WorldError {
    /// Name of the file.
    pub file: String,
    /// The field at fault, such as `place[2].slots[0].out`; `.` for the whole file.
    pub field: String,
    /// What was found and what was expected.
    pub message: String,
}

/// The world written in a file; the name is that of the file without its ending.
pub fn load(name: &str, text: &str) -> Result<World, WorldError> {
    read(name, text).map_err(|Fault { field, message }| WorldError {
        file: format!("{name}.toml"),
        field,
        message,
    })
}

fn read(name: &str, text: &str) -> Result<World, Fault> {
    let wire = parse(text)?;
    for (field, value) in [("title", &wire.title), ("story", &wire.story)] {
        if value.trim().is_empty() {
            return fault(field, "is empty, expected a few words");
        }
    }
    let drawing = read_drawing(&wire.drawing)?;
    let places = read_places(&wire.place, &drawing)?;
    let walk = read_walk(&places, &wire.walk)?;
    let visits = walk.leave.len() + 1;
    Ok(World {
        name: name.into(),
        title: wire.title.trim().into(),
        story: wire.story.trim().into(),
        drawing,
        places,
        walk,
        paper: read_expectation("expect.paper", visits, wire.expect.paper)?,
        default: read_expectation("expect.default", visits, wire.expect.default)?,
        measured: wire
            .expect
            .measured
            .map(|measured| read_expectation("expect.measured", visits, measured))
            .transpose()?,
    })
}

fn parse(text: &str) -> Result<WireWorld, Fault> {
    let whole = |e: toml::de::Error| Fault { field: ".".into(), message: e.to_string().trim_end().into() };
    let toml = toml::Deserializer::parse(text).map_err(whole)?;
    serde_path_to_error::deserialize(toml)
        .map_err(|e| Fault { field: e.path().to_string(), message: e.inner().message().into() })
}
