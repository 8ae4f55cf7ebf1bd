//! The import matrix: which module may import from which, proven over the text of `src`.
//!
//! Data flows one way. A `crate::` path must name a module above its own in `lib.rs`; the logic knows no
//! floats, and the core no wire types, clocks, files or global state.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Each module with the modules that it may import from, in the order of `lib.rs`.
const MATRIX: &[(&str, Imports)] = &[
    ("geometry", Only(&[])),
    ("grid", Only(&["geometry"])),
    ("sensor", Only(&["geometry", "grid"])),
    ("lpm", Only(&["geometry", "grid"])),
    ("gateway", Only(&["geometry", "grid", "lpm"])),
    ("star", Only(&["geometry", "grid", "lpm", "gateway"])),
    ("visit", AllBut(&[])),
    ("trace", Only(&["geometry", "grid", "lpm", "gateway", "star", "visit"])),
    ("worlds", Only(&["geometry", "grid", "sensor", "lpm", "star", "trace"])),
    ("map", Only(&["star"])),
    ("abduction", Only(&["star", "map"])),
    ("metric", Only(&["geometry", "star", "trace", "map", "abduction"])),
    ("patchwork", AllBut(&["gateway", "worlds", "map"])),
    ("classic", Only(&["abduction"])),
    ("reference", Only(&["geometry", "star", "trace", "abduction", "metric", "classic"])),
    ("explanation", Only(&["star", "map", "abduction"])),
    ("mending", Only(&["geometry", "lpm", "star", "trace", "abduction", "metric"])),
    ("export", AllBut(&["sensor", "visit", "metric"])),
    ("service", AllBut(&["sensor", "visit", "worlds", "reference"])),
    ("cli", AllBut(&[])),
];

/// Of the modules above one, those that it may import.
#[derive(Clone, Copy)]
enum Imports {
    Only(&'static [&'static str]),
    AllBut(&'static [&'static str]),
}
use Imports::{AllBut, Only};

impl Imports {
    fn allow(self, module: &str, import: &str) -> bool {
        let mut above = MATRIX.iter().map(|(name, _)| *name).take_while(|name| *name != module);
        match self {
            Only(allowed) => allowed.contains(&import),
            AllBut(barred) => above.any(|name| name == import) && !barred.contains(&import),
        }
    }
}

/// Modules that know neither wire types, nor clocks, files, environment or global state.
const CORE: &[&str] = &[
    "geometry",
    "grid",
    "lpm",
    "gateway",
    "star",
    "visit",
    "map",
    "abduction",
    "metric",
    "patchwork",
    "reference",
    "classic",
    "explanation",
    "mending",
];
const NOT_IN_CORE: &[&str] = &[
    "serde",
    "utoipa",
    "tokio",
    "axum",
    "std::fs",
    "std::env",
    "std::time",
    "std::net",
    "static mut",
    "Mutex",
    "OnceLock",
    "LazyLock",
    "thread_local",
];

/// Modules in which metres have no place.
const SYMBOLS_ONLY: &[&str] = &["map", "abduction", "classic", "explanation"];
const NOT_IN_SYMBOLS: &[&str] = &["f64", "f32", "nalgebra", "parry"];

#[test]
fn modules_stand_in_the_order_of_the_data_flow() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let declared: Vec<&str> =
        text.lines().filter_map(|l| l.strip_prefix("pub mod ")).filter_map(|l| l.strip_suffix(';')).collect();
    let expected: Vec<&str> = MATRIX.iter().map(|(name, _)| *name).collect();
    assert_eq!(declared, expected);
}

#[test]
fn every_import_goes_upstream() {
    let faults: Vec<String> =
        sources().iter().flat_map(|(file, (module, code))| faults(file, module, code)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The solver knows no place, no map and no scan.
#[test]
fn the_solver_of_the_patchwork_knows_poses_alone() {
    let solver = root().join("src/patchwork/pose_graph");
    let mut files = 0;
    for (file, (_, code)) in sources().iter().filter(|(file, _)| file.starts_with(&solver)) {
        let imports = code.match_indices("crate::").map(|(at, _)| &code[at + "crate::".len()..]);
        for import in imports {
            let own = import.starts_with("patchwork::pose_graph::") || import.starts_with("geometry::");
            assert!(own, "{}: {}", file.display(), import.lines().next().unwrap_or_default());
        }
        files += 1;
    }
    assert!(files > 10, "the solver was not found");
}

#[test]
fn every_file_says_what_it_is() {
    for (file, (_, text)) in sources_with_comments() {
        assert!(text.starts_with("//!"), "{}: the first line is no module documentation", file.display());
    }
}

#[test]
fn planted_faults_are_found() {
    let file = Path::new("planted.rs");
    let planted = [
        ("star", "use crate::map::TopologicalMap;"),
        ("abduction", "use crate::{star::Slot, geometry::Pose};"),
        ("abduction", "let x: f64 = 1.0;"),
        ("star", "use super::super::trace;"),
        ("map", "use serde::Serialize;"),
        ("grid", "let now = std::time::Instant::now();"),
        ("map", "static mut COUNT: usize = 0;"),
    ];
    for (module, code) in planted {
        assert!(!faults(file, module, code).is_empty(), "not found in {module}: {code}");
    }
    assert!(faults(file, "abduction", "use crate::{map::TopologicalMap, star::{SlotIndex}};").is_empty());
}

fn faults(file: &Path, module: &str, code: &str) -> Vec<String> {
    // The lifetime is no global state.
    let code = &code.replace("'static", "");
    let allowed = MATRIX.iter().find(|(name, _)| *name == module).map_or(Only(&[]), |(_, allowed)| *allowed);
    let imports = imported_modules(code)
        .into_iter()
        .filter(|import| import != module && !allowed.allow(module, import));
    let mut found: Vec<String> = imports.map(|import| format!("imports {import}")).collect();
    let top_level = file.parent().is_some_and(|folder| folder.ends_with("src"));
    if code.contains("super::super") || (top_level && code.contains("super::")) {
        found.push("climbs out of its module by super::super".into());
    }
    let mut forbid = |modules: &[&str], words: &[&str]| {
        let here = if modules.contains(&module) { words } else { &[] };
        found.extend(here.iter().filter(|word| code.contains(**word)).map(|word| format!("holds `{word}`")));
    };
    forbid(CORE, NOT_IN_CORE);
    forbid(SYMBOLS_ONLY, NOT_IN_SYMBOLS);
    found.into_iter().map(|fault| format!("{} ({module}): {fault}", file.display())).collect()
}

/// The first path segments behind `crate::`, groups opened.
fn imported_modules(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            Some(group) => found.extend(group_heads(group)),
            None => found.push(identifier(rest)),
        }
    }
    found
}

fn group_heads(group: &str) -> Vec<String> {
    let (mut depth, mut heads, mut start) = (0, Vec::new(), 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                heads.push(identifier(&group[start..at]));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                heads.push(identifier(&group[start..at]));
                start = at + 1;
            }
            _ => {}
        }
    }
    heads.retain(|head| !head.is_empty());
    heads
}

fn identifier(text: &str) -> String {
    text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Every source file with its module and its code, comments and unit tests taken out.
fn sources() -> BTreeMap<PathBuf, (String, String)> {
    let strip = |text: &str| {
        let product = text.split("#[cfg(test)]").next().unwrap_or_default();
        product.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
    };
    sources_with_comments().into_iter().map(|(file, (module, text))| (file, (module, strip(&text)))).collect()
}

fn sources_with_comments() -> BTreeMap<PathBuf, (String, String)> {
    let mut files = BTreeMap::new();
    for (folder, fixed) in [("src", None), ("worlds", Some("worlds"))] {
        collect(&root().join(folder), &mut |file| {
            let relative = file.strip_prefix(root().join(folder)).unwrap();
            let head = relative.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
            let module = fixed.map_or_else(|| head.trim_end_matches(".rs").to_owned(), str::to_owned);
            if module != "lib" && module != "main" {
                files.insert(file.to_owned(), (module, fs::read_to_string(file).unwrap()));
            }
        });
    }
    assert!(files.len() > 20, "the sources were not found");
    files
}

fn collect(folder: &Path, visit: &mut impl FnMut(&Path)) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, visit);
        } else if path.extension().is_some_and(|e| e == "rs") {
            visit(&path);
        }
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn no_test_file_is_forgotten() {
    for folder in ["tests/suite", "axioms"] {
        let main = fs::read_to_string(root().join(folder).join("main.rs")).unwrap();
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let Some(module) = name.strip_suffix(".rs").filter(|module| *module != "main") else { continue };
            assert!(main.contains(&format!("mod {module};")), "{folder}/main.rs does not declare {module}");
        }
    }
}
