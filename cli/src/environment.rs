//! Variables that Vulkan's drivers read. They read them when they are loaded, and a program cannot change its own
//! without unsafe code: so it starts itself anew, before it has done anything.

use crate::args::{Command, Device, TradeDevice};
use std::ffi::OsString;
use std::path::Path;

/// If a GPU is requested and the environment lacks a variable, replaces the program by itself with that variable set. It stays the same
/// process, so signals, exit code and files are unchanged. If this fails the program goes on, only louder or slower.
pub(crate) fn prepare(command: &Command) {
    let wants_gpu = match command {
        Command::Render(args) => args.device != Device::Cpu,
        Command::Trade(args) => args.device.contains(&TradeDevice::Gpu),
        _ => false,
    };
    if wants_gpu {
        let lacking = of_gpu();
        if !lacking.is_empty() {
            start_anew(&lacking);
        }
    }
}

/// The variables that a program with a GPU lacks.
pub(crate) fn of_gpu() -> Vec<(&'static str, &'static str)> {
    lacking(|name| std::env::var_os(name), has_avx512())
}

/// The variables to set, in an environment that `get` reads.
fn lacking(get: impl Fn(&str) -> Option<OsString>, has_avx512: bool) -> Vec<(&'static str, &'static str)> {
    let mut lacking = Vec::new();
    let is_absolute = |name| get(name).is_some_and(|value| Path::new(&value).is_absolute());
    // Mesa's layer that sorts devices asks a Wayland display which one it uses, and the library complains on stderr where there is
    // no folder to find the display in. With an absolute name it tries that instead, and is silent.
    if get("WAYLAND_SOCKET").is_none() && !is_absolute("XDG_RUNTIME_DIR") && !is_absolute("WAYLAND_DISPLAY") {
        lacking.push(("WAYLAND_DISPLAY", "/dev/null"));
    }
    // The width of vectors of Mesa's software driver, whose compiler takes a quarter longer for 512 bits. 256 is its own default, as
    // far as it is known.
    if has_avx512 && get("LP_NATIVE_VECTOR_WIDTH").is_none() {
        lacking.push(("LP_NATIVE_VECTOR_WIDTH", "256"));
    }
    lacking
}

fn has_avx512() -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let has = std::arch::is_x86_feature_detected!("avx512f");
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let has = false;
    has
}

/// Returns only where it could not be done.
#[cfg(all(unix, not(target_vendor = "apple")))]
fn start_anew(variables: &[(&str, &str)]) {
    use std::os::unix::process::CommandExt;
    let Ok(program) = std::env::current_exe() else { return };
    let mut args = std::env::args_os();
    let mut command = std::process::Command::new(program);
    if let Some(name) = args.next() {
        command.arg0(name);
    }
    // Every variable is there afterwards, so this happens once.
    let _ = command.args(args).envs(variables.iter().copied()).exec();
}

/// These have neither Wayland nor Mesa.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
fn start_anew(_: &[(&str, &str)]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_missing_is_set() {
        let lacking = |there: &[(&str, &str)], has_avx512| {
            let find =
                |name: &str| there.iter().find(|(known, _)| *known == name).map(|(_, value)| OsString::from(value));
            lacking(find, has_avx512).into_iter().map(|(name, _)| name).collect::<Vec<_>>()
        };
        let (folder, width) = (("XDG_RUNTIME_DIR", "/run/user/0"), ("LP_NATIVE_VECTOR_WIDTH", "512"));
        let [display, name] = ["WAYLAND_DISPLAY", "LP_NATIVE_VECTOR_WIDTH"];
        assert_eq!(lacking(&[], true), [display, name]);
        assert_eq!(lacking(&[], false), [display]);
        assert_eq!(lacking(&[folder], true), [name]);
        assert!(lacking(&[folder, width], true).is_empty());
        assert_eq!(lacking(&[width, ("XDG_RUNTIME_DIR", "here")], true), [display]);
        for there in [("WAYLAND_DISPLAY", "/run/display"), ("WAYLAND_SOCKET", "5")] {
            assert!(lacking(&[there], false).is_empty());
        }
        // After it was set.
        assert!(lacking(&[(display, "/dev/null"), (name, "256")], true).is_empty());
    }
}
