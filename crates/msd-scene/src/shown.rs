//! Text from outside as a message shows it: without characters that would break its line.

use std::path::Path;

/// Makes a text from a file fit to be quoted. A control character would break the line or move the
/// cursor of a terminal, and others turn the direction of the text after them.
pub fn tame(text: &str) -> String {
    let mut tame = String::with_capacity(text.len());
    for character in text.chars() {
        let is_wild = match character {
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2066}'..='\u{2069}' => true,
            '\u{2028}'..='\u{202e}' => true,
            other => other.is_control(),
        };
        if is_wild {
            tame.extend(character.escape_default());
        } else {
            tame.push(character);
        }
    }
    tame
}

/// A path as a message shows it: a name may hold control characters, and bytes that are not text.
pub fn shown_path(path: &Path) -> String {
    tame(&path.display().to_string())
}
