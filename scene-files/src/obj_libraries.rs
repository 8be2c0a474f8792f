//! The material libraries of an OBJ file.

use crate::appearance::Appearance;
use crate::context::Context;
use crate::mtl;
use scene::SceneError;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Names are looked for in runs of at most so many words.
const MOST_WORDS: usize = 16;

/// The libraries that a file names.
#[derive(Default)]
pub(crate) struct Libraries {
    /// In the order of their first mention: later materials of one name win.
    found: Vec<PathBuf>,
    missing: Vec<String>,
    known_missing: HashSet<String>,
}

impl Libraries {
    /// Adds those of one `mtllib` statement. Names are parted by blanks, and have some: the longest run of words that is a file's name is
    /// one.
    pub(crate) fn add(&mut self, path: &Path, names: &str, context: &Context) {
        let mut rest = names.trim();
        let mut missing = String::new();
        while !rest.is_empty() {
            let ends = rest.match_indices(char::is_whitespace).map(|(at, _)| at).chain([rest.len()]);
            let ends: Vec<usize> =
                ends.take(MOST_WORDS).filter(|at| !rest[..*at].ends_with(char::is_whitespace)).collect();
            let beside = |name: &str| context.files.beside(path, name);
            // The last part of a path of the computer where the file was written, too.
            let last = |name: &str| beside(name.trim_end_matches('"').rsplit_once(['/', '\\'])?.1);
            let longest = |find: &dyn Fn(&str) -> Option<PathBuf>| {
                ends.iter().rev().find_map(|&at| Some((at, find(&rest[..at])?)))
            };
            let file = longest(&beside).or_else(|| longest(&last));
            let at = file.as_ref().map_or(ends[0], |(at, _)| *at);
            if file.is_none() {
                missing += if missing.is_empty() { "" } else { " " };
                missing += &rest[..at];
            }
            // A name that is nowhere ends where a file's name would.
            if file.is_some() || missing.to_ascii_lowercase().ends_with(".mtl") {
                self.miss(core::mem::take(&mut missing));
            }
            if let Some((_, file)) = file.filter(|(_, file)| !self.found.contains(file)) {
                self.found.push(file);
            }
            rest = rest[at..].trim_start();
        }
        self.miss(missing);
    }

    fn miss(&mut self, name: String) {
        if !name.is_empty() && self.known_missing.insert(name.clone()) {
            self.missing.push(name);
        }
    }

    /// Whether all libraries that the file names exist. False where it names none.
    pub(crate) fn are_there(&self) -> bool {
        !self.found.is_empty() && self.missing.is_empty()
    }

    /// The materials of all of them, each read once.
    pub(crate) fn appearances(
        self,
        path: &Path,
        context: &mut Context,
    ) -> Result<HashMap<String, Appearance>, SceneError> {
        let mut appearances = HashMap::new();
        for file in &self.found {
            appearances.extend(mtl::parse(file, context)?);
        }
        let consequence = "faces have the default material";
        match &self.missing[..] {
            [] => {}
            [name] => context.warn(path, format!("material library {name} does not exist: {consequence}")),
            [first, ..] => {
                let count = self.missing.len();
                context.warn(path, format!("{count} material libraries do not exist ({first}, …): {consequence}"));
            }
        }
        Ok(appearances)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Source;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    #[test]
    fn names_with_blanks_and_several_names_are_told_apart() {
        let files = ["my lib.mtl", "m.mtl", "tex/n.mtl"].map(|name| (PathBuf::from(name), b"newmtl x\n".to_vec()));
        let files: BTreeMap<_, _> = files.into();
        let mut context = Context { files: Source::new(Arc::new(files)), ..Context::default() };
        let found = |names: &str, context: &Context| {
            let mut all = Libraries::default();
            all.add(Path::new("t.obj"), names, context);
            (all.found.iter().map(|p| p.display().to_string()).collect::<Vec<_>>(), all.missing)
        };
        for (names, want, missing) in [
            ("m.mtl", &["m.mtl"][..], &[][..]),
            ("my lib.mtl", &["my lib.mtl"], &[]),
            ("my lib.mtl  m.mtl m.mtl", &["my lib.mtl", "m.mtl"], &[]),
            ("none.mtl m.mtl", &["m.mtl"], &["none.mtl"]),
            (".\\m.mtl TEX\\N.MTL", &["m.mtl", "tex/n.mtl"], &[]),
            ("no such lib.mtl", &[], &["no such lib.mtl"]),
            ("C:\\My Files\\my lib.mtl", &["my lib.mtl"], &[]),
            ("a b.mtl my lib.mtl c", &["my lib.mtl"], &["a b.mtl", "c"]),
        ] {
            let (files, lost) = found(names, &context);
            assert!(files == want && lost == missing, "{names}: {files:?} {lost:?}");
        }
        let mut many = Libraries::default();
        (0..1000).for_each(|i| many.add(Path::new("t.obj"), &format!("m.mtl x{}.mtl", i % 3), &context));
        assert_eq!(many.found.len(), 1);
        assert_eq!(many.appearances(Path::new("t.obj"), &mut context).expect("a library").len(), 1);
        assert_eq!(context.warnings.len(), 1);
    }
}
