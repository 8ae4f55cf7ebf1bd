//! tests
mod worlds;
