//! The whole product from outside, in one binary.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of tests fails the test")]

mod check;
mod cli;
mod cli_views;
mod docs;
mod http;
mod layers;
mod logs;
mod openapi;
mod relax;
mod worlds;
