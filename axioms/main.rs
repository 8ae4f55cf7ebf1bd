//! tests

mod perception;
