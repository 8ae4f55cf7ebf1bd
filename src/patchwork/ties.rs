//! Which of several candidates that are equally simple is the least doubtful by what was measured and seen.

use crate::abduction::{Candidate, Report};
use crate::patchwork::agreement::Walls;
use crate::patchwork::closures::Agreements;
use crate::patchwork::local_frames::{EdgeStrain, LocalFrames, LocalFramesError};
use crate::patchwork::survey::Survey;
use crate::patchwork::{Outcome, Strain};

/// How many candidates are relaxed at most, the first of them.
pub const MOST_TIES: usize = 16;
/// How many visits of theirs at most, all in all: what a tie-break may cost.
pub const MOST_VISITS: usize = 512;

/// Logarithms of probabilities that differ by less are equal: sums in another order differ by so much.
const ROUNDING: f64 = 1e-6;

/// Walls of one place differ on so many visits to it, for doors, chairs and people. On three recorded logs it was one in
/// ten, where those of two places lay on each other in one case of two hundred (`real_data`, `walls_tell_places_apart`).
const SELDOM: f64 = 0.1;

/// Maps that are equally simple, and what speaks against each. It ranks nothing that the axioms and simplicity have not left
/// equal.
#[derive(Clone, Debug, PartialEq)]
pub struct Ties {
    /// What speaks against each, in the order in which they are put; `None` for those that were not relaxed, as there are
    /// too many, or where it did not come to rest.
    pub doubts: Vec<Option<Doubt>>,
    /// Whether the least doubtful come first: all were relaxed, and something was compared in each. Else they stay in the
    /// order of their assignments.
    pub by_strain: bool,
}

/// What speaks against a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// The strain of all that was measured.
    pub strain: Strain,
    /// On how many visits to known places the walls are others than on the first.
    pub walls_differ: usize,
}

impl Doubt {
    /// Of a candidate relaxed; `None` where it did not come to rest.
    fn of(frames: &LocalFrames) -> Option<Doubt> {
        let differ = |edge: &&EdgeStrain| edge.walls == Some(Walls::Differ);
        let walls_differ = frames.strains.iter().filter(differ).count();
        (frames.outcome == Outcome::Converged).then_some(Doubt { strain: frames.strain, walls_differ })
    }

    /// The natural logarithm of the probability that strain is as great by chance ([`Strain::log_probability`]), and walls
    /// differ so often. Where walls differ, a visit is held to its place by wide bounds that strain little; this is what
    /// makes up for it.
    pub fn log_probability(&self) -> f64 {
        self.strain.log_probability() + self.walls_differ as f64 * SELDOM.ln()
    }

    fn is_comparable(&self) -> bool {
        self.strain.degrees_of_freedom > 0 && self.strain.log_probability().is_finite()
    }
}

impl Ties {
    /// Puts the simplest maps of a report in order, if there are several and travels were measured; `None` where not. Relaxes
    /// the first of them, as many as is affordable; `agreements` are those of the survey. Those that are equally doubtful
    /// but for rounding stay as they are.
    pub fn rank(
        found: &mut Report,
        survey: &Survey,
        agreements: &mut Agreements<'_>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<Ties>, LocalFramesError> {
        if found.minimal.len() < 2 || !survey.is_measured() {
            return Ok(None);
        }
        let doubts = doubts(&found.minimal, survey, agreements, interrupted)?;
        let (ties, order) = Ties::by(&doubts);
        found.minimal = order.iter().map(|&at| found.minimal[at].clone()).collect();
        Ok(Some(ties))
    }

    /// Ties of these doubts put in order, and the place of each before.
    fn by(doubts: &[Option<Doubt>]) -> (Ties, Vec<usize>) {
        let by_strain = doubts.iter().all(|doubt| doubt.as_ref().is_some_and(Doubt::is_comparable));
        let mut order: Vec<usize> = (0..doubts.len()).collect();
        if by_strain {
            let probability = |at: usize| {
                doubts[at].as_ref().map_or(0.0, |doubt| (doubt.log_probability() / ROUNDING).round())
            };
            order.sort_by(|&a, &b| probability(b).total_cmp(&probability(a)));
        }
        (Ties { doubts: order.iter().map(|&at| doubts[at]).collect(), by_strain }, order)
    }
}

/// What speaks against each of some candidates, as far as is affordable.
fn doubts(
    tied: &[Candidate],
    survey: &Survey,
    agreements: &mut Agreements<'_>,
    interrupted: &dyn Fn() -> bool,
) -> Result<Vec<Option<Doubt>>, LocalFramesError> {
    let affordable = MOST_TIES.min(MOST_VISITS / survey.len().max(1));
    let mut doubts = vec![None; tied.len()];
    for (doubt, candidate) in doubts.iter_mut().zip(tied).take(affordable) {
        *doubt = Doubt::of(&survey.relax(&candidate.visits, agreements, interrupted)?);
    }
    Ok(doubts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubt(chi_square: f64, degrees_of_freedom: usize, walls_differ: usize) -> Option<Doubt> {
        Some(Doubt { strain: Strain { chi_square, degrees_of_freedom }, walls_differ })
    }

    #[test]
    fn the_least_strained_comes_first_by_probability() {
        let doubts = [doubt(40.0, 6, 0), doubt(150.0, 100, 0), doubt(4.5, 3, 0), doubt(40.0, 6, 0)];
        let (ties, order) = Ties::by(&doubts);
        assert!(ties.by_strain);
        assert_eq!(order, [2, 1, 0, 3]);
        assert_eq!(ties.doubts, [2, 1, 0, 3].map(|at: usize| doubts[at]));
    }

    /// Other walls weigh as much as a strain that chance gives once in ten times.
    #[test]
    fn walls_that_differ_speak_against_a_map_as_strain_does() {
        let doubts = [doubt(6.0, 6, 1), doubt(8.0, 6, 0), doubt(40.0, 6, 0), doubt(6.0, 6, 0)];
        assert_eq!(Ties::by(&doubts).1, [3, 1, 0, 2]);
    }

    #[test]
    fn rounding_decides_nothing() {
        let (ties, order) = Ties::by(&[doubt(40.0 + 1e-9, 6, 0), doubt(40.0, 6, 0)]);
        assert_eq!((order, ties.by_strain), (vec![0, 1], true));
    }

    #[test]
    fn what_cannot_be_compared_stays_in_its_order() {
        for other in [None, doubt(0.0, 0, 0), doubt(f64::NAN, 6, 0)] {
            let (ties, order) = Ties::by(&[doubt(40.0, 6, 0), doubt(1.0, 6, 0), other]);
            assert_eq!((order, ties.by_strain), (vec![0, 1, 2], false));
        }
    }
}
