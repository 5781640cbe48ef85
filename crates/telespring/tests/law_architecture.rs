//! The floors of the core: every module imports only from the floors below it, and names each of them.

#![allow(clippy::disallowed_methods, reason = "this test reads the sources")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The modules from the ground up, each with all that it may import.
const FLOORS: [(&str, &[&str]); 18] = [
    ("error", &[]),
    ("poly", &[]),
    ("quantity", &["error"]),
    ("session", &["error", "quantity"]),
    ("model", &["error", "quantity"]),
    ("prediction", &["error", "quantity", "session"]),
    ("characteristic", &["model"]),
    ("dde", &["error", "quantity", "model"]),
    ("rig", &["error", "quantity", "model", "session"]),
    ("spectrum", &["error", "quantity", "model", "characteristic"]),
    ("delay_system", &["error", "quantity", "model", "prediction", "spectrum"]),
    ("poses", &["error", "quantity", "model", "rig", "spectrum", "delay_system"]),
    ("criteria", &["error", "quantity", "model", "poly", "characteristic", "prediction", "spectrum"]),
    ("population", &["error", "quantity", "model", "criteria"]),
    ("response", &["error", "quantity", "model", "characteristic", "criteria"]),
    ("verdicts", &["error", "quantity", "model", "poly", "characteristic", "criteria"]),
    ("study", &["error", "quantity", "session", "model", "criteria", "verdicts", "rig"]),
    ("decision", &["error", "quantity", "model", "verdicts", "rig", "study"]),
];

/// All Rust files under a folder.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// The first names of all paths that begin with `crate::`, comments left out; a group gives one per member.
fn crate_paths(source: &str) -> BTreeSet<String> {
    let code: Vec<&str> = source.lines().map(|line| line.split("//").next().unwrap_or("")).collect();
    let code = code.join("\n");
    let mut names = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        let rest = &code[at + start.len()..];
        let name = |text: &str| -> String {
            text.trim().chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect()
        };
        match rest.strip_prefix('{') {
            None => {
                names.insert(name(rest));
            }
            Some(group) => {
                let mut depth = 0;
                let mut member = String::new();
                for letter in group.chars() {
                    match letter {
                        '}' if depth == 0 => break,
                        ',' if depth == 0 => names.extend([name(&std::mem::take(&mut member))]),
                        _ => {
                            depth += i32::from(letter == '{') - i32::from(letter == '}');
                            member.push(letter);
                        }
                    }
                }
                names.insert(name(&member));
            }
        }
    }
    names.remove("");
    names
}

/// The longest chain of `super::` in the code.
fn longest_super_chain(source: &str) -> usize {
    let code = source.lines().map(|line| line.split("//").next().unwrap_or(""));
    code.map(|line| (1..8).rev().find(|&count| line.contains(&"super::".repeat(count))).unwrap_or(0))
        .max()
        .unwrap_or(0)
}

#[test]
fn law_every_module_imports_from_the_floors_below_it_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let allowed: BTreeMap<&str, &[&str]> = FLOORS.into_iter().collect();
    let mut violations = Vec::new();
    let mut imported: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in rust_files(&root) {
        let relative = file.strip_prefix(&root).unwrap();
        if relative == Path::new("lib.rs") {
            continue;
        }
        let path: Vec<String> =
            relative.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
        let module = &path[0];
        let Some(allowed) = allowed.get(module.as_str()) else {
            violations.push(format!("{module} stands on no floor"));
            continue;
        };
        let source = std::fs::read_to_string(&file).unwrap();
        for name in crate_paths(&source) {
            if name == *module {
                continue;
            }
            if !allowed.contains(&name.as_str()) {
                violations.push(format!("{} imports crate::{name}", relative.display()));
            }
            imported.entry(module.clone()).or_default().insert(name);
        }
        let depth = path.iter().filter(|part| *part != "mod").count();
        if longest_super_chain(&source) >= depth {
            violations.push(format!("{} reaches the crate root by super::", relative.display()));
        }
    }
    assert!(violations.is_empty(), "{violations:#?}");
    for (module, allowed) in FLOORS {
        let imported = imported.remove(module).unwrap_or_default();
        let unused: Vec<_> = allowed.iter().filter(|name| !imported.contains(**name)).collect();
        assert!(unused.is_empty(), "{module} need not be allowed {unused:?}");
    }
}

#[test]
fn law_a_floor_allows_only_lower_floors() {
    for (floor, (module, allowed)) in FLOORS.iter().enumerate() {
        let below: Vec<&str> = FLOORS[..floor].iter().map(|(name, _)| *name).collect();
        assert!(allowed.iter().all(|name| below.contains(name)), "{module}");
    }
}

#[test]
fn ref_imports_are_read_from_paths_and_groups() {
    let source = "use crate::{model::{Delay, Dyad}, quantity};\n// use crate::study;\nfn f() -> crate::error::Result<()> {}\n";
    let expected = ["error", "model", "quantity"].map(str::to_owned);
    assert_eq!(crate_paths(source), expected.into());
    assert_eq!(longest_super_chain("use super::super::model; // super::super::super::x"), 2);
}
