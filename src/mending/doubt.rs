//! How surely a reading was taken, in whole numbers, so that sums do not depend on their order.

/// How much of the deciding threshold a reading is from being another, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Doubt(pub u32);

impl Doubt {
    /// What may be read otherwise at most: a fifth. Walls are seen to within two cells of 5 cm on either side, so that a
    /// way is up to 0.2 m wider or narrower than it looks, which is 18 % of the passage width; and of stars whose least
    /// margin is above 20 %, hardly any changes when the grid is turned (`cargo xtask gateways stability`).
    pub const LIMIT: Doubt = Doubt(200);

    /// Of a margin, rounded up; `None` beyond [`Doubt::LIMIT`].
    pub fn of(margin: f64) -> Option<Doubt> {
        let thousandths = (margin * 1000.0).ceil();
        let within = (0.0..=f64::from(Doubt::LIMIT.0)).contains(&thousandths);
        within.then_some(Doubt(thousandths as u32))
    }

    /// The margin again, a fraction of the deciding threshold.
    pub fn margin(self) -> f64 {
        f64::from(self.0) / 1000.0
    }
}

/// What several changes cost together: their doubts, then their number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Sum {
    /// The doubts in thousandths.
    pub doubt: u32,
    /// How many changes there are.
    pub changes: usize,
}

impl Sum {
    /// With further changes.
    #[must_use]
    pub fn and(self, doubts: impl IntoIterator<Item = Doubt>) -> Sum {
        let add = |sum: Sum, one: Doubt| Sum { doubt: sum.doubt + one.0, changes: sum.changes + 1 };
        doubts.into_iter().fold(self, add)
    }
}
