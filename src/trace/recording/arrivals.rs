//! Arrivals that somebody has marked in a log.

use thiserror::Error;

/// The moment at which a robot came to a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// The annotator's name of the place; the map never sees it.
    pub place: String,
    /// Index of the first scan at the place, counted over the scans of the log from 0.
    pub scan: usize,
}

/// A malformed list of arrivals.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {message}")]
pub struct ArrivalsFileError {
    /// Line number, from 1.
    pub line: usize,
    /// What was found and expected.
    pub message: String,
}

impl Arrival {
    /// Reads arrivals from CSV with the columns `place` and `raw_scan_index`; lines that start with # are left out.
    pub fn read_csv(text: &str) -> Result<Vec<Arrival>, ArrivalsFileError> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty());
        let wrong =
            |line: usize, message: &str| ArrivalsFileError { line: line + 1, message: message.into() };
        let (first, header) =
            lines.next().ok_or(wrong(0, "is missing, expected a header with place,raw_scan_index"))?;
        let column = |name: &str| {
            let found = header.split(',').position(|cell| cell.trim() == name);
            found.ok_or_else(|| {
                wrong(first, &format!("has no column {name}, expected place and raw_scan_index"))
            })
        };
        let (place, scan) = (column("place")?, column("raw_scan_index")?);
        let arrival = |(line, text): (usize, &str)| {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            let cell =
                |at: usize| cells.get(at).copied().ok_or(wrong(line, "has fewer columns than the header"));
            let index = cell(scan)?;
            let scan = index
                .parse()
                .map_err(|_| wrong(line, &format!("has `{index}` as raw_scan_index, expected a number")))?;
            Ok(Arrival { place: cell(place)?.into(), scan })
        };
        lines.map(arrival).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_malformed_list_of_arrivals_is_refused_by_line() {
        let read = |text: &str| Arrival::read_csv(text).map_err(|error| error.to_string());
        let good = read("# a comment\nvisit,place,raw_scan_index\n0,N, 12\n").unwrap();
        assert_eq!(good, [Arrival { place: "N".into(), scan: 12 }]);
        for (text, fault) in [
            ("", "line 1: is missing"),
            ("visit,place\n0,N\n", "line 1: has no column raw_scan_index"),
            ("place,raw_scan_index\nN,x\n", "line 2: has `x`"),
            ("place,raw_scan_index\nN\n", "line 2: has fewer columns"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(fault), "{error}");
        }
    }

    #[test]
    fn arrivals_are_read_from_what_spreadsheets_write() {
        let text = "\u{feff}place,raw_scan_index\r\n# a remark\r\nN,7\r\n";
        assert_eq!(Arrival::read_csv(text), Ok(vec![Arrival { place: "N".into(), scan: 7 }]));
    }
}
