//! The time and the memory that small files take, by the counters of the system: each file is opened by a process of its own.

use crate::growth::{Growth, KINDS};
use cosine_lobes::lobe_core::oracle::Random;
use cosine_lobes::renderer::{Renderer, Settings};
use cosine_lobes::scene::load_animated;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Processor seconds that every input may take, that each of its bytes may take besides, and the most.
const SECONDS: [f64; 3] = [20.0, 60e-6, 60.0];
/// Bytes of memory that an input may take: a file of less than 1 MB takes no more.
const MEMORY: f64 = 2e9;
/// A process is ended then: on a busy machine it has had less time of a processor.
const ENDED: Duration = Duration::from_secs(300);

/// Processor seconds and the largest resident memory of this process, where the system counts them as Linux does.
fn counters() -> Option<[f64; 2]> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    let fields = stat.rsplit(')').next()?.split_whitespace();
    let ticks: f64 = fields.skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let most = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let most: f64 = most.trim().trim_end_matches(" kB").parse().ok()?;
    Some([ticks / 100.0, 1024.0 * most])
}

/// Opens a file and makes a small picture of it, as a command would, and prints the counters. Files that are refused take time as well.
pub(crate) fn open(file: &str) {
    if let Ok((mut scene, animation, _)) = load_animated(file) {
        (scene.width, scene.height) = (32, 18);
        if let Ok(mut renderer) = Renderer::new(scene, animation, Settings::default()) {
            drop(renderer.render());
        }
    }
    if let Some([seconds, memory]) = counters() {
        println!("{seconds} {memory}");
    }
}

/// The counters of a process that opens a file; none if it did not end well, or in time.
fn measure(program: &Path, file: &Path) -> Option<[f64; 2]> {
    let mut child = Command::new(program).arg("--open").arg(file).stdout(Stdio::piped()).spawn().ok()?;
    let begin = Instant::now();
    while child.try_wait().ok()?.is_none() {
        if begin.elapsed() > ENDED {
            drop(child.kill());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut numbers = text.split_whitespace().map(str::parse);
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

/// Bytes of the files of a folder. An image counts as its texels: a byte of a compressed one stands for many.
fn size(folder: &Path) -> f64 {
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let bytes = files.map(|file| match image::image_dimensions(&file) {
        Ok((width, height)) => u64::from(width) * u64::from(height),
        Err(_) => fs::metadata(&file).map_or(0, |data| data.len()),
    });
    bytes.sum::<u64>() as f64
}

/// Some inputs of each kind; prints the most that any of a kind takes, and how much that is a byte. Whether none takes too much.
pub(crate) fn run(program: &Path, seed: u64, inputs: u64) -> bool {
    if counters().is_none() {
        println!("this system does not say how much a process takes");
        return true;
    }
    println!("| kind | seconds | µs a byte | MB | bytes a byte |\n|---|---|---|---|---|");
    // All kinds, also after a failure.
    KINDS.iter().filter(|kind| !is_cheap(kind, program, seed, inputs)).count() == 0
}

fn is_cheap(kind: &Growth, program: &Path, seed: u64, inputs: u64) -> bool {
    let mut random = Random::new(seed);
    let (mut most, mut is_cheap) = ([0.0_f64; 4], true);
    for number in 0..inputs {
        let folder = tempfile::tempdir().expect("a folder for an input");
        let file = kind.write(folder.path(), &mut random);
        let size = size(folder.path());
        let taken = measure(program, &file);
        let [seconds, memory] = taken.unwrap_or([f64::INFINITY; 2]);
        // Of the smallest ones the program itself takes more.
        for (most, new) in
            most.iter_mut().zip([seconds, 1e6 * seconds / (size + 1e4), memory * 1e-6, memory / (size + 1e5)])
        {
            *most = most.max(new);
        }
        let [free, a_byte, most_seconds] = SECONDS;
        if seconds > most_seconds.min(free + a_byte * size) || memory > MEMORY {
            println!(
                "{}: input {number} of {size} bytes takes {seconds:.1} s, {:.0} MB, kept in {}",
                kind.name,
                memory * 1e-6,
                folder.keep().display()
            );
            is_cheap = false;
        }
    }
    let [seconds, a_byte, megabytes, bytes] = most;
    println!("| {} | {seconds:.2} | {a_byte:.1} | {megabytes:.0} | {bytes:.0} |", kind.name);
    is_cheap
}
