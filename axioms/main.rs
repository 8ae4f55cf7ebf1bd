//! The axioms as laws: properties that hold for all inputs, and the slow reference the engine must agree with.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of tests fails the test")]

mod engine;
mod solver;
mod strategies;
mod traces;

use topostar::reference;

mod classic;
mod classic_golden;
mod explanation;
mod clingo;
mod clingo_measured;
mod clingo_views;
mod coverage;
mod dense;
mod golden;
mod judge;
mod floor_reference;
mod layout_reference;
mod lengths_and_angles;
mod lessons;
mod measured;
mod measured_reference;
mod mending;
mod mending_reference;
mod best_first;
mod boundary;
mod grid_walks;
mod hard_cases;
mod mirror;
mod rings;
mod theory_worlds;
mod perception;
mod profile;
mod profile_reference;
mod minimality;
mod planarity;
mod registry;
mod search;
mod topology;
mod visits;
mod word;
