//! Topostar turns what a robot saw at places and did between them into the topological map that explains it
//! best, and keeps every rival map that is still possible.
//!
//! It is the Hybrid Spatial Semantic Hierarchy as a library, a command line and a service, after P. Beeson,
//! M. MacMahon, J. Modayil, J. Provost, F. Savelli and B. Kuipers, "Exploiting Local Perceptual Models for
//! Topological Map-Building", 2003, which is cited as *the seed* throughout.
//!
//! ```
//! use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};
//! use topostar::trace::{Experience, read_trace};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A walk of fourteen travels through nine places, as stars.
//! let (events, fault) = read_trace(&include_bytes!("../worlds/aces-stars.ndjson")[..]);
//! assert!(fault.is_none());
//!
//! let mut experience = Experience::new();
//! let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), Limits::default());
//! for event in &events {
//!     let sighting = experience.accept(event, &|_, _| unreachable!("there are no grids in this trace"))?;
//!     if let Some(sighting) = sighting {
//!         abduction.observe(&Visit::from(&sighting))?;
//!     }
//! }
//!
//! let report = abduction.report();
//! assert_eq!(report.candidates.value, 23);
//! assert!(report.unique && report.proven);
//! assert_eq!(report.minimal[0].places(), [0, 1, 2, 3, 4, 5, 6, 7, 0, 8, 4, 8, 6, 8, 2]);
//! # Ok(())
//! # }
//! ```
//!
//! Modules are listed in the order in which data flows; a module imports only from modules above it, and
//! `tests/suite/layers.rs` proves it.

pub mod geometry;
pub mod grid;
pub mod sensor;
pub mod lpm;
pub mod gateway;
pub mod star;
pub mod visit;
pub mod trace;
#[path = "../worlds/mod.rs"]
pub mod worlds;
pub mod map;
pub mod abduction;
pub mod metric;
pub mod patchwork;
pub mod classic;
pub mod reference;
pub mod explanation;
pub mod mending;
pub mod export;
pub mod service;
pub mod cli;
