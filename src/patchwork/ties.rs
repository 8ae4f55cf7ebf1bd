//! Which of several candidates that are equally simple strains its measurements least.

use crate::abduction::Assignment;
use crate::patchwork::local_frames::{Agreements, LocalFrames, LocalFramesError};
use crate::patchwork::survey::Survey;
use crate::patchwork::{Outcome, Strain};

/// How many candidates are relaxed at most, the first of them.
pub const MOST_TIES: usize = 16;
/// How many visits of theirs at most, all in all: what a tie-break may cost.
pub const MOST_VISITS: usize = 512;

/// Logarithms of probabilities that differ by less are equal: sums in another order differ by so much.
const ROUNDING: f64 = 1e-6;

/// Candidates that are equally simple, and what strains them.
#[derive(Clone, Debug, PartialEq)]
pub struct Ties {
    /// The strain of each, in the order in which they were given; `None` for those that were not relaxed, as there are too
    /// many, or where it did not come to rest.
    pub strains: Vec<Option<Strain>>,
    /// All of them, by their place in that order: the least strained first if all strains can be compared.
    pub order: Vec<usize>,
    /// Whether they can: all were relaxed, and something was compared in each.
    pub by_strain: bool,
}

impl Ties {
    /// Relaxes the first of some candidates, as many as is affordable; `agreements` are those of the survey. Strain is
    /// compared by its probability ([`Strain::log_probability`]); those that are equal but for rounding stay in the order
    /// given.
    pub fn of(
        survey: &Survey,
        agreements: &mut Agreements<'_>,
        tied: &[&[Assignment]],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Ties, LocalFramesError> {
        let affordable = MOST_TIES.min(MOST_VISITS / survey.len().max(1));
        let mut strains = vec![None; tied.len()];
        for (strain, candidate) in strains.iter_mut().zip(tied).take(affordable) {
            *strain = settled(&survey.relax(candidate, agreements, interrupted)?);
        }
        Ok(Ties::by(strains))
    }

    fn by(strains: Vec<Option<Strain>>) -> Ties {
        let compared = |strain: &Option<Strain>| {
            strain.is_some_and(|strain| strain.degrees_of_freedom > 0 && strain.log_probability().is_finite())
        };
        let by_strain = strains.iter().all(compared);
        let mut order: Vec<usize> = (0..strains.len()).collect();
        if by_strain {
            let probability = |at: usize| {
                strains[at].as_ref().map_or(0.0, |strain| (strain.log_probability() / ROUNDING).round())
            };
            order.sort_by(|&a, &b| probability(b).total_cmp(&probability(a)));
        }
        Ties { strains, order, by_strain }
    }
}

fn settled(frames: &LocalFrames) -> Option<Strain> {
    (frames.outcome == Outcome::Converged).then_some(frames.strain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strain(chi_square: f64, degrees_of_freedom: usize) -> Option<Strain> {
        Some(Strain { chi_square, degrees_of_freedom })
    }

    #[test]
    fn the_least_strained_comes_first_by_probability() {
        let ties = Ties::by(vec![strain(40.0, 6), strain(150.0, 100), strain(4.5, 3), strain(40.0, 6)]);
        assert!(ties.by_strain);
        assert_eq!(ties.order, [2, 1, 0, 3]);
    }

    #[test]
    fn rounding_decides_nothing() {
        let ties = Ties::by(vec![strain(40.0 + 1e-9, 6), strain(40.0, 6)]);
        assert_eq!((ties.order, ties.by_strain), (vec![0, 1], true));
    }

    #[test]
    fn what_cannot_be_compared_stays_in_its_order() {
        for other in [None, strain(0.0, 0), strain(f64::NAN, 6)] {
            let ties = Ties::by(vec![strain(40.0, 6), strain(1.0, 6), other]);
            assert_eq!((ties.order, ties.by_strain), (vec![0, 1, 2], false));
        }
    }
}
