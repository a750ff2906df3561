//! The tables of `docs/reference/scenes.md`, made from the keys of the schema.
//!
//! A table stands between `<!-- begin keys of PATH -->` and `<!-- end keys of PATH -->`; after the
//! path `: FIRST to LAST` asks for a part of its keys. After a change of the schema renew the page
//! by `MSD_RENEW=1 cargo test -p msd-scene --test all reference`.

use msd_scene::keys::{Domain, Form, KeyRow, KeyTable};
use msd_scene::schema::SceneFile;
use std::fs;
use std::path::Path;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/scenes.md");
const BEGIN: &str = "<!-- begin keys of ";

/// The entry of a key in the column of the domain.
fn domain(key: &KeyRow) -> String {
    let words = key.domain.words();
    match (key.domain, key.form) {
        (Domain::Any, Form::Flag) => "`true`, `false`".into(),
        (Domain::Any, Form::Choice(names)) => {
            let names: Vec<String> = names().iter().map(|name| format!("`{name}`")).collect();
            names.join(", ")
        }
        (Domain::Any, Form::Table(_)) => "table".into(),
        (Domain::Any, Form::List(Form::Text, _)) => "list of names".into(),
        (Domain::Any, Form::List(Form::Choice(names), _)) => {
            let names: Vec<String> = names().iter().map(|name| format!("`{name}`")).collect();
            format!("list of {}", names.join(", "))
        }
        (Domain::Any, Form::List(..)) => "list of tables".into(),
        (Domain::Any, _) => "text".into(),
        (Domain::Filled, _) => format!("list of tables, {words}"),
        (Domain::Count(..), Form::List(..)) => format!("whole, {words} each"),
        (Domain::Count(..), _) => format!("whole, {words}"),
        (Domain::UpTo(..), Form::List(..)) => format!("three numbers, each {words}"),
        _ => words.into(),
    }
}

/// A table in Markdown, without the columns that no key has.
fn markdown(keys: &[KeyRow]) -> String {
    let has_units = keys.iter().any(|key| !key.unit.is_empty());
    let has_kinds = keys.iter().any(|key| !key.kinds.is_empty());
    let row = |cells: [&str; 6]| {
        let [name, what, unit, kinds, domain, default] = cells;
        let mut cells = vec![name, what];
        cells.extend([unit].iter().filter(|_| has_units));
        cells.extend([kinds].iter().filter(|_| has_kinds));
        format!("| {} |\n", [&cells[..], &[domain, default]].concat().join(" | "))
    };
    let head = row(["key", "what", "unit", "kinds", "domain", "default"]);
    let line = row(["---"; 6]).replace(' ', "");
    let rows = keys.iter().map(|key| {
        let kinds = if key.kinds.is_empty() { "all".into() } else { key.kinds.join(", ") };
        let default = key.default.unwrap_or("required");
        let what = key.what().strip_suffix('.').unwrap_or(key.what());
        row([&format!("`{}`", key.name), what, key.unit, &kinds, &domain(key), default])
    });
    [head, line].into_iter().chain(rows).collect()
}

/// The table at a path, and those of its keys that a mark asks for.
fn marked(mark: &str) -> (&'static KeyTable, &'static [KeyRow]) {
    let (path, range) = mark.split_once(": ").unwrap_or((mark, ""));
    let table = match path {
        "the scene" => SceneFile::TABLE,
        path => SceneFile::TABLE.find(path).and_then(|key| key.form.table()).expect(path),
    };
    let at = |name| table.keys.iter().position(|key| key.name == name).expect(name);
    let Some((first, last)) = range.split_once(" to ") else { return (table, table.keys) };
    (table, &table.keys[at(first)..=at(last)])
}

/// The page with its tables made anew, and the keys that these hold.
fn renewed(page: &str) -> (String, Vec<*const KeyRow>) {
    let mut parts = page.split(BEGIN);
    let mut text = parts.next().unwrap_or_default().to_owned();
    let mut held = Vec::new();
    for part in parts {
        let (mark, rest) = part.split_once(" -->\n").expect("the end of a mark");
        let end = format!("<!-- end keys of {mark} -->\n");
        let (_, after) = rest.split_once(&end).expect(mark);
        let (_, keys) = marked(mark);
        held.extend(keys.iter().map(std::ptr::from_ref));
        text += &format!("{BEGIN}{mark} -->\n{}{end}{after}", markdown(keys));
    }
    (text, held)
}

#[test]
fn the_page_has_every_key_with_what_the_schema_says_of_it() {
    let page = fs::read_to_string(Path::new(PAGE)).expect("the page");
    let (text, held) = renewed(&page);
    for (path, key) in SceneFile::TABLE.paths() {
        let is_held = held.iter().any(|&row| std::ptr::eq(row, key));
        assert!(is_held, "docs/reference/scenes.md has no table with {path}");
    }
    if std::env::var_os("MSD_RENEW").is_some() {
        fs::write(PAGE, &text).expect("the page");
    }
    let is_new = fs::read_to_string(PAGE).expect("the page") == text;
    assert!(
        is_new,
        "docs/reference/scenes.md: MSD_RENEW=1 cargo test -p msd-scene --test all reference"
    );
}

#[test]
fn kinds_and_needs_of_keys_name_kinds_of_their_table() {
    let tables = SceneFile::TABLE.paths();
    for (path, table) in tables.iter().filter_map(|(path, key)| Some((path, key.form.table()?))) {
        let kinds = match table.find("kind").map(|key| key.form) {
            Some(Form::Choice(names)) => names(),
            _ => &[],
        };
        for key in table.keys {
            let name = key.name;
            assert!(key.kinds.iter().all(|kind| kinds.contains(kind)), "{path}.{name}");
            assert!(key.needed.iter().all(|kind| key.kinds.contains(kind)), "{path}.{name}");
            // The two that only bodies of a material need say so in words.
            let says = key.default.is_some_and(|default| default.starts_with("required"));
            let is_conditional = ["thickness", "diameter"].contains(&name);
            assert!(is_conditional || says != key.needed.is_empty(), "{path}.{name}");
        }
    }
}
