//! Parses TOML, and deserialises it so that all faults are found, each with its line.

use crate::faults::{Faults, once, unknown};
use crate::model::Line;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue, Deserializer, Error};

/// After so many faults, the rest of a file is not looked at.
const MOST_FAULTS: usize = 50;

/// Tables of the top level whose entries do not depend on each other.
const SECTIONS: [&str; 3] = ["keep", "stop", "output"];

/// What could be read of a file.
pub struct Read<T> {
    /// All that is not at fault.
    pub document: T,
    /// The keys of the top level that were at fault as a whole.
    pub taken_out: Vec<String>,
    /// The lines of the text.
    pub lines: Lines,
}

/// The offsets at which lines start.
pub struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Lines {
        Lines(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// Returns the line at an offset of the text.
    pub fn at(&self, offset: usize) -> Line {
        self.0.partition_point(|start| *start <= offset)
    }

    /// Returns the line on which a value starts.
    pub fn of_value<T>(&self, value: &Spanned<T>) -> Line {
        self.at(value.span().start)
    }
}

/// Parses a document and deserialises what is not at fault. `None` if it can not be parsed.
pub fn read<T: DeserializeOwned>(text: &str, faults: &mut Faults) -> Option<Read<T>> {
    let lines = Lines::of(text);
    let (mut table, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        syntax_faults(text, &table, &errors, &lines, faults);
        return None;
    }
    let mut taken_out = Vec::new();
    for _ in 0..MOST_FAULTS {
        let fault = match T::deserialize(Deserializer::from(table.clone())) {
            Ok(document) => return Some(Read { document, taken_out, lines }),
            Err(fault) => fault,
        };
        let span = fault.span();
        faults.add(span.as_ref().map(|span| lines.at(span.start)), in_words(fault.message()));
        let path = place(table.get_ref(), &span?)?;
        if let [Step::Key(key)] = path.as_slice() {
            taken_out.push(key.clone());
        }
        take_out(table.get_mut(), &path);
    }
    None
}

/// Reports what is no TOML: only the first error of a line, since others follow from it.
fn syntax_faults(text: &str, table: &Spanned<DeTable>, errors: &[Error], lines: &Lines, faults: &mut Faults) {
    let mut reported = BTreeSet::new();
    for error in errors {
        let span = error.span().unwrap_or(0..0);
        let line = lines.at(span.start);
        if reported.len() == MOST_FAULTS || !reported.insert(line) {
            continue;
        }
        let key = text.get(span.clone()).unwrap_or_default().trim_matches(['"', '\'']);
        let earlier = || {
            let earlier = earlier_key(table.get_ref(), key, span.start).map(|at| lines.at(at));
            earlier.or_else(|| earlier_header(text, line))
        };
        match error.message() {
            "duplicate key" if let Some(earlier) = earlier() => {
                faults.take(line, once(Some(earlier), line, key));
            }
            message => faults.add(line, format!("this is not TOML: {message}")),
        }
    }
}

/// Returns the line before this one that is the same. (The parser keeps only the last of several
/// headers of a table.)
fn earlier_header(text: &str, line: Line) -> Option<Line> {
    let this = text.lines().nth(line.checked_sub(1)?)?.trim();
    (1..line).zip(text.lines()).filter(|(_, other)| other.trim() == this).map(|(at, _)| at).last()
}

/// Returns where a key is given before an offset, the last of several.
fn earlier_key(table: &DeTable, key: &str, before: usize) -> Option<usize> {
    let mut found = None;
    for (other, value) in table.iter() {
        let start = other.span().start;
        if other.get_ref() == key && start < before {
            found = found.max(Some(start));
        }
        let inner = match value.get_ref() {
            DeValue::Table(table) => earlier_key(table, key, before),
            DeValue::Array(array) => array
                .iter()
                .filter_map(|element| earlier_key(element.get_ref().as_table()?, key, before))
                .max(),
            _ => None,
        };
        found = found.max(inner);
    }
    found
}

/// A step from a table or list to one of its entries.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// Returns the way to the entry that a fault is in, as a unit that can be missing: an entry of a
/// section, an element of a list of tables, or an entry of the top level.
fn place(table: &DeTable, span: &Range<usize>) -> Option<Vec<Step>> {
    let mut smallest = None;
    search(table, span, &mut Vec::new(), &mut smallest);
    let (_, mut path) = smallest?;
    let is_unit = match path.as_slice() {
        [Step::Key(key), Step::Key(_), ..] => SECTIONS.contains(&key.as_str()),
        [Step::Key(_), Step::Index(_), ..] => true,
        _ => false,
    };
    path.truncate(if is_unit { 2 } else { 1 });
    Some(path)
}

/// The length of a span with the way to what it belongs to.
type Smallest = Option<(usize, Vec<Step>)>;

/// Looks for the smallest entry that holds a span. (A table can be larger than the span of its
/// header, so that all are searched.)
fn search(table: &DeTable, span: &Range<usize>, path: &mut Vec<Step>, smallest: &mut Smallest) {
    for (key, value) in table.iter() {
        path.push(Step::Key(key.get_ref().to_string()));
        consider(key.span(), span, path, smallest);
        consider(value.span(), span, path, smallest);
        match value.get_ref() {
            DeValue::Table(table) => search(table, span, path, smallest),
            DeValue::Array(array) => {
                for (i, element) in array.iter().enumerate() {
                    path.push(Step::Index(i));
                    consider(element.span(), span, path, smallest);
                    if let DeValue::Table(table) = element.get_ref() {
                        search(table, span, path, smallest);
                    }
                    path.pop();
                }
            }
            _ => {}
        }
        path.pop();
    }
}

fn consider(own: Range<usize>, span: &Range<usize>, path: &[Step], smallest: &mut Smallest) {
    let holds = own.start <= span.start && span.end <= own.end;
    if holds && smallest.as_ref().is_none_or(|(length, _)| own.len() <= *length) {
        *smallest = Some((own.len(), path.to_vec()));
    }
}

/// Takes an entry out of a document.
fn take_out(table: &mut DeTable, path: &[Step]) {
    let [Step::Key(key), rest @ ..] = path else { return };
    let Some(value) = table.get_mut(key.as_str()) else { return };
    match (rest, value.get_mut()) {
        ([Step::Key(inner)], DeValue::Table(inside)) => {
            inside.remove(inner.as_str());
        }
        ([Step::Index(at)], DeValue::Array(array)) => {
            let mut kept = DeArray::new();
            let others = array.iter().enumerate().filter(|(i, _)| i != at);
            others.for_each(|(_, element)| kept.push(element.clone()));
            *array = kept;
        }
        _ => {
            table.remove(key.as_str());
        }
    }
}

/// Replaces the terms of serde in a message.
fn in_words(message: &str) -> String {
    let message = message.lines().next().unwrap_or_default();
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if let [word, known @ ..] = quoted.as_slice() {
        if message.starts_with("unknown field") {
            return unknown("key", word, known);
        }
        if message.starts_with("unknown variant") {
            return unknown("value", word, known);
        }
        if message.starts_with("missing field") {
            return format!("the key `{word}` is missing; add it");
        }
    }
    let words = [
        ("u64", "a whole number of 0 or more"),
        ("u32", "a whole number of 0 or more"),
        ("f64", "a number"),
        ("an array of length", "a list of length"),
        ("a boolean", "true or false"),
        ("a sequence", "a list"),
        ("sequence", "list"),
        ("invalid type: map", "invalid type: table"),
    ];
    words.into_iter().fold(message.to_string(), |text, (from, to)| text.replace(from, to))
}
