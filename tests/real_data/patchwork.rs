//! The patchwork of a recorded log, beside relations that others have checked.

use crate::data;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

/// A picture is the one that the README shows, but for the last bits of poses. `UPDATE_GOLDEN=1` rewrites that.
#[track_caller]
fn assert_shown(picture: &Path, name: &str) {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/pictures").join(name);
    if env::var_os("UPDATE_GOLDEN").is_some() {
        fs::copy(picture, &golden).unwrap();
    }
    let grey = |file: &Path| image::load_from_memory(&fs::read(file).unwrap()).unwrap().into_luma8();
    let (found, shown) = (grey(picture), grey(&golden));
    assert_eq!(found.dimensions(), shown.dimensions(), "{name}");
    let differing = found.pixels().zip(shown.pixels()).filter(|(a, b)| a != b).count();
    assert!(differing < found.pixels().len() / 1000, "{name}: {differing} pixels differ");
}

/// A particle filter's errors on the same relations are 0.049 m on the mean, and 0.079 m where loops close.
#[test]
fn the_patchwork_of_aces_is_nearer_to_checked_relations_than_a_particle_filter() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_topostar"))
        .arg("map")
        .arg(data("logs/aces.clf.bz2"))
        .arg("--relations")
        .arg(data("logs/aces.relations"))
        .args(["--json", "-o"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mean = |relations: &str, poses: &str| {
        let rows = report["poses"]["rows"].as_array().unwrap();
        let row = rows.iter().find(|row| row["relations"] == relations).unwrap();
        row[poses]["metres"][0].as_f64().unwrap()
    };
    for poses in ["odometry", "matched", "by_map", "by_scans"] {
        println!("{poses}: {:.3} m, loops {:.3} m", mean("all", poses), mean("loops", poses));
    }
    assert!(mean("all", "by_map") < 0.049 && mean("loops", "by_map") < 0.1);
    assert!(mean("all", "by_scans") < 0.049 && mean("loops", "by_scans") < 0.079);
    let strain = &report["strain"];
    println!("strain {} with {} degrees of freedom", strain["chi_square"], strain["degrees_of_freedom"]);
    assert_eq!(strain["converged"], true);
    for way in ["by_map", "by_scans"] {
        let relaxed = &strain["way"][way];
        println!("way {way}: {relaxed}");
        assert_eq!(relaxed["outcome"], "converged");
    }
    // Fourteen travels and six visits to known places; fifteen frames, of which one is held.
    assert_eq!(
        (strain["edges"].as_array().unwrap().len(), &strain["degrees_of_freedom"]),
        (20, &Value::from(18))
    );
    let way = fs::read_to_string(folder.path().join("trajectory.tum")).unwrap();
    assert_eq!(way.lines().count(), 7374);
    assert!(way.lines().all(|line| line.split(' ').count() == 8));
    let grid = fs::read(folder.path().join("patchwork.png")).unwrap();
    let grid = image::load_from_memory(&grid).unwrap().into_luma8();
    // The building is 45 m by 40 m.
    let occupied = grid.enumerate_pixels().filter(|(_, _, grey)| grey.0[0] == 0);
    let [x, y] = [0, 1].map(|axis| {
        let places = occupied.clone().map(|(x, y, _)| if axis == 0 { x } else { y });
        let (low, high) = (places.clone().min().unwrap(), places.max().unwrap());
        f64::from(high - low) * 0.05
    });
    assert!((40.0..70.0).contains(&x) && (40.0..70.0).contains(&y), "{x} {y}");
    for name in ["odometry", "patchwork"] {
        assert_shown(&folder.path().join(format!("{name}.png")), &format!("aces-{name}.png"));
    }
    let yaml = fs::read_to_string(folder.path().join("patchwork.yaml")).unwrap();
    assert!(yaml.starts_with("image: patchwork.png\n"), "{yaml}");
}
