//! The axioms as laws: properties that hold for all inputs, and the slow reference the engine must agree with.

mod traces;

mod golden;
mod perception;
