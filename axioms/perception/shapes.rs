//! Places with one known answer each, as the seed defines it (sections 4.2 and 4.3, Figure 3).
//!
//! Figure 3(e) is printed with gateway 2 on two fragments, against the seed's own rule; here the opening has number 3.

use std::f64::consts::{FRAC_PI_2, PI};
use topostar::geometry::Pose;
use topostar::worlds::drawing::{Drawing, evenly};

/// A floor plan, where a robot may arrive in it, and the star listed from the first arrival.
pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) plan: Drawing,
    /// Poses on arrival, one for each gateway.
    pub(super) arrivals: Vec<Pose>,
    /// Slots as in the seed's figures: `1+ 1>4 Midline` is PF1+, gateway 1 out and gateway 4 in.
    pub(super) star: &'static str,
}

const N: f64 = FRAC_PI_2;
const S: f64 = -FRAC_PI_2;
const E: f64 = 0.0;
const W: f64 = PI;
const FAR: f64 = 16.0;

fn shape(name: &'static str, plan: Drawing, arrivals: &[(f64, f64, f64)], star: &'static str) -> Shape {
    let arrivals = arrivals.iter().map(|&(x, y, theta)| Pose::new(x, y, theta)).collect();
    Shape { name, plan, arrivals, star }
}

pub(super) fn all() -> Vec<Shape> {
    let groups = [corridors(), forks_and_ends(), rooms(), halls(), clutter(), odd_angles(), figures()];
    groups.into_iter().flatten().collect()
}

fn corridors() -> Vec<Shape> {
    let square = |directions: &[f64]| {
        Drawing::new().arms((0.0, 0.0), directions, FAR, 2.2).room((-1.1, -1.1), (1.1, 1.1))
    };
    vec![
        shape(
            "plus",
            square(&[N, E, S, W]),
            &[(0.0, -0.8, N), (-0.8, 0.0, E), (0.0, 0.8, S), (0.8, 0.0, W)],
            "1+ 1>3 Midline; 2+ 2>4 Midline; 1- 3>1 Midline; 2- 4>2 Midline",
        ),
        shape(
            "T",
            square(&[E, S, W]),
            &[(0.0, -0.8, N), (-0.8, 0.0, E), (0.8, 0.0, W)],
            "1+ >2 DeadEnd; 2+ 1>3 Midline; 1- 2> Midline; 2- 3>1 Midline",
        ),
        shape(
            "L",
            square(&[E, S]),
            &[(0.0, -0.8, N), (0.8, 0.0, W)],
            "1+ >2 DeadEnd; 2+ 1> Midline; 1- 2> Midline; 2- >1 DeadEnd",
        ),
    ]
}

fn forks_and_ends() -> Vec<Shape> {
    let arms =
        |directions: &[f64]| Drawing::new().arms((0.0, 0.0), directions, FAR, 2.2).disc((0.0, 0.0), 1.1);
    vec![
        shape(
            "five-way",
            arms(&evenly(5)),
            &[(1.0, 0.0, PI)],
            "1+ >3 DeadEnd; 2+ 1> Midline; 3+ >4 DeadEnd; 4+ 2> Midline; 5+ >5 DeadEnd; \
             1- 3> Midline; 2- >1 DeadEnd; 3- 4> Midline; 4- >2 DeadEnd; 5- 5> Midline",
        ),
        shape(
            "Y",
            arms(&evenly(3)),
            &[(1.0, 0.0, PI)],
            "1+ >2 DeadEnd; 2+ 1> Midline; 3+ >3 DeadEnd; 1- 2> Midline; 2- >1 DeadEnd; 3- 3> Midline",
        ),
        shape(
            "dead end",
            Drawing::new().corridor((-1.0, 0.0), (FAR, 0.0), 2.2),
            &[(0.5, 0.0, W)],
            "1+ >1 DeadEnd; 1- 1> Midline",
        ),
        shape(
            "straight corridor",
            Drawing::new().corridor((-FAR, 0.0), (FAR, 0.0), 2.2),
            &[(0.0, 0.0, E), (0.0, 0.0, W)],
            "1+ 1>2 Midline; 1- 2>1 Midline",
        ),
    ]
}

fn rooms() -> Vec<Shape> {
    vec![
        shape(
            "room with doors",
            Drawing::new()
                .room((-2.2, -2.0), (2.2, 2.0))
                .corridor((2.0, 0.0), (2.5, 0.0), 1.3)
                .corridor((-2.0, 0.0), (-2.5, 0.0), 1.3)
                .corridor((0.0, 2.0), (0.0, 2.5), 0.9)
                .corridor((2.4, 0.0), (FAR, 0.0), 2.0)
                .corridor((-2.4, 0.0), (-FAR, 0.0), 2.0)
                .corridor((0.0, 2.4), (0.0, FAR), 2.0),
            &[(-1.0, 0.0, E), (1.0, 0.0, W)],
            "1+ 1>2 Midline; 1- 2>1 Midline",
        ),
        shape(
            "lobby beside a T",
            Drawing::new()
                .corridor((-FAR, 0.0), (FAR, 0.0), 2.2)
                .corridor((0.0, 0.0), (0.0, -FAR), 2.2)
                .room((-4.0, 0.0), (4.0, 7.1)),
            &[(0.0, 0.0, N), (-3.0, 0.0, E), (3.0, 0.0, W)],
            "1+ >2 None; 2+ 1>3 Midline; 1- 2> Midline; 2- 3>1 Midline",
        ),
        shape(
            "L in a wide room",
            Drawing::new().room((-3.5, -3.5), (3.5, 3.5)).corridor((0.0, 0.0), (FAR, 0.0), 2.2).corridor(
                (0.0, 0.0),
                (0.0, -FAR),
                2.2,
            ),
            &[(0.0, -2.5, N), (2.5, 0.0, W)],
            "1+ >2 None; 2+ 1> Midline; 1- 2> Midline; 2- >1 None",
        ),
    ]
}

fn halls() -> Vec<Shape> {
    vec![
        shape(
            "rotunda",
            Drawing::new().disc((0.0, 0.0), 4.2).arms((0.0, 0.0), &[N, E, S, W], FAR, 2.2),
            &[(0.0, -3.5, N), (-3.5, 0.0, E), (0.0, 3.5, S), (3.5, 0.0, W), (0.0, 0.0, N)],
            "1+ 1>3 Midline; 2+ 2>4 Midline; 1- 3>1 Midline; 2- 4>2 Midline",
        ),
        shape(
            "wide hall with a wide stem",
            Drawing::new().corridor((-FAR, 0.0), (FAR, 0.0), 4.0).corridor((0.0, 0.0), (0.0, -FAR), 2.4),
            &[(0.0, -1.5, N), (-1.0, 0.0, E), (1.0, 0.0, W)],
            "1+ >2 DeadEnd; 2+ 1>3 Midline; 1- 2> Midline; 2- 3>1 Midline",
        ),
    ]
}

/// Places with something beside them that must not count.
fn clutter() -> Vec<Shape> {
    let through = || Drawing::new().corridor((-FAR, 0.0), (FAR, 0.0), 2.2);
    let tee = || through().corridor((0.0, 0.0), (0.0, -FAR), 2.2);
    let tee_star = "1+ >2 DeadEnd; 2+ 1>3 Midline; 1- 2> Midline; 2- 3>1 Midline";
    let tee_arrivals = [(0.0, -0.8, N), (-0.8, 0.0, E), (0.8, 0.0, W)];
    vec![
        shape("T before another T", tee().corridor((7.0, 0.0), (7.0, FAR), 2.2), &tee_arrivals, tee_star),
        shape(
            "T with office doors",
            (-2..3).fold(tee(), |plan, k| {
                let x = f64::from(k) * 3.3 + 0.8;
                plan.corridor((x, 1.0), (x, 1.6), 0.9).room((x - 1.4, 1.5), (x + 1.4, 5.0))
            }),
            &tee_arrivals,
            tee_star,
        ),
        shape("T with a stub", tee().corridor((0.0, 0.0), (0.0, 3.5), 2.2), &tee_arrivals, tee_star),
        shape(
            "T with a pillar",
            tee().block((-0.2, -0.7), (0.2, -0.3)),
            &[(-0.8, 0.0, E), (0.0, -1.2, N), (0.8, 0.0, W)],
            "1+ 1>3 Midline; 2+ 2> Midline; 1- 3>1 Midline; 2- >2 DeadEnd",
        ),
        shape(
            "rotunda with a pillar",
            Drawing::new()
                .disc((0.0, 0.0), 4.2)
                .arms((0.0, 0.0), &[N, E, S, W], FAR, 2.2)
                .block((-0.2, -0.2), (0.2, 0.2)),
            &[(0.0, -3.5, N), (-3.5, 0.0, E), (0.0, 3.5, S), (3.5, 0.0, W)],
            "1+ 1>3 Midline; 2+ 2>4 Midline; 1- 3>1 Midline; 2- 4>2 Midline",
        ),
    ]
}

fn odd_angles() -> Vec<Shape> {
    vec![
        shape(
            "skew crossing",
            Drawing::new().arms((0.0, 0.0), &[E, W, 1.05, 1.05 - PI], FAR, 2.0),
            &[(-0.8, 0.0, E), (0.8, 0.0, W)],
            "1+ 1>3 Midline; 2+ 2>4 Midline; 1- 3>1 Midline; 2- 4>2 Midline",
        ),
        shape(
            "corner of a wide hall",
            Drawing::new().room((-FAR, -FAR), (FAR, FAR)).block((0.0, -2.0 * FAR), (2.0 * FAR, 0.0)),
            &[(0.5, 2.4, W)],
            "1+ >1 None; 2+ >2 None; 1- 1> RightWall; 2- 2> LeftWall",
        ),
    ]
}

fn figures() -> Vec<Shape> {
    vec![
        shape(
            "figure 3(b)",
            Drawing::new()
                .room((-2.1, -2.9), (2.1, 2.9))
                .corridor((0.0, 0.0), (0.6, FAR), 1.6)
                .corridor((0.0, 1.9), (FAR, 2.7), 1.6)
                .corridor((0.0, -1.9), (FAR, -2.7), 1.6)
                .corridor((0.0, 0.0), (0.6, -FAR), 1.6)
                .corridor((0.0, 0.0), (-FAR, 0.5), 1.6),
            &[(0.0, -1.8, N)],
            "1+ 1>4 Midline; 2+ 2> Midline; 3+ >5 DeadEnd; 4+ 3> Midline; \
             1- 4>1 Midline; 4- >3 DeadEnd; 3- 5> Midline; 2- >2 DeadEnd",
        ),
        shape(
            "figure 3(e)",
            Drawing::new().room((-FAR, 0.0), (FAR, FAR)).corridor((0.0, 1.0), (0.0, -FAR), 2.2),
            &[(1.0, 2.4, W)],
            "1+ 1>2 LeftWall; 2+ >3 None; 1- 2>1 RightWall; 2- 3> Midline",
        ),
        shape(
            "wide hall",
            Drawing::new().room((-FAR, 0.0), (FAR, 8.0)).corridor((0.0, 1.0), (0.0, -FAR), 2.2),
            &[(1.0, 2.4, W)],
            "1+ 1>2 LeftWall; 2+ >3 None; 1- 2>1 RightWall; 2- 3> Midline",
        ),
    ]
}
