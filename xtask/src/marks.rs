//! Tables between marks of a page that people write.

/// Puts a table between `<!-- begin NAME -->` and `<!-- end NAME -->`, if they are there.
pub fn put(text: &str, name: &str, table: &str) -> Option<String> {
    let begin = format!("<!-- begin {name} -->\n");
    let end = format!("<!-- end {name} -->");
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    Some(format!("{before}{begin}{table}{end}{after}"))
}
