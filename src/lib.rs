//! Topostar turns what a robot saw at places and did between them into the topological map that explains it
//! best, and keeps every rival map that is still possible.
//!
//! It is the Hybrid Spatial Semantic Hierarchy of Beeson et al. (IJCAI-03 workshop, "Exploiting Local
//! Perceptual Models for Topological Map-Building") as a library, a command line and a service. Modules are
//! listed in the order in which data flows; a module imports only from modules above it, and
//! `tests/suite/layers.rs` proves it.

pub mod geometry;
pub mod grid;
pub mod sensor;
pub mod lpm;
pub mod gateway;
pub mod star;
pub mod trace;
#[path = "../worlds/mod.rs"]
pub mod worlds;
pub mod map;
pub mod abduction;
pub mod export;
pub mod service;
pub mod cli;
