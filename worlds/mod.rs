//! Worlds: data and drawings that tests, benches, the demo and the simulator share.

pub mod drawing;
