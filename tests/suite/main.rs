//! The whole product from outside, in one binary.

mod http;
mod openapi;
mod worlds;
