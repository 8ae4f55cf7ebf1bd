//! What was found, beside what somebody has marked in the log.

use crate::visit::Stage;

/// Marks are put by eye, up to so many metres before the robot comes in or after it has left.
const BY_EYE: f64 = 3.0;

/// When visits were, in metres driven, and how far the robot had driven at each scan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timetable {
    driven: Vec<f64>,
    stays: Vec<[f64; 2]>,
}

impl Timetable {
    /// Adds the next visit.
    pub fn add(&mut self, Stage { way, visit }: &Stage) {
        // A way begins with the last moment of the one before, and a robot that stands leaves out scans.
        for moment in way.iter().filter(|moment| moment.scan >= self.driven.len()).collect::<Vec<_>>() {
            self.driven.resize(moment.scan + 1, moment.driven);
        }
        self.stays.push([visit.arrival.driven, visit.departure.driven]);
    }

    /// For each mark, a scan counted from 0, the visit that it is at, if there is one. Marks and visits come in order,
    /// and no two marks have the same visit, so that taking the first that fits finds as many as can be.
    pub fn visits_at(&self, marks: &[usize]) -> Vec<Option<usize>> {
        let mut next = 0;
        let mut visit = |mark: &usize| {
            // The robot has driven on after the last visit by an unknown length.
            let driven = self.driven.get(*mark).copied().unwrap_or(f64::INFINITY);
            let ends = |stay: &[f64; 2]| stay[1] + BY_EYE >= driven;
            let at = next + self.stays[next..].iter().position(ends)?;
            (self.stays[at][0] - BY_EYE <= driven).then(|| {
                next = at + 1;
                at
            })
        };
        marks.iter().map(&mut visit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_find_their_visits_in_order() {
        let driven = (0..1000).map(|scan| f64::from(scan) / 10.0).collect();
        let table = Timetable { driven, stays: vec![[0.0, 3.0], [20.0, 24.0], [50.0, 55.0], [60.0, 61.0]] };
        // Before the first, within, just before the arrival, between two visits, beyond the last.
        assert_eq!(table.visits_at(&[0, 180, 350, 570, 999]), [Some(0), Some(1), None, Some(2), None]);
        // Two marks at one visit: the second one has none.
        assert_eq!(table.visits_at(&[200, 220]), [Some(1), None]);
        assert_eq!(table.visits_at(&[5000]), [None]);
        assert_eq!(Timetable::default().visits_at(&[0]), [None]);
    }
}
