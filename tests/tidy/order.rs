//! Reading order: a file names only what stands above it.
//!
//! Crates are read in the order of `lib.rs`, folders in that of `mod.rs`. A file may name the
//! modules that are declared above it, its own, and what its parents declare themselves.

use super::{CRATES, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules that name one below them, with its name or that of a folder around it.
const KNOTS: [(&str, &str); 4] = [
    // A step context owns the scratch of every method, a type of that method.
    ("msd-core::methods::context", "msd-core::methods::dormand_prince"),
    ("msd-core::methods::context", "msd-core::methods::implicit"),
    ("msd-core::methods::context", "msd-core::methods::xpbd"),
    // One recursion: holds let particles meet obstacles, and a meeting decides who is held.
    ("msd-core::methods::dormand_prince::holds", "msd-core::methods::dormand_prince::meeting"),
];

/// A module by the names from its crate down.
type Name = Vec<String>;

/// The modules of a crate: the file of each, and those it declares, in order.
type Modules = BTreeMap<Name, (PathBuf, Vec<String>)>;

fn add_module(name: Name, file: &Path, modules: &mut Modules) {
    let text = fs::read_to_string(file).expect("a source file");
    let declared = |line: &str| {
        let line = line.strip_prefix("pub(crate) ").or(line.strip_prefix("pub ")).unwrap_or(line);
        line.strip_prefix("mod ")?.strip_suffix(';').map(str::to_owned)
    };
    let children: Vec<String> = text.lines().filter_map(declared).collect();
    let folder = match file.file_stem().and_then(|stem| stem.to_str()) {
        Some("lib" | "mod") => file.with_file_name(""),
        _ => file.with_extension(""),
    };
    for child in &children {
        let alone = folder.join(format!("{child}.rs"));
        let file = if alone.exists() { alone } else { folder.join(child).join("mod.rs") };
        add_module([&name[..], std::slice::from_ref(child)].concat(), &file, modules);
    }
    modules.insert(name, (file.to_owned(), children));
}

/// The paths in a file that start with `crate` or `super`, those in braces one by one.
fn paths(text: &str) -> Vec<Vec<&str>> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut tokens, mut found) = (Vec::new(), Vec::new());
    for mut line in text.lines().map(|line| line.split("//").next().unwrap_or("")) {
        while let Some(first) = line.chars().next() {
            let end = match first {
                _ if is_word(first) => line.find(|c| !is_word(c)).unwrap_or(line.len()),
                _ if line.starts_with("::") => 2,
                _ => first.len_utf8(),
            };
            tokens.extend(Some(&line[..end]).filter(|token| !token.trim().is_empty()));
            line = &line[end..];
        }
    }
    for at in 1..tokens.len() {
        let starts = ["crate", "super"].contains(&tokens[at - 1]) && tokens[at] == "::";
        if starts && (at < 2 || tokens[at - 2] != "::") {
            add_paths(&tokens, at - 1, Vec::new(), &mut found);
        }
    }
    found
}

/// Adds the paths that start at a token, and returns the place of the first token after them.
fn add_paths<'a>(
    tokens: &[&'a str],
    mut at: usize,
    mut path: Vec<&'a str>,
    found: &mut Vec<Vec<&'a str>>,
) -> usize {
    while let Some(&token) = tokens.get(at) {
        if token == "{" {
            loop {
                at = add_paths(tokens, at + 1, path.clone(), found);
                if tokens.get(at) != Some(&",") {
                    return at + 1;
                }
            }
        }
        if token == "}" {
            return at;
        }
        path.push(token);
        at += 1;
        if tokens.get(at) != Some(&"::") {
            break;
        }
        at += 1;
    }
    found.push(path);
    at + if tokens.get(at) == Some(&"as") { 2 } else { 0 }
}

#[test]
fn paths_in_braces_are_found() {
    let found = paths("use crate::{a, b::{C as D, e},};\nsuper::super::f(g); // crate::no");
    let expected = ["crate a", "crate b C", "crate b e", "super super f"];
    assert_eq!(found.iter().map(|path| path.join(" ")).collect::<Vec<_>>(), expected);
}

/// The module that a path in another one names, or that declares what it names.
fn module(modules: &Modules, from: &Name, path: &[&str]) -> Name {
    let ups = path.iter().take_while(|&&word| word == "super").count();
    let top = if path[0] == "crate" { 1 } else { from.len().saturating_sub(ups).max(1) };
    let mut name = from[..top].to_vec();
    for word in &path[ups.max(1)..] {
        name.push((*word).to_owned());
        if !modules.contains_key(&name) {
            name.pop();
            break;
        }
    }
    name
}

/// The pairs of modules of a crate of which the first names the second, which is below it.
fn knots(folder: &str) -> BTreeSet<(String, String)> {
    let (mut modules, mut knots) = (Modules::new(), BTreeSet::new());
    let krate = folder.rsplit('/').next().unwrap_or(folder);
    add_module(vec![krate.to_owned()], &root().join(folder).join("src/lib.rs"), &mut modules);
    for (from, (file, _)) in &modules {
        let text = fs::read_to_string(file).expect("a source file");
        for path in paths(&text) {
            let to = module(&modules, from, &path);
            let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            let (_, siblings) = &modules[&from[..shared]];
            let place = |name: &Name| {
                let branch = name.get(shared)?;
                siblings.iter().position(|sibling| sibling == branch)
            };
            if place(from).zip(place(&to)).is_some_and(|(from, to)| from < to) {
                knots.insert((from.join("::"), to.join("::")));
            }
        }
    }
    knots
}

#[test]
fn a_file_names_only_what_is_above_it() {
    let found: BTreeSet<_> = CRATES.into_iter().flat_map(knots).collect();
    let is_known = |known: &(&str, &str), (from, to): &(String, String)| {
        known.0 == from && (to == known.1 || to.starts_with(&format!("{}::", known.1)))
    };
    for (from, to) in &found {
        let pair = (from.clone(), to.clone());
        let known = KNOTS.iter().any(|known| is_known(known, &pair));
        assert!(known, "{from} names {to}, which is below it in lib.rs or mod.rs");
    }
    for known in &KNOTS {
        assert!(found.iter().any(|knot| is_known(known, knot)), "{known:?} is untied");
    }
}
