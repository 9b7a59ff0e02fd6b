//! Every crate can be published by itself: it has what a registry asks for, and nothing in it is read from a folder
//! that its package lacks.

mod support;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The folder of all crates, unless this crate stands alone.
fn crates(test: &str) -> Option<PathBuf> {
    let folder = Path::new(support::REPOSITORY).join("crates");
    if !folder.join("vestibule-dat").is_dir() {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: {test}: no workspace around this crate"
        );
        return None;
    }
    folder.canonicalize().ok()
}

/// The crates that are published, as cargo sees them, by name.
fn packages(crates: &Path) -> BTreeMap<String, Value> {
    let output = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(crates)
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata");
    let packages = metadata["packages"].as_array().expect("packages").iter();
    packages
        .filter(|p| p["publish"].is_null())
        .map(|p| (p["name"].as_str().unwrap().to_owned(), p.clone()))
        .collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The texts that follow `mark` up to `end`, in quotes.
fn quoted<'a>(text: &'a str, mark: &str, end: char) -> Vec<&'a str> {
    let after = text.split(mark).skip(1);
    after
        .flat_map(|rest| {
            rest.split(end)
                .next()
                .unwrap_or_default()
                .split('"')
                .skip(1)
                .step_by(2)
        })
        .collect()
}

/// `path` without `..`, which need not exist.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

#[test]
fn no_crate_includes_a_file_from_outside_its_folder() {
    let Some(crates) = crates("files included from outside a crate") else {
        return;
    };
    let mut included = 0;
    for entry in std::fs::read_dir(&crates).unwrap() {
        let folder = entry.unwrap().path();
        let mut files = Vec::new();
        sources(&folder, &mut files);
        for file in files {
            let name = file
                .strip_prefix(&crates)
                .unwrap()
                .to_str()
                .unwrap()
                .replace('\\', "/");
            let text = std::fs::read_to_string(&file).unwrap();
            // In two parts, or this file would be found as well.
            let mut paths = quoted(&text, concat!("#[", "path = "), ']');
            for mark in [
                concat!("include_", "str!("),
                concat!("include_", "bytes!("),
                concat!("include", "!("),
            ] {
                paths.extend(quoted(&text, mark, ')'));
            }
            for path in paths {
                included += 1;
                let inside = plain(&file.parent().unwrap().join(path)).starts_with(&folder);
                // `concat!(env!("CARGO_MANIFEST_DIR"), "/../..")`
                let above = path.starts_with("/..");
                assert!(
                    inside && !above,
                    "{name} includes {path}, which its package lacks"
                );
            }
        }
    }
    assert!(included > 5, "{included}");
}

#[test]
fn every_crate_says_what_a_registry_asks_for() {
    let Some(crates) = crates("what a registry asks for") else {
        return;
    };
    for (name, package) in packages(&crates) {
        let folder = Path::new(package["manifest_path"].as_str().unwrap())
            .parent()
            .unwrap();
        assert_eq!(package["license"], "MIT OR Apache-2.0", "{name}");
        assert_eq!(package["readme"], "README.md", "{name}");
        for file in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(folder.join(file).is_file(), "{name} lacks {file}");
        }
        for field in ["description", "rust_version"] {
            assert!(package[field].is_string(), "{name}: {field}");
        }
        for field in ["keywords", "categories", "authors"] {
            let entries = package[field].as_array().unwrap().len();
            assert!((1..=5).contains(&entries), "{name}: {field}");
        }
    }
}

/// Publishing needs an order: whoever names a version of another crate comes after it.
#[test]
fn the_crates_can_be_published_one_after_the_other() {
    let Some(crates) = crates("an order to publish in") else {
        return;
    };
    let packages = packages(&crates);
    let mut waits: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, package) in &packages {
        let needed = waits.entry(name).or_default();
        for dependency in package["dependencies"].as_array().unwrap() {
            let other = dependency["name"].as_str().unwrap();
            if dependency["path"].is_null() {
                continue;
            }
            let versioned = dependency["req"] != "*";
            // A development dependency without a version is left out of the package.
            assert!(
                versioned || dependency["kind"] == "dev",
                "{name} names no version of {other}"
            );
            if versioned {
                needed.push(other);
            }
        }
    }
    while !waits.is_empty() {
        let ready: Vec<&str> = waits
            .iter()
            .filter(|(_, needed)| needed.iter().all(|n| !waits.contains_key(n)))
            .map(|(n, _)| *n)
            .collect();
        assert!(!ready.is_empty(), "these wait for each other: {waits:?}");
        waits.retain(|name, _| !ready.contains(name));
    }
}
