//! Names: first lines of modules, names of types, homes of methods, sizes of folders.

use super::{CRATES, FOLDERS, root, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Words with which a question begins, or a riddle.
const QUESTIONS: &str = "What How When Where Which Who Whose Why Whether Does Do Is Are Can May By";

#[test]
fn the_first_line_of_a_module_names_what_it_holds() {
    for file in FOLDERS.iter().flat_map(|folder| sources(&root().join(folder))) {
        let text = fs::read_to_string(&file).expect("a source file");
        let docs = text.lines().map_while(|line| line.strip_prefix("//!"));
        let opening: String = docs.take_while(|line| !line.is_empty()).collect();
        let first = opening.split_whitespace().next().unwrap_or("");
        let asks = opening.contains('?') || QUESTIONS.split(' ').any(|word| word == first);
        assert!(!asks, "{} asks:{opening}", file.display());
    }
}

/// The crates: folder, and files with the code that is no test.
fn crates() -> Vec<(String, Vec<(String, String)>)> {
    let mut crates = Vec::new();
    for folder in CRATES {
        let source = root().join(folder).join("src");
        let mut files = Vec::new();
        for file in sources(&source) {
            let text = fs::read_to_string(&file).expect("a source file");
            let code = text.split("#[cfg(test)]").next().unwrap_or("").to_owned();
            let name = file.strip_prefix(&source).expect("a file of the folder");
            files.push((name.to_string_lossy().into_owned(), code));
        }
        crates.push((folder.to_owned(), files));
    }
    crates
}

/// The type that a line declares.
fn declared(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let line = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.trim_start(),
        None => line,
    };
    let name = ["struct ", "enum ", "trait "].iter().find_map(|kind| line.strip_prefix(kind))?;
    name.split(|c: char| !c.is_alphanumeric()).next()
}

/// Types of one name in one crate.
const NAMESAKES: [(&str, &str); 5] = [
    // One for each method, read with the name of its module.
    ("crates/msd-core", "Scratch"),
    // A particle that obstacles hold, by the law of the adaptive and of the implicit methods.
    ("crates/msd-core", "Hold"),
    ("crates/msd-core", "Holds"),
    // The derivative of the force: of a spring, and of all elements of a stage.
    ("crates/msd-core", "Tangent"),
    // An obstacle at a particle and a stretch of time, at the end of a substep and within one.
    ("crates/msd-core", "Span"),
];

#[test]
fn a_name_is_given_to_one_type_of_a_crate() {
    let mut found = BTreeSet::new();
    for (krate, files) in &crates() {
        let mut homes = BTreeMap::new();
        for (file, code) in files {
            for name in code.lines().filter_map(declared) {
                let home: &str = homes.entry(name).or_insert(file);
                let is_known = NAMESAKES.contains(&(krate, name));
                assert!(home == file || is_known, "{krate}: {name} is in {home} and {file}");
                found.extend((home != file).then_some((krate.clone(), name.to_owned())));
            }
        }
    }
    for (krate, name) in NAMESAKES {
        assert!(found.contains(&(krate.into(), name.into())), "{krate} has one {name} only");
    }
}

/// The types with methods of their own in a file.
fn implemented(code: &str) -> Vec<&str> {
    let mut types = Vec::new();
    for block in code.split("\nimpl").skip(1) {
        let header = block.split('{').next().unwrap_or("");
        let mut depth = 0;
        let generics = header.find(|c| {
            depth += i32::from(c == '<') - i32::from(c == '>');
            depth == 0
        });
        let rest = header[generics.unwrap_or(0)..].trim_start_matches('>').trim();
        let name = rest.split(|c: char| !c.is_alphanumeric() && c != ':').next().unwrap_or("");
        let is_of_trait = rest.contains(" for ");
        types.extend((!is_of_trait).then(|| name.rsplit(':').next().unwrap_or(name)));
    }
    types
}

#[test]
fn methods_stand_in_the_folder_of_their_type() {
    let code = "\nimpl<R: Real> Own<R> {\n}\nimpl Debug for Other {\n}\nimpl a::Third {\n}";
    assert_eq!(implemented(code), ["Own", "Third"]);
    for (krate, files) in &crates() {
        let room = |file: &str| file.split(['/', '.']).next().unwrap_or("").to_owned();
        let mut rooms: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for (file, code) in files {
            for name in code.lines().filter_map(declared) {
                rooms.entry(name).or_default().insert(room(file));
            }
        }
        for (file, code) in files {
            for name in implemented(code) {
                let is_home = rooms.get(name).is_none_or(|rooms| rooms.contains(&room(file)));
                assert!(is_home, "{krate}: {file} has methods of {name} of {:?}", rooms[name]);
            }
        }
    }
}

#[test]
fn a_folder_has_at_most_fourteen_files() {
    let mut counts = BTreeMap::new();
    for file in FOLDERS.iter().flat_map(|folder| sources(&root().join(folder))) {
        let folder = file.parent().expect("a folder").to_owned();
        // Tests stand side by side: they are found by their names.
        if !folder.ends_with("tests") && !folder.ends_with("tests/all") {
            *counts.entry(folder).or_insert(0) += 1;
        }
    }
    for (folder, count) in counts {
        assert!(count <= 14, "{} has {count} files", folder.display());
    }
}
