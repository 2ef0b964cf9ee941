//! All faults of a scene file, in one message.

use super::SceneError;
use super::model::Line;
use std::path::Path;

/// At most this many faults are shown.
const SHOWN: usize = 10;

/// At most this many are kept: any large text file is a scene with a fault on every line.
const KEPT: usize = 1000;

/// The faults of a scene file.
#[derive(Debug, Default)]
pub struct Faults {
    kept: Vec<(Option<Line>, String)>,
    /// How many there are beyond those that are kept.
    more: usize,
}

impl Faults {
    /// Returns a single fault.
    pub fn one(line: Option<Line>, problem: String) -> Faults {
        Faults { kept: vec![(line, problem)], more: 0 }
    }

    /// Adds a fault on a line, or one of the file as a whole.
    pub fn add(&mut self, line: impl Into<Option<Line>>, problem: impl Into<String>) {
        if self.kept.len() < KEPT {
            self.kept.push((line.into(), problem.into()));
        } else {
            self.more += 1;
        }
    }

    /// Adds the fault of a result, if it is one, and returns the value otherwise.
    pub fn take<T>(&mut self, line: Line, result: Result<T, String>) -> Option<T> {
        result.map_err(|problem| self.add(line, problem)).ok()
    }

    /// Returns whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Returns the error that lists the faults by line, if there are any.
    pub fn into_result(mut self, path: &Path) -> Result<(), SceneError> {
        // Faults of the whole file come last: the cause is often on a line.
        self.kept.sort_by_key(|(line, _)| line.unwrap_or(Line::MAX));
        let file = path.display();
        let placed: Vec<String> = self.kept.iter().map(|(line, problem)| at(*line, problem)).collect();
        match placed.as_slice() {
            [] => Ok(()),
            [fault] => Err(SceneError::Faults(format!("{file}: {fault}"))),
            faults => {
                let count = faults.len() + self.more;
                let mut message = format!("{file}: {count} faults:");
                for fault in faults.iter().take(SHOWN) {
                    message += &format!("\n  {fault}");
                }
                if count > SHOWN {
                    message += &format!("\n  and {} more", count - SHOWN);
                }
                Err(SceneError::Faults(message))
            }
        }
    }
}

fn at(line: Option<Line>, problem: &str) -> String {
    line.map_or(problem.to_string(), |line| format!("line {line}: {problem}"))
}

/// Says that a word is unknown, which one is nearest, and which ones there are.
pub fn unknown(what: &str, word: &str, known: &[&str]) -> String {
    let hint = match nearest(word, known) {
        Some(near) => format!("did you mean `{near}`? The choices are"),
        None => "the choices are".into(),
    };
    format!("there is no {what} `{}`; {hint} {}", shown(word), known.join(", "))
}

/// Returns the known word that differs from this one in at most a third of its letters.
fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    // Words of a binary file can be megabytes long.
    let word = word.chars().take(40).collect::<String>().to_ascii_lowercase();
    let distance = |known: &str| strsim::osa_distance(&word, known);
    let near = known.iter().copied().min_by_key(|known| distance(known))?;
    (distance(near) <= near.chars().count().div_ceil(3)).then_some(near)
}

/// A word as it is shown in messages: not too long, and without control characters.
pub fn shown(word: &str) -> String {
    let start: String = word.chars().take(40).collect();
    let more = if start.len() < word.len() { "..." } else { "" };
    format!("{}{more}", start.escape_debug())
}

/// Refuses what an earlier line has already said.
pub fn once(earlier: Option<Line>, line: Line, what: &str) -> Result<(), String> {
    match earlier {
        Some(earlier) => {
            Err(format!("`{what}` is given on line {earlier} and again on line {line}; keep one of them"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_fault_takes_one_line_and_more_than_ten_are_counted() {
        let path = Path::new("a.txt");
        let message = |faults: Faults| faults.into_result(path).map_err(|fault| fault.to_string());
        assert_eq!(message(Faults::default()), Ok(()));
        assert_eq!(message(Faults::one(Some(3), "odd".into())), Err("a.txt: line 3: odd".into()));
        let mut faults = Faults::one(None, "no mesh".into());
        (1..=12).rev().for_each(|line| faults.add(line, "odd"));
        let text = message(faults).unwrap_err();
        assert!(text.starts_with("a.txt: 13 faults:\n  line 1: odd\n  line 2: odd\n"), "{text}");
        assert!(text.ends_with("  line 10: odd\n  and 3 more"), "{text}");
    }

    #[test]
    fn a_near_word_is_suggested_and_a_far_one_is_not() {
        let known = ["minimize", "constrain"];
        assert!(unknown("word", "minimzie", &known).contains("did you mean `minimize`?"));
        assert!(unknown("word", "CONSTRAINT", &known).contains("did you mean `constrain`?"));
        let far = unknown("word", "frobnicate", &known);
        assert_eq!(far, "there is no word `frobnicate`; the choices are minimize, constrain");
        assert!(unknown("word", &"\u{1}x".repeat(1_000_000), &known).len() < 500);
    }
}
