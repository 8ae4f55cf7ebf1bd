//! The axioms as laws: properties that hold for all inputs, and the slow reference the engine must agree with.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of tests fails the test")]

mod engine;
mod reference;
mod strategies;
mod traces;

mod explanation;
mod golden;
mod judge;
mod measured;
mod boundary;
mod grid_walks;
mod hard_cases;
mod mirror;
mod rings;
mod theory_worlds;
mod perception;
mod minimality;
mod planarity;
mod search;
mod topology;
mod word;
