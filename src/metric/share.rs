//! How much of an error of heading is the same on all travels: not known, so that all there may be is asked.
//!
//! The error of a travel has two parts: one of its own, and `L b`, where `L L'` is what odometry has in the covariance
//! `C` of the travel and `b`, one number for each of three causes (`metric::uncertainty`) with variance one, is the same
//! on all travels. For length and drift aside either part is as large as the covariance allows both together. For
//! heading, which leaves most, the share that is the same is in one of a few ranges ([`Share`]), and what is refuted is
//! refuted under each. In the order of covariances a range bounds every mixture whose shares lie in it and stay; and
//! so does whatever is linear in errors, predictions from loops closed before among them.

use crate::geometry::Pose;
use crate::metric::leg::Leg;
use crate::metric::uncertainty::factor;
use nalgebra::Matrix3;

/// How much of the variance of heading errors is the same on all travels: at most so much, and at most so much is not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    same: f64,
    own: f64,
}

/// Ranges of shares. The second one holds all of them; the others do together, each judging less widely.
pub(super) const SHARES: [Share; 5] = [
    Share { same: 0.75, own: 0.5 },
    Share { same: 1.0, own: 1.0 },
    Share { same: 0.5, own: 0.75 },
    Share { same: 1.0, own: 0.25 },
    Share { same: 0.25, own: 1.0 },
];
/// Which of the ranges holds all.
const ANY: usize = 1;
/// The others. Most often it is where a heading error is mostly new on every travel that an axiom is not broken.
const PARTS: [usize; 4] = [4, 2, 0, 3];

/// What breaks an axiom whatever the share is: in the range that holds all of them, or else in each of the others.
pub(super) fn in_every<T>(mut breach: impl FnMut(usize) -> Option<T>) -> Option<Vec<T>> {
    let first = breach(0)?;
    if let Some(any) = breach(ANY) {
        return Some(vec![any]);
    }
    let others: Option<Vec<T>> = (ANY + 1..SHARES.len()).map(breach).collect();
    Some([first].into_iter().chain(others?).collect())
}

/// What breaks an axiom in each of the ranges that hold all shares together, where that takes long to find out.
pub(super) fn in_each<T>(breach: impl FnMut(usize) -> Option<T>) -> Option<Vec<T>> {
    PARTS.into_iter().map(breach).collect()
}

/// A travel with the two parts of its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travel {
    pub(super) pose: Pose,
    /// The covariance of the part of its own, and a factor of it.
    pub(super) own: Matrix3<f64>,
    pub(super) root: Matrix3<f64>,
    /// What each cause of the other part does.
    pub(super) common: Matrix3<f64>,
}

impl Share {
    /// The travel that a leg is, at the widest of the range.
    pub(super) fn of(self, leg: &Leg) -> Travel {
        let heading = leg.causes.column(2);
        let own = leg.odometry - heading * heading.transpose() * (1.0 - self.own) + leg.stay;
        let mut common = leg.causes;
        common.column_mut(2).scale_mut(self.same.sqrt());
        Travel { pose: leg.pose, own, root: factor(&own), common }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ranges_but_the_one_of_all_are_its_parts() {
        let mut parts = PARTS.to_vec();
        parts.sort_unstable();
        assert_eq!(parts, (0..SHARES.len()).filter(|range| *range != ANY).collect::<Vec<_>>());
    }
}
