//! Runs the built command in a temporary folder.
#![allow(dead_code)] // each test file uses some of these

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A temporary folder for one test, removed on drop.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Folder {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("eikona-cli-test-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// A column of a CSV file.
    pub fn column(&self, name: &str, column: &str) -> Vec<f64> {
        let text = self.read(name);
        let mut lines = text.lines();
        let place = lines.next().unwrap().split(',').position(|c| c == column).unwrap();
        lines.map(|l| l.split(',').nth(place).unwrap().parse().unwrap()).collect()
    }

    /// The rows of the log of a run of `eikona repulse`.
    pub fn rows(&self, run: &str) -> Vec<serde_json::Value> {
        let text = self.read(&format!("{run}/log.jsonl"));
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// Compares the logs, but for times, and the frames of the same steps of two runs.
    #[track_caller]
    pub fn assert_same_run(&self, run: &str, other: &str) {
        let [rows, others] = [run, other].map(|name| {
            let mut rows = self.rows(name);
            rows.iter_mut().for_each(|row| row["seconds"] = 0.into());
            rows
        });
        assert_eq!(rows, others);
        for step in 0..rows.len() {
            let frame = |run: &str| self.bytes(&format!("{run}/frames/{step:06}.ply"));
            assert_eq!(frame(run), frame(other), "frame {step}");
        }
    }

    /// The numbers of a NumPy file of int32.
    pub fn npy(&self, name: &str) -> Vec<i32> {
        let bytes = self.bytes(name);
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
        let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!(head % 64, 0);
        let numbers: Vec<i32> =
            bytes[head..].as_chunks::<4>().0.iter().map(|b| i32::from_le_bytes(*b)).collect();
        let header = format!("{{'descr':'<i4','fortran_order':False,'shape':({},),}}", numbers.len());
        assert_eq!(String::from_utf8_lossy(&bytes[10..head]).trim_end().replace(' ', ""), header);
        numbers
    }

    /// Runs `eikona` with arguments split at spaces.
    pub fn run(&self, command: &str) -> Outcome {
        self.run_words(command.split_whitespace(), &[])
    }

    pub fn run_words<'a>(&self, words: impl IntoIterator<Item = &'a str>, stdin: &[u8]) -> Outcome {
        let mut child = Command::new(env!("CARGO_BIN_EXE_eikona"))
            .args(words)
            .current_dir(&self.0)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // This fails if the command closes its input without reading it.
        let _ = child.stdin.take().unwrap().write_all(stdin);
        let output = child.wait_with_output().unwrap();
        Outcome {
            code: output.status.code(),
            stdout: output.stdout,
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Runs a command and expects success.
    #[track_caller]
    pub fn done(&self, command: &str) -> Outcome {
        let outcome = self.run(command);
        assert_eq!(outcome.code, Some(0), "eikona {command}\n{}", outcome.stderr);
        outcome
    }

    /// Runs a command under `--strict`, and expects exit code 4 and these words in the messages.
    #[track_caller]
    pub fn warned(&self, command: &str, words: &[&str]) {
        let outcome = self.run(&format!("{command} --strict"));
        assert_eq!(outcome.code, Some(4), "eikona {command}\n{}", outcome.stderr);
        for word in words {
            assert!(outcome.stderr.contains(word), "eikona {command}: no {word:?} in\n{}", outcome.stderr);
        }
    }

    /// Runs a command and expects this exit code, these words in the message, and no new file.
    #[track_caller]
    pub fn refused(&self, command: &str, code: i32, words: &[&str]) {
        let before = self.files();
        let outcome = self.run(command);
        assert_eq!(outcome.code, Some(code), "eikona {command}\n{}", outcome.stderr);
        for word in words {
            assert!(outcome.stderr.contains(word), "eikona {command}: no {word:?} in\n{}", outcome.stderr);
        }
        assert_eq!(self.files(), before, "eikona {command} left something behind");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Result of a run.
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Outcome {
    pub fn text(&self) -> String {
        String::from_utf8(self.stdout.clone()).unwrap()
    }
}

/// The data folder. Tests that use it are ignored where it does not exist.
pub fn data() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).to_path_buf()
}

/// A flat grid of 10 x 2 unit squares as OBJ, with vertex `3 x + y` at (x, y).
pub fn grid_obj() -> String {
    let mut text = String::new();
    for i in 0..33 {
        text += &format!("v {} {} 0\n", i / 3, i % 3);
    }
    for x in 0..10 {
        for y in 0..2 {
            let a = 3 * x + y + 1;
            text += &format!("f {} {} {}\nf {} {} {}\n", a, a + 3, a + 4, a, a + 4, a + 1);
        }
    }
    text
}

/// The line x = 5 from y = 0 to y = 2, with smaller x on its left.
pub const LINE: &str =
    r#"{"eikona":"curves","version":1,"curves":[{"nodes":[{"vertex":15},{"vertex":16},{"vertex":17}]}]}"#;

/// Width and height of a PNG file.
pub fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}
