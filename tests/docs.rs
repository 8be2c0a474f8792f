//! The documents beside the tree: links and paths lead somewhere, and a search for what docs/architecture.md names finds one file.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The files below a folder that git would track, by their endings.
fn files(folder: &Path, endings: &[&str], found: &mut Vec<PathBuf>) {
    for path in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "node_modules", "shared", "dist"].contains(&name) {
                files(&path, endings, found);
            }
        } else if endings.iter().any(|ending| name.ends_with(ending)) {
            found.push(path);
        }
    }
}

fn all(endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    files(Path::new(env!("CARGO_MANIFEST_DIR")), endings, &mut found);
    found
}

/// Lines of a document outside blocks of code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// The name by which a link reaches a heading.
fn anchor(heading: &str) -> String {
    let letters = heading.trim().to_lowercase();
    let letters = letters.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    letters.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// The targets of the links of a line.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

#[test]
fn links_lead_somewhere() {
    let documents = all(&[".md"]);
    assert!(documents.len() > 25, "{} documents", documents.len());
    let (mut count, mut broken) = (0, Vec::new());
    for document in &documents {
        let text = fs::read_to_string(document).expect("a document");
        for target in prose(&text).flat_map(links).filter(|target| !target.contains("://")) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { document.clone() } else { document.with_file_name(file) };
            let has_heading = || {
                let text = fs::read_to_string(&path).unwrap_or_default();
                let headings: HashSet<String> = prose(&text)
                    .filter(|line| line.starts_with('#'))
                    .map(|line| anchor(line.trim_start_matches('#')))
                    .collect();
                headings.contains(heading)
            };
            count += 1;
            if !path.exists() || !heading.is_empty() && !has_heading() {
                broken.push(format!("{}: {target}", document.display()));
            }
        }
    }
    assert!(count > 200 && broken.is_empty(), "{count} links, broken: {broken:#?}");
}

/// Paths in backquotes, such as those of tests that keep a figure.
#[test]
fn files_that_are_named_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut count, mut lost) = (0, Vec::new());
    for document in all(&[".md"]) {
        let text = fs::read_to_string(&document).expect("a document");
        for name in prose(&text).flat_map(|line| line.split('`').skip(1).step_by(2)) {
            let is_path = name.contains('/') && [".rs", ".wgsl", ".py"].iter().any(|ending| name.ends_with(ending));
            if is_path && name.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c)) {
                count += 1;
                if !root.join(name).exists() && !document.with_file_name(name).exists() {
                    lost.push(format!("{}: {name}", document.display()));
                }
            }
        }
    }
    assert!(count > 15 && lost.is_empty(), "{count} names, lost: {lost:#?}");
}

/// Each row of the table has a text that stands in the linked file alone.
#[test]
fn one_search_finds_each_place() {
    let sources: Vec<(PathBuf, String)> = all(&[".rs", ".wgsl"])
        .into_iter()
        .map(|path| (path.clone(), fs::read_to_string(path).expect("a text")))
        .collect();
    assert!(sources.len() > 800, "{} texts", sources.len());
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/architecture.md");
    let text = fs::read_to_string(&document).expect("a document");
    let (_, table) = text.split_once("## Where things are").expect("the section");
    let rows =
        table.lines().skip_while(|line| !line.starts_with("|---")).skip(1).take_while(|line| line.starts_with('|'));
    let mut count = 0;
    for row in rows {
        let search = row.split('`').nth(1).expect("a text to search for");
        let target = links(row).next().expect("a link");
        let place = document.with_file_name(target).canonicalize().expect("a file");
        let found: Vec<&Path> =
            sources.iter().filter(|(_, text)| text.contains(search)).map(|(path, _)| path.as_path()).collect();
        let found: Vec<PathBuf> = found.into_iter().map(|path| path.canonicalize().expect("a file")).collect();
        assert_eq!(found, [place], "{search}");
        count += 1;
    }
    assert!(count >= 11, "{count} rows");
}
