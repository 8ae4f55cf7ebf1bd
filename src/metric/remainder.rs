//! What first order leaves out of where visits lie: a bound on the rest of the Taylor series, metres.
//!
//! An error of heading within the gate swings what lies ahead of it aside by its tangent and by up to half its square
//! more. Between two visits these add up along any chain of travels and of visits to one place; the least chain bounds.

use crate::metric::layout::{Layout, Loop, Span};

impl Layout {
    /// What first order leaves out between two visits (Taylor), metres: the least of what it leaves out along any
    /// chain of travels and of visits to one place (Dijkstra).
    pub(super) fn slack(&self, span: Span, gate: f64) -> f64 {
        self.slacks(span.from, gate)[span.to]
    }

    /// What first order leaves out between a visit and each.
    fn slacks(&self, from: usize, gate: f64) -> Vec<f64> {
        let swings = self.swings(from, gate);
        let mut best = vec![f64::INFINITY; self.poses.len()];
        let mut open: Vec<usize> = (0..best.len()).collect();
        best[from] = 0.0;
        while let Some(at) = open.iter().copied().min_by(|&a, &b| best[a].total_cmp(&best[b])) {
            if best[at].is_infinite() {
                break;
            }
            open.retain(|&visit| visit != at);
            let mut reach = |to: usize, by: f64| best[to] = best[to].min(best[at] + by);
            if let Some(swing) = swings[at] {
                reach(at - 1, swing);
            }
            if let Some(Some(swing)) = swings.get(at + 1) {
                reach(at + 1, *swing);
            }
            for Loop { span: Span { from, to }, .. } in &self.loops {
                if *from == at {
                    reach(*to, 0.0);
                } else if *to == at {
                    reach(*from, 0.0);
                }
            }
        }
        best
    }

    /// What first order leaves out of the travel to each visit, seen from one of them.
    fn swings(&self, from: usize, gate: f64) -> Vec<Option<f64>> {
        let swing = |visit: usize| {
            let (travel, before) = (self.travels[visit].as_ref()?, visit - 1);
            let known = self.headings.column(before) - self.headings.column(from);
            let span = Span { from: from.min(before), to: from.max(before) };
            let variance = (self.shared(span, span).m33 - known.norm_squared()).max(0.0);
            Some(travel.pose.x.hypot(travel.pose.y) * gate * gate * variance / 2.0)
        };
        (0..self.travels.len()).map(swing).collect()
    }
}
