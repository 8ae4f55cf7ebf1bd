//! Recorded logs as inputs: CARMEN logs, ROS 2 bags as files or as the folders that `ros2 bag record` makes.

use crate::cli::failure::Failure;
use crate::cli::input::{decompressed, extension, plain_extension};
use crate::cli::{metres, pose};
use crate::geometry::Pose;
use crate::sensor::log::{
    BagEntries, BagSurvey, CarmenEntries, Entry, LogError, LogOptions, PoseChoice, ScanReader,
};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// The scans of a log in file order, and a report of what was read, passed over and guessed.
pub(super) type LogScans = ScanReader<Box<dyn Iterator<Item = Result<Entry, LogError>> + Send>>;

const HEADING: &str = "Logs";

/// What is to be said about a log where it does not say it itself, or says it wrongly.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub(super) struct LogArgs {
    /// Ranges of so many metres and more mean that nothing came back; else the log's parameters or messages tell, or
    /// it is guessed.
    #[arg(long, help_heading = HEADING, value_name = "METRES", value_parser = metres)]
    max_range: Option<f64>,
    /// The angle of the first beam, radians; else the messages tell, or it is guessed from the number of readings.
    #[arg(long, help_heading = HEADING, value_name = "RADIANS", allow_negative_numbers = true, value_parser = radians)]
    start_angle: Option<f64>,
    /// Which of the two poses of a CARMEN message to go by.
    #[arg(long, help_heading = HEADING, value_enum, value_name = "POSE")]
    pose: Option<PoseName>,
    /// Where the laser sits on the robot: x,y,heading in metres and radians; else the log tells.
    #[arg(long, help_heading = HEADING, value_name = "X,Y,THETA", value_parser = pose, allow_hyphen_values = true)]
    mount: Option<Pose>,
    /// The topic of laser scans in a bag; else the only one of its type, or /scan.
    #[arg(long, help_heading = HEADING, value_name = "TOPIC")]
    scan_topic: Option<String>,
    /// The topic of odometry in a bag; else the only one of its type, or /odom.
    #[arg(long, help_heading = HEADING, value_name = "TOPIC")]
    odom_topic: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PoseName {
    /// The robot's by its odometry.
    Robot,
    /// The laser's, which a corrected log has from its mapping.
    Laser,
}

impl LogArgs {
    fn options(&self) -> LogOptions {
        let pose = match self.pose {
            None | Some(PoseName::Robot) => PoseChoice::Robot,
            Some(PoseName::Laser) => PoseChoice::Laser,
        };
        LogOptions {
            max_range: self.max_range,
            start_angle: self.start_angle,
            pose,
            mount: self.mount,
            scan_topic: self.scan_topic.clone(),
            odom_topic: self.odom_topic.clone(),
        }
    }
}

/// Whether an input is a log by its name: a CARMEN log, a bag, or the folder of one.
pub(super) fn is_log(input: &Path) -> bool {
    let named = matches!(plain_extension(input).as_str(), "clf" | "log" | "mcap" | "db3");
    let zstd = extension(input) == "zstd" && extension(&input.with_extension("")) == "mcap";
    named || zstd || input.is_dir()
}

/// The scans of a log. Reading shows a bar on a terminal.
pub(super) fn read_log(input: &Path, args: &LogArgs) -> Result<LogScans, Failure> {
    let options = args.options();
    let entries: Box<dyn Iterator<Item = _> + Send> = match plain_extension(input).as_str() {
        "clf" | "log" if !input.is_dir() => {
            let file = opened(input, &bar(size(input)))?;
            Box::new(CarmenEntries::with_options(decompressed(input, file), &options))
        }
        _ => {
            let files = bag_files(input)?;
            // Once for what there is, once for the scans.
            let bar = bar(2 * files.iter().map(|file| size(file)).sum::<u64>());
            let open = |bar: ProgressBar| {
                move |file: PathBuf| File::open(file).map(|file| BufReader::new(bar.wrap_read(file)))
            };
            let bad = |error: LogError| Failure::input(input, error);
            let survey = BagSurvey::read(files.clone().into_iter().map(open(bar.clone()))).map_err(bad)?;
            Box::new(BagEntries::new(files.into_iter().map(open(bar)), survey, &options).map_err(bad)?)
        }
    };
    Ok(ScanReader::new(entries, options))
}

fn opened(path: &Path, bar: &ProgressBar) -> Result<impl Read + Send + use<>, Failure> {
    let file = File::open(path);
    Ok(bar.wrap_read(file.map_err(|error| Failure::input(path, format!("cannot be opened: {error}")))?))
}

fn size(path: &Path) -> u64 {
    fs::metadata(path).map(|file| file.len()).unwrap_or_default()
}

/// A bar over bytes on standard error, which draws itself on a terminal only and goes when the file is closed.
fn bar(bytes: u64) -> ProgressBar {
    let bar = ProgressBar::new(bytes).with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {bytes} of {total_bytes}  reading the log") {
        bar.set_style(style);
    }
    bar
}

/// The files of a bag in the order of recording: the recorder numbers them.
fn bag_files(input: &Path) -> Result<Vec<PathBuf>, Failure> {
    let found = if input.is_dir() {
        let listed = fs::read_dir(input).and_then(Iterator::collect::<io::Result<Vec<_>>>);
        let listed = listed.map_err(|error| Failure::input(input, format!("cannot be listed: {error}")))?;
        listed.into_iter().map(|entry| entry.path()).collect()
    } else {
        vec![input.to_owned()]
    };
    let ending = |name: &'static str| move |path: &&PathBuf| extension(path) == name;
    let mut files: Vec<PathBuf> = found.iter().filter(ending("mcap")).cloned().collect();
    files.sort_by_key(|file| recorded(file));
    if !files.is_empty() {
        return Ok(files);
    }
    let refused = if found.iter().any(|path| ending("db3")(&path)) {
        "is a bag in SQLite files, expected MCAP; convert it by `mcap convert FILE.db3 FILE.mcap`, or by `ros2 bag \
         convert`"
    } else if found.iter().any(|path| ending("zstd")(&path)) {
        "is a bag of files compressed as a whole; unpack them first by `zstd -d`"
    } else {
        "holds no .mcap file, expected a bag as `ros2 bag record -s mcap` makes it"
    };
    Err(Failure::input(input, refused))
}

/// What files of a bag are ordered by: the name without the number behind it, the number, the whole name.
fn recorded(file: &Path) -> (String, u64, PathBuf) {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    (name.to_owned(), stem[name.len()..].parse().unwrap_or_default(), file.to_owned())
}

fn radians(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(angle) if angle.abs() <= std::f64::consts::TAU => Ok(angle),
        _ => Err("expected radians, a number between minus and plus a turn".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_a_bag_are_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["run_10.mcap", "run_2.mcap", "run_0.mcap", "metadata.yaml"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let files = bag_files(folder.path()).unwrap();
        let names: Vec<_> = files.iter().map(|file| file.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["run_0.mcap", "run_2.mcap", "run_10.mcap"]);
    }

    #[test]
    fn a_log_is_known_by_the_end_of_its_name_in_any_letters() {
        for name in
            ["a.clf", "a.CLF", "a.Log.GZ", "a.log.Bz2", "a.MCAP", "a.db3", "a.mcap.zstd", "a.Mcap.ZSTD"]
        {
            assert!(is_log(Path::new(name)), "{name}");
        }
        for name in ["a.txt", "clf", "a.ndjson", "a.clf.zip", "-", "a.zstd"] {
            assert!(!is_log(Path::new(name)), "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("run_0.MCAP"), "").unwrap();
        assert_eq!(bag_files(folder.path()).unwrap().len(), 1);
    }

    #[test]
    fn other_bags_are_refused_with_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let refused = || match bag_files(folder.path()) {
            Err(Failure::Input(message)) => message,
            other => panic!("{other:?}"),
        };
        assert!(refused().contains("holds no .mcap file"));
        fs::write(folder.path().join("run_0.mcap.zstd"), "").unwrap();
        assert!(refused().contains("zstd -d"));
        fs::write(folder.path().join("run_0.db3"), "").unwrap();
        assert!(refused().contains("mcap convert"));
    }
}
