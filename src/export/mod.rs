//! Foreign formats out.

pub mod extraction_svg;

pub use extraction_svg::extraction_svg;
