//! The pages in `docs/` show commands that work, and options that exist.

mod run;

use run::Folder;
use std::path::Path;

/// The pages, and the commands whose options they explain, their own first.
const PAGES: [(&str, &[&str]); 4] = [
    ("signed-heat.md", &["sdf"]),
    ("winding.md", &["winding"]),
    ("polar-fields.md", &["field"]),
    ("repulsive.md", &["repulse", "energy", "inspect"]),
];

fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
}

#[test]
fn the_commands_of_every_page_run_in_order() {
    for (name, verbs) in PAGES {
        let folder = Folder::new();
        let text = page(name);
        let commands: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("eikona ")).collect();
        assert!(commands.iter().any(|c| c.starts_with(verbs[0])), "{name}: {commands:?}");
        for command in commands {
            folder.done(command);
        }
    }
}

#[test]
fn the_options_of_every_page_exist() {
    for (name, verbs) in PAGES {
        let help: String =
            verbs.iter().map(|verb| Folder::new().done(&format!("{verb} --help")).text()).collect();
        let text = page(name);
        let options: Vec<&str> = text
            .split('`')
            .filter_map(|word| word.strip_prefix("--"))
            .map(|word| word.split([' ', '=']).next().unwrap_or(word))
            .collect();
        assert!(options.len() > 5, "{name}: {options:?}");
        for option in options {
            assert!(help.contains(&format!("--{option}")), "{name}: --{option}");
        }
    }
}

#[test]
fn the_pictures_of_every_page_are_there() {
    for (name, _) in PAGES {
        let text = page(name);
        let images = text.split("](images/").skip(1).filter_map(|rest| rest.split(')').next());
        let images: Vec<&str> = images.collect();
        assert!(!images.is_empty(), "{name}");
        for image in images {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/images").join(image);
            assert!(path.is_file(), "{}", path.display());
        }
    }
}
