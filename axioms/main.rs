//! The axioms as laws: properties that hold for all inputs, and the slow reference the engine must agree with.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of tests fails the test")]

mod classic_reference;
mod engine;
mod strategies;
mod traces;

use topostar::reference;

mod classic;
mod classic_golden;
mod explanation;
mod clingo;
mod golden;
mod judge;
mod measured;
mod best_first;
mod boundary;
mod grid_walks;
mod hard_cases;
mod mirror;
mod rings;
mod theory_worlds;
mod perception;
mod minimality;
mod planarity;
mod registry;
mod search;
mod topology;
mod visits;
mod word;
