//! The window under a display of its own: shown as ignored where there is no Xvfb, or no Vulkan driver.
#![allow(clippy::unwrap_used, reason = "in a test")]

use cosine_lobes::renderer::{Backend, Device};
use libtest_mimic::{Arguments, Failed, Trial};
use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

#[cfg(unix)]
#[path = "window/by_hand.rs"]
mod by_hand;
#[cfg(unix)]
#[path = "window/hand.rs"]
mod hand;

const PROGRAM: &str = env!("CARGO_BIN_EXE_lobes-view");

/// An X server in memory.
struct Display {
    server: Child,
    number: String,
}

impl Display {
    /// None where there is no Xvfb.
    fn open() -> Option<Self> {
        // It chooses a number, and writes it once it listens.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x860x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        let read = server.stdout.take().map(|out| BufReader::new(out).read_line(&mut number));
        let display = Self { server, number: number.trim().to_owned() };
        (matches!(read, Some(Ok(_))) && !display.number.is_empty()).then_some(display)
    }

    /// The program, which draws a picture, saves its window, and ends.
    fn smoke(&self, folder: &Path, file: &Path, arguments: &[&str]) -> Command {
        let mut command = self.program(folder);
        command.arg("--smoke").arg(file).args(arguments);
        command
    }

    /// The program.
    fn program(&self, folder: &Path) -> Command {
        let mut command = Command::new(PROGRAM);
        command
            .env("DISPLAY", format!(":{}", self.number))
            .env("XDG_RUNTIME_DIR", folder)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET");
        if std::env::var_os("LP_NATIVE_VECTOR_WIDTH").is_none() {
            command.env("LP_NATIVE_VECTOR_WIDTH", "256");
        }
        command
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A saved window.
struct Shot {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
    /// The lines that the program has written.
    said: String,
}

impl Shot {
    /// The window of the program with some arguments.
    fn take(arguments: &[&str]) -> Result<Self, Failed> {
        let display = Display::open().ok_or("there is no Xvfb")?;
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("window.png");
        let output = display.smoke(folder.path(), &file, arguments).output()?;
        let said = [&output.stdout[..], &output.stderr[..]].map(String::from_utf8_lossy).concat();
        if !output.status.success() {
            return Err(format!("{}: {said}", output.status).into());
        }
        println!("{said}");
        if let Some(shots) = std::env::var_os("SHOTS") {
            std::fs::copy(
                &file,
                Path::new(&shots).join(format!("window{}.png", arguments.concat().replace('/', "-"))),
            )?;
        }
        let decoder = png::Decoder::new(BufReader::new(std::fs::File::open(&file)?));
        let mut reader = decoder.read_info()?;
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels)?;
        Ok(Self { width: info.width as usize, height: info.height as usize, pixels, said })
    }

    /// The colours of some columns.
    fn colors(&self, columns: core::ops::Range<usize>) -> HashSet<[u8; 3]> {
        let at = |y: usize| 3 * (y * self.width + columns.start)..3 * (y * self.width + columns.end);
        (0..self.height).flat_map(|y| self.pixels[at(y)].as_chunks::<3>().0).copied().collect()
    }
}

/// The window shows the built-in scene: the picture in it has many colours, the panel beside it few.
fn shows_a_picture() -> Result<(), Failed> {
    let shot = Shot::take(&[])?;
    let (width, height) = (shot.width, shot.height);
    let (picture, panel) = (shot.colors(0..width / 2).len(), shot.colors(width - 250..width).len());
    println!("{width} × {height}: {picture} colours in the left half, {panel} in the panel");
    assert!(width > 1000 && height > 600, "{width} × {height}");
    assert!(picture > 2000 && panel < 1000, "{picture} and {panel} colours");
    Ok(())
}

/// A pixel of the floor that is taken apart: its lobes are drawn on the hemisphere, each as a curve of its colour.
fn draws_the_lobes_of_a_pixel() -> Result<(), Failed> {
    let shot = Shot::take(&["--pixel", "596,366"])?;
    let colors = shot.colors(0..shot.width / 2);
    // The curves of the diffuse lobe and of the glossy one, whose colours are nowhere else in the window.
    let is_near = |color: &[u8; 3], want: [u8; 3]| color.iter().zip(want).all(|(a, b)| a.abs_diff(b) <= 3);
    for want in [[250, 190, 90], [110, 190, 255]] {
        assert!(colors.iter().any(|color| is_near(color, want)), "{want:?}");
    }
    Ok(())
}

/// The spheres that block are drawn over the picture, and nothing else is changed.
fn draws_the_spheres_that_block() -> Result<(), Failed> {
    let (without, with) = (Shot::take(&[])?, Shot::take(&["--spheres"])?);
    let pairs = without.pixels.as_chunks::<3>().0.iter().zip(with.pixels.as_chunks::<3>().0);
    let in_picture =
        pairs.enumerate().filter(|(place, _)| place % with.width < with.width - 380 && place / with.width < 700);
    let changed: Vec<_> = in_picture.filter(|(_, (a, b))| a != b).collect();
    let cyan =
        changed.iter().filter(|(_, (a, b))| i32::from(b[2]) - i32::from(b[0]) > i32::from(a[2]) - i32::from(a[0]));
    let (count, cyan) = (changed.len(), cyan.count());
    println!("{count} pixels are others, {cyan} of them more blue");
    assert!(count > 3000 && count < 200_000 && cyan > count / 2, "{count} {cyan}");
    Ok(())
}

const SMALL: &str = r#"
image = { width = 160, height = 90 }
camera = { eye = [0.0, 2.0, 5.0], target = [0.0, 0.4, 0.0], fov = 40.0 }
materials.grey = { model = "lambert", albedo = 0.6 }
[[objects]]
name = "floor"
plane = { point = [0.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0], size = 60.0 }
material = "grey"
[[objects]]
name = "spheres"
spheres = [[-0.6, 0.6, 0.0, 0.5], [0.7, 0.4, 0.3, 0.4]]
material = "grey"
[[lights]]
kind = "sphere"
center = [1.5, 3.0, 1.0]
radius = 0.4
radiance = [40.0, 38.0, 35.0]
"#;

/// A picture that the window's GPU makes is drawn as the CPU's: without a copy on the window's own device, and with one where the driver
/// is software and nothing else is wanted.
fn draws_a_picture_of_its_own_gpu() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let scene = folder.path().join("small.toml");
    std::fs::write(&scene, SMALL)?;
    let scene = scene.to_str().ok_or("a path")?;
    let cpu = Shot::take(&[scene])?;
    let own = Shot::take(&[scene, "--gpu", "--one-device"])?;
    let apart = Shot::take(&[scene, "--gpu"])?;
    assert!(cpu.said.contains("shaded by cpu, copied"), "{}", cpu.said);
    assert!(own.said.contains(", not copied") && !own.said.contains("shaded by cpu"), "{}", own.said);
    assert!(!apart.said.contains("shaded by cpu"), "{}", apart.said);
    assert!(cpu.colors(0..cpu.width / 2).len() > 200);
    // Without the panel, and without the line of times.
    let in_picture = |place: &usize| place % cpu.width < cpu.width - 380 && place / cpu.width < 700;
    for other in [&own, &apart] {
        let pairs = cpu.pixels.as_chunks::<3>().0.iter().zip(other.pixels.as_chunks::<3>().0);
        let pairs = pairs.enumerate().filter(|(place, _)| in_picture(place)).map(|(_, pair)| pair);
        let differences: Vec<u8> = pairs.map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0)).collect();
        let (largest, others) = (differences.iter().max(), differences.iter().filter(|d| **d > 1).count());
        println!("largest difference {largest:?}, {others} of {} pixels by more than a level", differences.len());
        assert!(others * 500 < differences.len(), "{others}");
    }
    Ok(())
}

/// A window whose size changes at each frame while its device shades: wgpu refuses some of the sizes then, and the window takes them later.
fn changes_its_size_while_its_gpu_shades() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let scene = folder.path().join("larger.toml");
    std::fs::write(&scene, SMALL.replace("width = 160, height = 90", "width = 640, height = 360"))?;
    let shot = Shot::take(&[&scene.to_string_lossy(), "--gpu", "--one-device", "--shake"])?;
    assert!(shot.said.contains(", not copied"), "{}", shot.said);
    assert!((1000..=1240).contains(&shot.width) && shot.width.is_multiple_of(40), "{} × {}", shot.width, shot.height);
    assert!(shot.colors(0..shot.width / 2).len() > 200);
    Ok(())
}

/// A box over the floor of [`SMALL`] that blocks by a shadow map.
const MAPPED: &str = r#"
[[objects]]
name = "box"
box = { center = [0.0, 1.4, 0.1], size = [0.9, 0.4, 0.9] }
material = "grey"
visibility = "shadow-map"
"#;

/// The shadow map of the light: its layers in yellow to black; without one a line.
fn draws_a_shadow_map() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let (with, without) = (folder.path().join("with.toml"), folder.path().join("without.toml"));
    std::fs::write(&with, [SMALL, MAPPED].concat())?;
    std::fs::write(&without, SMALL)?;
    let [with, without] = [&with, &without].map(|path| path.to_string_lossy().into_owned());
    // The colour of near surfaces is nowhere else in the window.
    let near = |arguments: &[&str]| -> Result<usize, Failed> {
        let shot = Shot::take(arguments)?;
        let pixels = shot.pixels.as_chunks::<3>().0.iter();
        Ok(pixels.filter(|[r, g, b]| *r > 225 && (120..245).contains(g) && (60..130).contains(b)).count())
    };
    let counts = [near(&[&with, "--shadow-map"])?, near(&[&with])?, near(&[&without, "--shadow-map"])?];
    println!("{counts:?} pixels of near surfaces");
    assert!(counts[0] > 1000 + counts[1] && counts[0] > 1000 + counts[2], "{counts:?}");
    Ok(())
}

/// A file that is no scene is one line, and no window stays.
fn a_missing_file_is_one_line() -> Result<(), Failed> {
    let display = Display::open().ok_or("there is no Xvfb")?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("window.png");
    let output = display.smoke(folder.path(), &file, &["nowhere.toml"]).output()?;
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{line}");
    assert!(line.starts_with("lobes-view: error: nowhere.toml"), "{line}");
    assert!(!file.exists());
    Ok(())
}

/// The options, which need no window.
fn the_command_line() -> Result<(), Failed> {
    let run = |arguments: &[&str]| Command::new(PROGRAM).args(arguments).output();
    let help = run(&["--help"])?;
    assert!(help.status.success() && String::from_utf8_lossy(&help.stdout).contains("Usage: lobes-view [FILE]"));
    for wrong in [&["--colour"][..], &["a.toml", "b.toml"], &["--smoke"], &["--pixel", "3"], &["--pixel", "a,b"]] {
        let output = run(wrong)?;
        let line = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{line}");
    }
    Ok(())
}

fn main() {
    let arguments = Arguments::from_args();
    let display = Display::open();
    let can_show = display.is_some() && Backend::open(Device::Gpu).is_ok();
    if !can_show {
        let lacking = if display.is_some() { "a Vulkan driver" } else { "Xvfb" };
        eprintln!("tests of the window are ignored: they want {lacking}");
    }
    drop(display);
    let trials = vec![
        Trial::test("shows_a_picture", shows_a_picture).with_ignored_flag(!can_show),
        Trial::test("draws_the_lobes_of_a_pixel", draws_the_lobes_of_a_pixel).with_ignored_flag(!can_show),
        Trial::test("draws_the_spheres_that_block", draws_the_spheres_that_block).with_ignored_flag(!can_show),
        Trial::test("draws_a_picture_of_its_own_gpu", draws_a_picture_of_its_own_gpu).with_ignored_flag(!can_show),
        Trial::test("changes_its_size_while_its_gpu_shades", changes_its_size_while_its_gpu_shades)
            .with_ignored_flag(!can_show),
        Trial::test("draws_a_shadow_map", draws_a_shadow_map).with_ignored_flag(!can_show),
        #[cfg(unix)]
        Trial::test("follows_a_hand", by_hand::follows_a_hand).with_ignored_flag(!can_show),
        Trial::test("a_missing_file_is_one_line", a_missing_file_is_one_line).with_ignored_flag(!can_show),
        Trial::test("the_command_line", the_command_line),
    ];
    libtest_mimic::run(&arguments, trials).exit();
}
