//! Runs the real command in a fresh folder.

#![allow(dead_code, reason = "each test file uses some of it")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

/// The repository.
pub(crate) const REPOSITORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The vectors, or a notice that they are not there.
pub(crate) fn vectors(test: &str) -> Option<PathBuf> {
    vestibule_testing::vectors(test)?.canonicalize().ok()
}

/// A folder of its own to run the command in.
pub(crate) struct Sandbox {
    dir: TempDir,
}

/// What a run printed.
#[derive(Debug)]
pub(crate) struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
    pub bytes: Vec<u8>,
}

impl Sandbox {
    pub(crate) fn new() -> Self {
        Sandbox {
            dir: tempfile::tempdir().expect("a temporary folder can be made"),
        }
    }

    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }

    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.join(name)).unwrap()
    }

    pub(crate) fn run(&self, args: &[&str]) -> Ran {
        self.run_with(args, "")
    }

    pub(crate) fn run_with(&self, args: &[&str], input: &str) -> Ran {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vestibule"));
        self.spawn(command.args(args), input)
    }

    /// A line of shell, with the command on the path.
    pub(crate) fn shell(&self, line: &str) -> Ran {
        let bin = Path::new(env!("CARGO_BIN_EXE_vestibule"))
            .parent()
            .unwrap()
            .display()
            .to_string();
        let path = format!("{bin}:{}", std::env::var("PATH").unwrap_or_default());
        self.spawn(Command::new("sh").args(["-c", line]).env("PATH", path), "")
    }

    fn spawn(&self, command: &mut Command, input: &str) -> Ran {
        let mut child = command
            .current_dir(self.path())
            .env("HOME", self.path())
            .env_remove("VESTIBULE_DAT")
            .env_remove("CLICOLOR_FORCE")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        // It may end without reading.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        let output = child.wait_with_output().unwrap();
        Ran {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
            bytes: output.stdout,
        }
    }

    /// Writes the embedded world to a folder.
    pub(crate) fn build_world(&self, name: &str) -> PathBuf {
        let scene = self.write_scene(&format!("{name}.scenes"));
        self.run(&["build", scene.to_str().unwrap(), "--out", name]).ok();
        self.join(name)
    }

    /// Writes the scene of the embedded world to a folder.
    pub(crate) fn write_scene(&self, folder: &str) -> PathBuf {
        for (path, text) in vestibule::forge::EMBEDDED_SCENE {
            self.write(&format!("{folder}/{}", path.rsplit('/').next().unwrap()), text);
        }
        self.join(folder)
    }
}

impl Ran {
    /// It succeeded, without a word on stderr.
    #[track_caller]
    pub(crate) fn ok(self) -> Ran {
        assert_eq!(self.code, Some(0), "{}\n{}", self.out, self.err);
        assert_eq!(self.err, "", "a success should leave stderr alone");
        self
    }

    /// It failed with this exit code.
    #[track_caller]
    pub(crate) fn fails(self, code: i32) -> Ran {
        assert_eq!(self.code, Some(code), "{}\n{}", self.out, self.err);
        assert!(!self.err.contains("panicked"), "{}", self.err);
        self
    }

    /// What it said on stderr contains all of these.
    #[track_caller]
    pub(crate) fn says(self, wanted: &[&str]) -> Ran {
        for part in wanted {
            assert!(self.err.contains(part), "'{part}' is not in:\n{}", self.err);
        }
        self
    }

    #[track_caller]
    pub(crate) fn shows(self, wanted: &[&str]) -> Ran {
        for part in wanted {
            assert!(self.out.contains(part), "'{part}' is not in:\n{}", self.out);
        }
        self
    }

    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e} in:\n{}\n{}", self.out, self.err))
    }
}
