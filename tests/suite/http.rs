//! The service over its router, in-process: what clients see, route by route and fault by fault.

mod candidates;
mod client;
mod events;
mod examples;
mod faults;
mod hostile;
mod jobs;
mod maps;
mod patchwork;
mod reasons;
mod settled;
mod sockets;
mod storage;
mod ties;
mod word;
