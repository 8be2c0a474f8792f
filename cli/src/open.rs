//! `lobes view`: hands over to the program with the window, so that this one needs none of what a window needs.

use crate::args::OpenArgs;
use crate::environment;
use crate::failure::Failure;
use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = "lobes-view";

/// Starts the window, and ends as it does.
pub(crate) fn run(args: &OpenArgs) -> Result<(), Failure> {
    let own = env::current_exe().ok();
    let folders = env::var_os("PATH");
    let program = find(own.as_deref(), folders.as_deref()).ok_or_else(|| missing(args.file.as_deref()))?;
    let mut command = Command::new(&program);
    // A name that begins with a minus is a name.
    command.args(args.file.as_deref().map(|file| [OsStr::new("--"), file.as_os_str()]).into_iter().flatten());
    let status = command
        .envs(environment::of_gpu())
        .status()
        .map_err(|error| Failure::new(format_args!("{}: {error}", program.display())))?;
    match status.code() {
        Some(0) => Ok(()),
        // It has said why.
        code => Err(Failure::said(code.and_then(|code| u8::try_from(code).ok()).unwrap_or(2))),
    }
}

/// The program beside this one, else on the path.
fn find(own: Option<&Path>, path: Option<&OsStr>) -> Option<PathBuf> {
    let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
    let beside = own.and_then(Path::parent).map(Path::to_owned);
    let folders = path.map(|path| env::split_paths(path).collect::<Vec<_>>()).unwrap_or_default();
    beside.into_iter().chain(folders).map(|folder| folder.join(&name)).find(|program| program.is_file())
}

fn missing(file: Option<&Path>) -> Failure {
    let file = file.map_or_else(|| "[FILE]".to_owned(), |file| file.display().to_string());
    Failure::new(format_args!(
        "{PROGRAM} is neither beside this program nor on the path; in a checkout: cargo run --release -p \
         cosine-lobes-view -- {file}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_beside_this_one_comes_first() {
        let [near, far] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
        let path = env::join_paths([near.path().join("nowhere"), far.path().to_owned()]).unwrap();
        let own = near.path().join("lobes");
        let find = || find(Some(&own), Some(path.as_os_str()));
        assert_eq!(find(), None);
        std::fs::write(far.path().join(&name), "").unwrap();
        assert_eq!(find(), Some(far.path().join(&name)));
        std::fs::write(near.path().join(&name), "").unwrap();
        assert_eq!(find(), Some(near.path().join(&name)));
        assert!(missing(Some(Path::new("a.toml"))).message().ends_with("-p cosine-lobes-view -- a.toml"));
    }
}
