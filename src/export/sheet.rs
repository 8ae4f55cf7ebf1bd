//! What all drawings share: paper, ink and colours.

use svg::Document;
use svg::node::element::Rectangle;

/// Okabe and Ito's colours, told apart by colour-blind readers.
pub(super) const COLORS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d00"];
/// For what is to be read first.
pub(super) const INK: &str = "#1f2933";
/// For what explains.
pub(super) const FAINT: &str = "#7b8794";

/// For what is nearly decided otherwise.
pub(super) const DOUBTFUL: &str = "#b91c1c";

/// A white sheet of a size in user units.
pub(super) fn sheet(width: f64, height: f64) -> Document {
    Document::new()
        .set("viewBox", (0.0, 0.0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "Inter, 'DejaVu Sans', Helvetica, Arial, sans-serif")
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", "white"))
}
