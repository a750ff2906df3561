//! Pages: links that lead somewhere, a complete list of pages, short sentences in plain words.

use super::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Pages beside those of `docs/`.
const PAGES: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "examples/README.md"];

/// The pages of a folder and of those in it.
fn pages_of(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of pages").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(pages_of(&path));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The lines of a page outside of blocks of code.
fn prose_and_tables(text: &str) -> Vec<&str> {
    let mut is_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        lines.push(if is_code || is_fence { "" } else { line });
    }
    lines
}

/// A line without its inline code, each of which counts as one word.
fn without_code(line: &str) -> String {
    let mut text = String::new();
    for (place, part) in line.split('`').enumerate() {
        text += if place % 2 == 0 { part } else { "code" };
    }
    text
}

/// The name by which a link reaches a heading, as GitHub and mdbook make it.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.collect::<String>().trim().replace(' ', "-")
}

fn anchors(text: &str) -> BTreeSet<String> {
    let mut seen = BTreeMap::new();
    let mut anchors = BTreeSet::new();
    for line in prose_and_tables(text) {
        let heading = line.trim_start_matches('#');
        if heading.len() < line.len() && heading.starts_with(' ') {
            let name = anchor(heading.trim());
            let count = seen.entry(name.clone()).or_insert(0);
            anchors.insert(if *count == 0 { name } else { format!("{name}-{count}") });
            *count += 1;
        }
    }
    anchors
}

/// The targets of the links and pictures of a page.
fn targets(text: &str) -> Vec<String> {
    let lines = prose_and_tables(text).join("\n");
    let text = without_code(&lines);
    let mut targets = Vec::new();
    for opening in ["](", "src=\"", "href=\""] {
        for rest in text.split(opening).skip(1) {
            let target = rest.split([')', '"', ' ', '\n']).next().unwrap_or("");
            targets.push(target.to_owned());
        }
    }
    targets
}

/// A path without `..` in it.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => assert!(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}

#[test]
fn every_link_of_a_page_leads_to_a_file_and_a_heading() {
    let mut pages: Vec<PathBuf> = PAGES.iter().map(|page| root().join(page)).collect();
    pages.extend(pages_of(&root().join("docs")));
    let mut broken = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).expect("a page");
        for target in targets(&text) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (path, heading) = target.split_once('#').unwrap_or((&target, ""));
            let folder = page.parent().expect("a folder");
            let file = if path.is_empty() { page.clone() } else { plain(&folder.join(path)) };
            let is_there = file.exists()
                && (heading.is_empty()
                    || anchors(&fs::read_to_string(&file).expect("a page")).contains(heading));
            broken.extend((!is_there).then(|| format!("{}: {target}", page.display())));
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
}

#[test]
fn the_summary_of_the_book_lists_every_page_once() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).expect("a summary");
    let mut listed: Vec<PathBuf> = targets(&summary).iter().map(|page| docs.join(page)).collect();
    listed.sort();
    let mut pages = pages_of(&docs);
    pages.retain(|page| !page.ends_with("SUMMARY.md"));
    assert_eq!(listed, pages);
}

/// The paragraphs and items of a page, without code, tables, headings and what programs wrote.
fn paragraphs(text: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    let mut is_generated = false;
    for line in prose_and_tables(text) {
        is_generated |= line.starts_with("<!-- begin");
        let is_prose = !is_generated && !line.starts_with(['|', '#', '<', '>']);
        let is_item = line.trim_start().starts_with("- ") || line.starts_with(char::is_numeric);
        if !is_prose || is_item || line.trim().is_empty() {
            paragraphs.push(String::new());
        }
        if let (true, Some(last)) = (is_prose, paragraphs.last_mut()) {
            *last += &format!("{line}\n");
        }
        is_generated &= !line.starts_with("<!-- end");
    }
    paragraphs.iter().map(|text| without_code(text)).collect()
}

/// The sentences of a paragraph; the target of a link is no part of them.
fn sentences(paragraph: &str) -> Vec<Vec<String>> {
    let mut text = String::new();
    for (place, part) in paragraph.split("](").enumerate() {
        let words =
            if place == 0 { part } else { part.split_once(')').map_or("", |(_, rest)| rest) };
        text += words;
    }
    let mut sentences = vec![Vec::new()];
    for word in text.split_whitespace() {
        if let (true, Some(last)) = (word.contains(char::is_alphanumeric), sentences.last_mut()) {
            last.push(word.to_lowercase());
        }
        let end = word.trim_end_matches([')', '*', '"', '_', ']']);
        if end.ends_with(['.', '?', '!']) {
            sentences.push(Vec::new());
        }
    }
    sentences
}

/// Words that stand for a vaguer thing than the one that is meant (`docs/contributing.md`).
const BANNED: [&str; 16] = [
    "told",
    "tell",
    "tells",
    "telling",
    "is no",
    "was no",
    "are no",
    "were no",
    "of now",
    "as it is now",
    "of this moment",
    "the present state",
    "the present setting",
    "the present shape",
    "whoever",
    "is wanted",
];

/// Numbers of which "is no more" and "is no longer" are right.
const ALLOWED: [&str; 6] =
    ["is no longer", "are no longer", "is no more", "are no more", "is no less", "there is no"];

#[test]
fn the_pages_say_it_in_short_sentences_and_plain_words() {
    let mut pages = pages_of(&root().join("docs"));
    pages.push(root().join("README.md"));
    let mut found = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).expect("a page");
        for sentence in paragraphs(&text).iter().flat_map(|paragraph| sentences(paragraph)) {
            let said = sentence.join(" ");
            let name = page.strip_prefix(root()).expect("a page").display().to_string();
            if 30 < sentence.len() {
                found.push(format!("{name}: {} words: {said}", sentence.len()));
            }
            // A clause is no subject: its sentence waits for a verb.
            let is_clause = ["what ", "whatever "].iter().any(|word| said.starts_with(word));
            found.extend((is_clause && !said.ends_with('?')).then(|| format!("{name}: {said}")));
            let mut plain = format!(" {said} ");
            ALLOWED.iter().for_each(|words| plain = plain.replace(&format!(" {words} "), " "));
            for words in BANNED {
                let is_said =
                    plain.replace([',', '.', ':', ';'], "").contains(&format!(" {words} "));
                found.extend(is_said.then(|| format!("{name}: \"{words}\": {said}")));
            }
        }
    }
    assert!(found.is_empty(), "{} sentences:\n{}", found.len(), found.join("\n"));
}

#[test]
fn sentences_and_links_are_found() {
    let page =
        "# A `key`\n\nOne [two](x.md#a-key).\nThree.\n\n```sh\nfour\n```\n\n- Five\n- six.\n";
    let of: Vec<_> = paragraphs(page).iter().flat_map(|text| sentences(text)).collect();
    let of: Vec<String> = of.iter().map(|words| words.join(" ")).collect();
    let of: Vec<&String> = of.iter().filter(|words| !words.is_empty()).collect();
    assert_eq!(of, ["one [two.", "three.", "five", "six."]);
    assert_eq!(targets(page), ["x.md#a-key"]);
    assert_eq!(anchors(page), BTreeSet::from(["a-key".to_owned()]));
}
