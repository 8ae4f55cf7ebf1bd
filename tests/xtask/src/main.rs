//! Helper tasks.
fn main() {}
