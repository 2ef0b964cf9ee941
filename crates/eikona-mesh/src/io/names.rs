//! Names of scalars, each used once.

use std::collections::{HashMap, HashSet};

/// The names given away so far.
#[derive(Default)]
pub(super) struct Names {
    used: HashSet<String>,
    /// How often a name has been asked for again.
    repeats: HashMap<String, usize>,
}

impl Names {
    /// This name if it is free, else the first free one of `name_2`, `name_3`, ...
    pub fn claim(&mut self, name: String) -> String {
        if self.used.insert(name.clone()) {
            return name;
        }
        let repeats = self.repeats.entry(name.clone()).or_insert(1);
        loop {
            *repeats += 1;
            let numbered = format!("{name}_{repeats}");
            if self.used.insert(numbered.clone()) {
                return numbered;
            }
        }
    }
}
