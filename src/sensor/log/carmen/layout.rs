//! What stands behind the readings of `ROBOTLASER` and `RAWLASER`, told by how many numbers there are.

use crate::sensor::log::entry::LaserNumber;
use crate::sensor::log::fields::Fields;

/// What a line may hold behind its readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Whether a count of remissions and the remissions come first.
    remissions: bool,
    /// Numbers of the message behind the remissions: none of a raw sweep; two poses and four or five more.
    message: usize,
    /// Numbers of the trailer among the numbers of the line: none if there is no trailer, or if the host has a name that
    /// is no number, as then the numbers end before it; three if its name is one.
    trailer: usize,
}

const fn layout(remissions: bool, message: usize, trailer: usize) -> Layout {
    Layout { remissions, message, trailer }
}

/// The six numbers of two poses.
const POSES: usize = 6;

/// `ROBOTLASER`: CARMEN writes the first; old ones are without remissions and turn axis.
pub(super) const ROBOT: &[Layout] = &[
    layout(true, POSES + 5, 0),
    layout(true, POSES + 4, 0),
    layout(false, POSES + 5, 0),
    layout(false, POSES + 4, 0),
    layout(true, POSES + 5, 3),
    layout(true, POSES + 4, 3),
    layout(false, POSES + 5, 3),
    layout(false, POSES + 4, 3),
];

/// `RAWLASER`.
pub(super) const RAW: &[Layout] =
    &[layout(true, 0, 0), layout(true, 0, 3), layout(false, 0, 0), layout(false, 0, 3)];

/// What is seen of a line behind its readings.
#[derive(Clone, Copy, Debug)]
struct Tail {
    /// Numbers of the message; those of the trailer too, if nothing tells where it begins.
    numbers: usize,
    /// Whether a host whose name is no number ends the numbers.
    named_host: bool,
    /// The first number, if it is written as a count is.
    count: Option<usize>,
}

impl Tail {
    fn of(fields: &Fields) -> Tail {
        let ahead = fields.numbers_ahead();
        let named_host = fields.rest().len() > ahead;
        // The stamp stands before the host.
        let numbers = ahead.saturating_sub(usize::from(named_host));
        Tail { numbers, named_host, count: fields.rest().first().and_then(|word| word.parse().ok()) }
    }
}

impl Layout {
    /// Goes behind the remissions of a line if it has one of these layouts, and returns which.
    pub(super) fn find(
        layouts: &[Layout],
        fields: &mut Fields,
        laser: LaserNumber,
        expected: &str,
    ) -> Result<Layout, String> {
        let tail = Tail::of(fields);
        let Some(found) = layouts.iter().find(|layout| layout.fits(&tail, layouts)) else {
            return Err(format!(
                "a message of {laser} has {} numbers after its readings, expected {expected}",
                tail.numbers
            ));
        };
        fields.skip(if found.remissions { tail.count.unwrap_or_default() + 1 } else { 0 });
        Ok(*found)
    }

    /// Numbers of the message behind its two poses.
    pub(super) fn behind_poses(&self) -> usize {
        self.message.saturating_sub(POSES)
    }

    /// Whether a line has this layout, of those given. A first number that is written as a count is one, unless the line
    /// is too short for that; CARMEN writes coordinates with six decimals.
    fn fits(&self, tail: &Tail, layouts: &[Layout]) -> bool {
        let body = self.message + self.trailer;
        let trailer_fits = self.trailer == 0 || !tail.named_host;
        trailer_fits
            && match tail.count {
                Some(count) if self.remissions => tail.numbers.checked_sub(body + 1) == Some(count),
                None if self.remissions => false,
                count => tail.numbers == body && (count.is_none() || !Layout::may_count(tail, layouts)),
            }
    }

    /// Whether the first number of a line may be a count, by how many numbers there are.
    fn may_count(tail: &Tail, layouts: &[Layout]) -> bool {
        let counting = layouts.iter().filter(|layout| layout.remissions);
        counting.map(|layout| layout.message + 1).min().is_some_and(|least| tail.numbers >= least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_fits_two_layouts() {
        let mut fitting = vec![0; ROBOT.len() + RAW.len()];
        for (layouts, first) in [(ROBOT, 0), (RAW, ROBOT.len())] {
            for numbers in 0..60 {
                for count in (0..50).map(Some).chain([None, Some(usize::MAX)]) {
                    for named_host in [false, true] {
                        let tail = Tail { numbers, named_host, count };
                        let fits = |layout: &&Layout| layout.fits(&tail, layouts);
                        let found: Vec<&Layout> = layouts.iter().filter(fits).collect();
                        assert!(found.len() < 2, "{tail:?} fits {found:?}");
                        for (at, _) in layouts.iter().enumerate().filter(|(_, layout)| found.contains(layout))
                        {
                            fitting[first + at] += 1;
                        }
                    }
                }
            }
        }
        assert!(fitting.iter().all(|count| *count > 0), "{fitting:?}");
    }

    #[test]
    fn a_line_as_short_as_the_oldest_may_begin_with_a_whole_number() {
        let tail = Tail { numbers: POSES + 4, named_host: true, count: Some(0) };
        let found: Vec<&Layout> = ROBOT.iter().filter(|layout| layout.fits(&tail, ROBOT)).collect();
        assert_eq!(found, [&layout(false, POSES + 4, 0)]);
    }
}
