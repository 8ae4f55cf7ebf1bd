//! Which poses the measurements leave undetermined.
//!
//! A pose that can move without strain lies in the null space of the normal equations. That is looked for by inverse
//! iteration: the equations are solved, with a tiny share of the diagonal added, for sides that are rough everywhere;
//! what can move freely moves most.

use crate::patchwork::pose_graph::system::System;

/// The share of the diagonal that is added.
const SHIFT: f64 = 1e-10;
/// A pivot that is smaller than this share of its entry calls for the search.
const SUSPECT: f64 = 1e-9;
/// A direction in which strain grows by less than this share of the diagonal is free.
const FREE: f64 = 1e-12;
/// How large, against the largest, the motion of a pose is that takes part.
const TAKES_PART: f64 = 1e-3;
/// How often the equations are solved: each time cleans directions by the factor of their strain to the shift.
const ROUNDS: usize = 4;
/// From how many sides the null space is looked at. A pose that takes part escapes them all once in a very long time.
const SIDES: u64 = 3;

/// Whether the last factor, of a matrix with this diagonal, casts no doubt on any unknown.
pub(super) fn is_sound(system: &System<3>, diagonals: &[f64]) -> bool {
    system.pivots().iter().zip(diagonals).all(|(pivot, entry)| *pivot > SUSPECT * entry)
}

/// The nodes of an undamped system, with this diagonal, that can move without strain. The factor is lost.
pub(super) fn free_nodes(system: &mut System<3>, diagonals: &[f64]) -> Vec<bool> {
    let nodes = diagonals.len() / 3;
    if diagonals.iter().all(|entry| *entry <= 0.0) {
        return vec![true; nodes];
    }
    let scale = shift(system, diagonals);
    let mut free = vec![false; nodes];
    if system.factorize().is_err() {
        return free;
    }
    for side in 0..SIDES {
        // In scaled coordinates y = s x; the scaled matrix is S^-1 (H + shift S^2) S^-1.
        let mut motion: Vec<f64> =
            (0..diagonals.len() as u64).map(|k| rough(k + side * 0x9E37_79B9)).collect();
        let mut strain = f64::INFINITY;
        for _ in 0..ROUNDS {
            let before = normalised(&motion);
            let mut solved: Vec<f64> = before.iter().zip(&scale).map(|(y, s)| y * s).collect();
            system.solve(&mut solved);
            motion = solved.iter().zip(&scale).map(|(x, s)| x * s).collect();
            let square: f64 = motion.iter().map(|y| y * y).sum();
            strain = motion.iter().zip(&before).map(|(y, b)| y * b).sum::<f64>() / square - SHIFT;
        }
        if strain.abs() < FREE {
            let motion = normalised(&motion);
            let most = motion.iter().map(|y| y.abs()).fold(0.0, f64::max);
            for (node, part) in motion.chunks(3).enumerate() {
                free[node] |= part.iter().any(|y| y.abs() > TAKES_PART * most);
            }
        }
    }
    free
}

/// Adds a tiny share of its diagonal to a system. Gives the scale of each unknown, by which metres and radians, poses
/// that are well and that are poorly measured count alike.
pub(super) fn shift(system: &mut System<3>, diagonals: &[f64]) -> Vec<f64> {
    let largest = diagonals.iter().copied().fold(0.0, f64::max);
    let scale: Vec<f64> = diagonals.iter().map(|entry| entry.max(largest * SHIFT).sqrt()).collect();
    system.set_diagonals(diagonals.iter().zip(&scale).map(|(entry, scale)| entry + SHIFT * scale * scale));
    scale
}

fn normalised(vector: &[f64]) -> Vec<f64> {
    let norm = vector.iter().map(|y| y * y).sum::<f64>().sqrt();
    vector.iter().map(|y| y / norm).collect()
}

/// A number in [-1, 1) that looks random and is the same each time (Steele, Lea and Flood 2014).
fn rough(k: u64) -> f64 {
    let mut z = k.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
