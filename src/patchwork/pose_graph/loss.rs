//! Robust losses: how much an edge may pull that does not fit.

/// What an edge of chi-square `s` costs. Costs grow with `s`, and as `s` does near zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// `s`: the maximum likelihood where errors are normal.
    #[default]
    Squared,
    /// Huber (1964): `s` up to `width^2`, then growing as the square root of `s`. Convex in the error.
    Huber {
        /// Standard deviations up to which an edge counts fully.
        width: f64,
    },
    /// Cauchy: `width^2 ln(1 + s / width^2)`.
    Cauchy {
        /// Standard deviations at which an edge counts half.
        width: f64,
    },
    /// Geman and McClure (1985): `s / (1 + s / width^2)`, never more than `width^2`: an edge that is far off does
    /// not pull at all.
    GemanMcClure {
        /// Standard deviations at which an edge counts a quarter.
        width: f64,
    },
}

impl Loss {
    /// The cost and its derivative by `s`, the weight of the edge in the normal equations.
    pub fn of(self, s: f64) -> (f64, f64) {
        match self {
            Loss::Squared => (s, 1.0),
            Loss::Huber { width } if s <= width * width => (s, 1.0),
            Loss::Huber { width } => (2.0 * width * s.sqrt() - width * width, width / s.sqrt()),
            Loss::Cauchy { width } => {
                let square = width * width;
                (square * (s / square).ln_1p(), 1.0 / (1.0 + s / square))
            }
            Loss::GemanMcClure { width } => {
                let shrink = 1.0 / (1.0 + s / (width * width));
                (s * shrink, shrink * shrink)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_derivatives_of_costs() {
        let width = 1.5;
        let losses =
            [Loss::Squared, Loss::Huber { width }, Loss::Cauchy { width }, Loss::GemanMcClure { width }];
        for loss in losses {
            for s in [0.01, 0.5, 2.0, 2.5, 10.0, 1000.0] {
                let step = 1e-6 * s;
                let slope = (loss.of(s + step).0 - loss.of(s - step).0) / (2.0 * step);
                assert!((slope - loss.of(s).1).abs() < 1e-6, "{loss:?} {s}");
                assert!(loss.of(s).0 <= s && loss.of(s).1 <= 1.0);
            }
            assert!((loss.of(1e-9).0 - 1e-9).abs() < 1e-15);
        }
    }
}
