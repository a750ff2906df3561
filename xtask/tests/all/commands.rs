//! The commands of xtask, run as a person would.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn xtask(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.current_dir(folder).args(arguments).output().expect("xtask starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

#[test]
fn a_quick_look_at_the_extremes_finds_no_failure_and_fills_a_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let marks = ["cells", "hardships", "distances"]
        .map(|name| format!("<!-- begin {name} -->\nold\n<!-- end {name} -->\n"));
    let page = folder.path().join("page.md");
    std::fs::write(&page, format!("# Mine\n{}", marks.concat())).unwrap();
    let arguments = ["extremes", "--quick", "--json", "--jobs", "2", "--page", "page.md"];
    let output = xtask(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let told: Value = serde_json::from_str(&text(&output.stdout)).expect("JSON");
    assert_eq!(told["failures"].as_array().map(Vec::len), Some(0));
    assert_eq!(told["cells"].as_object().map(|methods| methods.len()), Some(8));
    assert!(5000 < told["runs"].as_u64().unwrap());
    let file = |name: &str| std::fs::read_to_string(folder.path().join("extremes").join(name));
    assert!(file("rk4.svg").unwrap().starts_with("<svg"));
    assert!(file("maps.csv").unwrap().lines().count() > 5000);
    assert!(file("tables.md").unwrap().contains("| scattered |"));
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.starts_with("# Mine\n") && page.contains("| scattered |"), "{page}");
    assert!(!page.contains("\nold\n"));
}

#[test]
fn a_page_without_marks_or_among_the_files_of_the_folder_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("page.md"), "# Mine\n").unwrap();
    std::fs::write(folder.path().join("tables.md"), "# Mine\n").unwrap();
    let refused = |arguments: &[&str]| {
        let output = xtask(folder.path(), arguments);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert_eq!((text(&output.stdout).as_str(), told.lines().count()), ("", 1), "{told}");
        told
    };
    let told = refused(&["extremes", "--page", "page.md"]);
    assert!(told.contains("page.md") && told.contains("begin cells"), "{told}");
    let told = refused(&["extremes", "--out", ".", "--page", "tables.md"]);
    assert!(told.contains("the same file"), "{told}");
}

#[test]
fn the_stability_table_of_a_scene_is_printed() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = xtask(folder.path(), &["stability-table", "square"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert!(table.contains("10600") && table.contains("rk4"), "{table}");
}
