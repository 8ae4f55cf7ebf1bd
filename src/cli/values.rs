//! Numbers with a unit on the command line, each with what was expected where it is none.

use crate::grid::occupancy::RESOLUTIONS;
use std::time::Duration;

/// Seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.ok_or_else(|| "expected seconds, a number from 0 to 1e19".into())
}

/// Bytes, or a number of KiB, MiB or GiB.
pub(super) fn bytes(text: &str) -> Result<usize, String> {
    let (number, unit) = match text.char_indices().next_back() {
        Some((end, 'K')) => (&text[..end], 1 << 10),
        Some((end, 'M')) => (&text[..end], 1 << 20),
        Some((end, 'G')) => (&text[..end], 1 << 30),
        _ => (text, 1),
    };
    let number: usize =
        number.parse().map_err(|_| format!("`{text}` is no number of bytes, expected such as 64M"))?;
    number.checked_mul(unit).filter(|&bytes| bytes > 0).ok_or_else(|| format!("{text} is out of range"))
}

/// Standard deviations.
pub(super) fn sigmas(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(width) if width.is_finite() && width > 0.0 => Ok(width),
        _ => Err("expected standard deviations, a number above 0".into()),
    }
}

/// Metres of a side of a cell.
pub(super) fn resolution(text: &str) -> Result<f64, String> {
    let (least, most) = (RESOLUTIONS.start(), RESOLUTIONS.end());
    let side = text.parse().ok().filter(|side| RESOLUTIONS.contains(side));
    side.ok_or_else(|| format!("expected metres a cell, a number from {least} to {most}"))
}
