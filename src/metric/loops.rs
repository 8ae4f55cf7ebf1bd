//! All loops of a layout together, and what their gate leaves.

use crate::metric::uncertainty::quantile;

/// Chi-square of all loops together, and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Loops {
    pub(super) chi_square: f64,
    pub(super) degrees: usize,
}

/// How much may be lost of what takes more than its gate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lost {
    /// Of the chi-square that it takes.
    pub(super) takes: f64,
    /// Of how far that is beyond the gate.
    pub(super) beyond: f64,
}

impl Loops {
    /// What the gate of all together leaves for a test of so many degrees of freedom, at most its own gate.
    pub(super) fn left(&self, degrees: usize, gate: f64) -> f64 {
        (quantile(self.degrees + degrees) - self.chi_square).clamp(0.0, gate)
    }

    /// By how much less, with these loops and more, what is beyond a gate of at most so many degrees of freedom may take,
    /// and be beyond it: what the loops take more, and what their gate leaves more.
    pub(super) fn lost_to(&self, more: &Loops, degrees: usize) -> Lost {
        if more == self {
            return Lost::default();
        }
        let grown = |degrees: usize| {
            let gate = quantile(degrees);
            more.left(degrees, gate) - self.left(degrees, gate)
        };
        let takes = (more.chi_square - self.chi_square).max(0.0);
        Lost { takes, beyond: takes + (1..=degrees).map(grown).fold(0.0, f64::max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// What takes more than its gate still does, by the definition, as long as it was beyond it by more than may be lost.
        #[test]
        fn what_is_beyond_a_gate_stays_beyond(
            (chi_square, loops, more, grown) in (0.0..60.0f64, 0usize..12, 0usize..4, -0.5..40.0f64),
            (degrees, most, beyond) in (1usize..20, 0usize..8, 0.0..40.0f64),
        ) {
            let before = Loops { chi_square, degrees: 3 * loops };
            let now = Loops { chi_square: (chi_square + grown).max(0.0), degrees: 3 * (loops + more) };
            let lost = before.lost_to(&now, degrees + most);
            let all_takes = chi_square + before.left(degrees, quantile(degrees)) + beyond;
            let takes = all_takes.max(now.chi_square) - now.chi_square;
            prop_assert!(takes > all_takes - chi_square - lost.takes - 1e-9);
            let excess = takes - now.left(degrees, quantile(degrees));
            prop_assert!(excess > beyond - lost.beyond - 1e-9);
            prop_assert_eq!(before.lost_to(&before, degrees), Lost::default());
        }
    }
}
