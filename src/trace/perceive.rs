//! From a grid to what an experience needs of it.

use crate::lpm::Lpm;
use crate::star::{PerceptionParameters, describe};
use crate::trace::experience_error::ExperienceError;
use crate::trace::sighting::Described;

/// Star and arrival slot of an LPM; at the first observation the slot the robot faces.
pub fn perceive(
    lpm: &Lpm,
    first: bool,
    parameters: &PerceptionParameters,
) -> Result<Described, ExperienceError> {
    let refused = |reason: String| ExperienceError::NotDescribed(reason);
    let place = describe(lpm, parameters).map_err(|error| refused(error.to_string()))?;
    let unknown = "robot_pose does not tell through which gateway the robot came in; expected a pose near a \
                   gateway, heading inward";
    let arrival = if first { Some(place.facing) } else { place.arrival };
    let arrival = arrival.ok_or_else(|| refused(unknown.into()))?;
    Ok(Described { star: place.star, arrival, middle: place.center })
}
