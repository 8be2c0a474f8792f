//! The tests in Python, with the module of this build: a test for each of their files. Ignored where no Python has numpy and pytest
//! (`python/set-up` fetches them). PYTHON names another interpreter.

use libtest_mimic::{Arguments, Failed, Trial};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::{env, fs, io};
use tempfile::TempDir;

/// An interpreter with all that the tests import.
fn interpreter() -> Option<PathBuf> {
    let of_check = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/venv/bin/python");
    let named = env::var_os("PYTHON").map(PathBuf::from);
    named.into_iter().chain([of_check, "python3".into()]).find(|python| {
        let mut probe = Command::new(python);
        probe.args(["-c", "import sys, numpy, pytest; sys.exit(sys.version_info < (3, 9))"]);
        probe.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    })
}

/// A folder with the package around the module that is built beside this program.
fn package() -> io::Result<TempDir> {
    let folder = tempfile::tempdir()?;
    let package = folder.path().join("cosine_lobes");
    fs::create_dir(&package)?;
    for file in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("cosine_lobes"))? {
        let file = file?;
        if file.file_type()?.is_file() {
            fs::copy(file.path(), package.join(file.file_name()))?;
        }
    }
    let built =
        env::current_exe()?.with_file_name(format!("{}_native{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX));
    let module = if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" };
    fs::copy(built, package.join(module))?;
    Ok(folder)
}

fn run(python: &Path, package: &Path, file: &Path) -> Result<(), Failed> {
    let mut tests = Command::new(python);
    tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(file);
    // Elsewhere Python would find the package without its module.
    let done = tests.current_dir(package).env("PYTHONPATH", package).env("PYTHONDONTWRITEBYTECODE", "1").output()?;
    if done.status.success() {
        return Ok(());
    }
    Err(format!("{}{}", String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr)).into())
}

fn main() -> io::Result<()> {
    let python = interpreter();
    let package = Arc::new(package()?);
    let mut trials = Vec::new();
    for file in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests"))? {
        let path = file?.path();
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if !name.starts_with("test_") || path.extension().is_none_or(|extension| extension != "py") {
            continue;
        }
        let (python, package) = (python.clone(), Arc::clone(&package));
        let is_ignored = python.is_none();
        let test = move || run(python.as_deref().unwrap_or(Path::new("python3")), package.path(), &path);
        trials.push(Trial::test(name, test).with_ignored_flag(is_ignored));
    }
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    // Leaving the process would keep the folder.
    drop(package);
    conclusion.exit()
}
