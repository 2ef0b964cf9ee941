//! Unique names for scalars.

use std::collections::{HashMap, HashSet};

/// Names in use.
#[derive(Default)]
pub(super) struct Names {
    used: HashSet<String>,
    /// The last number appended to a name that was already in use.
    repeats: HashMap<String, usize>,
}

impl Names {
    /// Reserves `name`, or if it is taken the first free one of `name_2`, `name_3`, ...
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
