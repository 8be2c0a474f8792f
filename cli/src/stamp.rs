//! The origin of a sequence's pictures, as a line that their files carry.

use crate::args::{ClockArgs, ConsoleArgs, Device, RenderArgs, ViewArgs};
use crate::console::note;
use crate::fingerprint::Fingerprint;
use cosine_lobes::read_stamp;
use cosine_lobes::scene::{Animation, Proxy, Scene};
use std::path::PathBuf;

/// Everything that decides the pictures of a sequence except the moment: the program's version, the options, the device, the loaded
/// scene, its animation, and the sphere-set files that it names.
pub(crate) struct Stamp {
    sequence: u64,
}

impl Stamp {
    pub(crate) fn new(args: &RenderArgs, device: &str, scene: &Scene, animation: &Animation) -> Self {
        // Options without effect on the pictures, or covered by scene, animation and moment.
        let view = ViewArgs {
            file: None,
            size: None,
            clock: ClockArgs::default(),
            clip: None,
            console: ConsoleArgs::default(),
            ..args.view.clone()
        };
        let options = RenderArgs {
            view,
            output: Vec::new(),
            frames: None,
            stats: None,
            repeat: 1,
            device: Device::Cpu,
            ..args.clone()
        };
        let all = Fingerprint::new().debug(&options).debug(&device).debug(scene).debug(animation);
        let sets = scene.objects.iter().filter_map(|o| match &o.proxy {
            Proxy::File { path, .. } => std::fs::read(path).ok(),
            _ => None,
        });
        Self { sequence: sets.fold(all, |all, set| all.bytes(&set)).value() }
    }

    /// The line for the picture of a moment in seconds.
    pub(crate) fn at(&self, time: f32) -> String {
        let moment = Fingerprint::new().debug(&(self.sequence, time)).value();
        format!("{} {moment:016x}", env!("CARGO_PKG_VERSION"))
    }

    /// Whether all of these files are complete and show that moment; a line on stderr for each damaged one.
    pub(crate) fn made(&self, files: &[PathBuf], time: f32, quiet: bool) -> bool {
        let line = self.at(time);
        let is = |file: &PathBuf| match read_stamp(file) {
            Ok(stamp) => stamp.is_some_and(|stamp| stamp == line),
            Err(error) => {
                if !quiet {
                    note(format_args!("lobes: warning: {error}; made anew"));
                }
                false
            }
        };
        // Reads all of them, so that each damaged one is reported.
        files.iter().filter(|file| is(file)).count() == files.len()
    }
}
