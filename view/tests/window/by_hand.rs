//! One window under a hand: it drags the lamp, looks into a pixel, takes steps back, turns the camera, and goes through all views.

use crate::Display;
use crate::hand::{CONTROL, ESCAPE, F, Hand, SHIFT, Screen, V, Z};
use cosine_lobes::glam::{Vec2, Vec3};
use cosine_lobes::scene::load;
use cosine_lobes::session::Projection;
use libtest_mimic::Failed;
use std::collections::HashSet;
use std::path::Path;
use std::time::Duration;

/// A sphere that casts a shadow onto a floor, under a lamp that the camera sees.
const SCENE: &str = r#"
image = { width = 320, height = 180 }
camera = { eye = [0.0, 2.0, 5.0], target = [0.0, 0.8, 0.0], fov = 45.0 }
materials.grey = { model = "modified-phong", kd = [0.5, 0.4, 0.3], ks = 0.2, exponent = 30 }
[[objects]]
name = "floor"
plane = { point = [0.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0], size = 60.0 }
material = "grey"
[[objects]]
name = "sphere"
sphere = { center = [0.0, 0.6, 0.0], radius = 0.5 }
material = "grey"
[[lights]]
kind = "sphere"
center = [1.6, 1.9, 0.6]
radius = 0.3
radiance = 60
"#;

/// The background beside the picture.
const BESIDE: [u8; 3] = [24; 3];

/// The arrow along x.
const ARROW: [u8; 3] = [240, 90, 80];

/// The part of the window that shows the picture.
#[derive(Clone, Copy)]
struct Stage {
    left: f32,
    top: f32,
    size: Vec2,
}

impl Stage {
    /// Found by the stripes above and below a picture that is wider than its place.
    fn of(screen: &Screen) -> Option<Self> {
        let column = |y: usize| screen.at(4, y);
        let top = (0..400).find(|y| column(*y) != BESIDE)?;
        let width = (4..screen.width).find(|x| screen.at(*x, top / 2) != BESIDE)?;
        let bottom = (top + 1..screen.pixels.len() / screen.width).find(|y| column(*y) == BESIDE)?;
        let size = Vec2::new(width as f32, (bottom - top) as f32);
        ((size.x / size.y - 16.0 / 9.0).abs() < 0.01).then_some(Self { left: 0.0, top: top as f32, size })
    }

    fn place(&self, part: Vec2) -> [f32; 2] {
        (Vec2::new(self.left, self.top) + part * self.size).to_array()
    }

    /// The pixels of the picture, row by row, without its edges.
    fn pixels<'s>(&self, screen: &'s Screen) -> impl Iterator<Item = ([f32; 2], &'s [u8; 3])> {
        let (left, top) = (self.left as usize + 2, self.top as usize + 2);
        let (width, height) = (self.size.x as usize - 4, self.size.y as usize - 4);
        let row = move |y: usize| (left..left + width).map(move |x| ([x as f32, y as f32], x + y * screen.width));
        (top..top + height).flat_map(row).map(|(place, at)| (place, &screen.pixels[at]))
    }

    /// The part of the pixels that differ by more than some levels.
    fn difference(&self, a: &Screen, b: &Screen) -> f32 {
        let pairs = self.pixels(a).zip(self.pixels(b));
        let differs = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 6);
        pairs.filter(|((_, a), (_, b))| differs(a, b)).count() as f32 / (self.size.x * self.size.y)
    }

    /// The middle of the shadow on the floor: of the darkest pixels below the horizon.
    fn shadow(&self, screen: &Screen) -> Vec2 {
        let floor = self.top + 0.55 * self.size.y;
        let is_dark = |place: &[f32; 2], [r, g, b]: &[u8; 3]| place[1] > floor && *r.max(g).max(b) < 8;
        let dark =
            self.pixels(screen).filter(|(place, color)| is_dark(place, color)).map(|(place, _)| Vec2::from(place));
        let (sum, count) = dark.fold((Vec2::ZERO, 0.0), |(sum, count), place| (sum + place, count + 1.0));
        sum / count
    }

    fn colors(&self, screen: &Screen) -> usize {
        self.pixels(screen).map(|(_, color)| *color).collect::<HashSet<_>>().len()
    }
}

/// Keeps a picture of the screen where that is wanted.
fn keep(screen: &Screen, name: &str) -> Result<(), Failed> {
    let Some(shots) = std::env::var_os("SHOTS") else { return Ok(()) };
    let file = std::fs::File::create(Path::new(&shots).join(format!("hand-{name}.png")))?;
    let height = screen.pixels.len() / screen.width;
    let mut encoder = png::Encoder::new(file, screen.width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(screen.pixels.as_flattened())?;
    Ok(())
}

const WHOLE: [u16; 2] = [1320, 780];

pub(crate) fn follows_a_hand() -> Result<(), Failed> {
    let display = Display::open().ok_or("there is no Xvfb")?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE)?;
    let mut program = display.program(folder.path()).arg(&path).spawn()?;
    let tried = try_all(&display, program.id(), &path);
    let ended = program.try_wait()?;
    program.kill()?;
    program.wait()?;
    tried?;
    assert!(ended.is_none(), "it ended by itself: {ended:?}");
    Ok(())
}

fn try_all(display: &Display, program: u32, path: &Path) -> Result<(), Failed> {
    let mut hand = Hand::new(&display.number, program)?;
    let is_there = |screen: &Screen| Stage::of(screen).is_some_and(|stage| stage.colors(screen) > 200);
    let first = hand.wait_for(WHOLE, Duration::from_secs(1), "the picture", is_there)?;
    let stage = Stage::of(&first).ok_or("no picture")?;
    keep(&first, "first")?;
    hand.focus()?;

    // A lamp to the left: its shadow goes to the right.
    let camera = load(path)?.camera;
    let mark = Projection::new(camera, stage.size).pixel(Vec3::new(1.6, 1.9, 0.6)).ok_or("the lamp is not seen")?;
    let mark = mark / stage.size;
    let target = mark - Vec2::new(0.45, 0.02);
    hand.drag(stage.place(mark), stage.place(target))?;
    let moves = |screen: &Screen| stage.difference(&first, screen) > 0.05;
    let dragged = hand.wait(WHOLE, "the shadow of a dragged lamp", moves)?;
    keep(&dragged, "dragged")?;
    let (before, after) = (stage.shadow(&first), stage.shadow(&dragged));
    println!("the shadow moves from {before} to {after}");
    assert!(after.x - before.x > 100.0, "{before} {after}");

    let has = |screen: &Screen, want: [u8; 3]| {
        screen.pixels.iter().any(|color| color.iter().zip(want).all(|(a, b)| a.abs_diff(b) <= 3))
    };
    assert!(has(&dragged, ARROW), "the handles of the lamp");

    // A step back, and forth.
    hand.key(&[], ESCAPE)?;
    let is_first = |screen: &Screen| stage.difference(&first, screen) < 1e-3;
    hand.key(&[CONTROL], Z)?;
    hand.wait(WHOLE, "the first picture after a step back", is_first)?;
    hand.key(&[CONTROL, SHIFT], Z)?;
    // The handles of the lamp are gone.
    let follows = |screen: &Screen| stage.difference(&dragged, screen) < 0.02;
    hand.wait(WHOLE, "the dragged lamp after a step forth", follows)?;
    hand.key(&[CONTROL], Z)?;
    hand.wait(WHOLE, "the first picture again", is_first)?;

    // A click takes a pixel apart: the curves of its lobes have colours of their own.
    hand.click(stage.place(Vec2::new(0.35, 0.75)))?;
    let has_lobes = |screen: &Screen| has(screen, [250, 190, 90]) && has(screen, [110, 190, 255]);
    let inspected = hand.wait(WHOLE, "the pixel that was clicked", has_lobes)?;
    keep(&inspected, "pixel")?;
    assert!(!has(&inspected, ARROW), "the floor has no handles");
    hand.key(&[], ESCAPE)?;
    hand.wait(WHOLE, "the picture without the pixel", is_first)?;

    // The camera turns and comes nearer, F shows all, and each is a step of its own.
    hand.drag(stage.place(Vec2::new(0.2, 0.2)), stage.place(Vec2::new(0.3, 0.25)))?;
    let turned = hand.wait(WHOLE, "the scene from elsewhere", moves)?;
    hand.press(4)?;
    hand.release(4)?;
    let nearer = |screen: &Screen| stage.difference(&turned, screen) > 0.05;
    hand.wait(WHOLE, "the scene from nearer", nearer)?;
    hand.key(&[], F)?;
    hand.wait(WHOLE, "all of the scene", |_| true)?;
    for _ in 0..2 {
        hand.key(&[CONTROL], Z)?;
    }
    hand.wait(WHOLE, "the turn alone", |screen| stage.difference(&turned, screen) < 1e-3)?;
    hand.key(&[CONTROL], Z)?;
    hand.wait(WHOLE, "the scene from where it began", is_first)?;
    views(&mut hand, stage, &first)
}

/// The views, in the order of the list: each is another picture.
const VIEWS: [&str; 12] = [
    "picture",
    "reference",
    "difference",
    "unshadowed",
    "classes",
    "normals",
    "depth",
    "objects",
    "edges",
    "work",
    "lobes",
    "light",
];

fn views(hand: &mut Hand, stage: Stage, first: &Screen) -> Result<(), Failed> {
    let mut seen: Vec<Screen> = vec![first.clone()];
    for name in &VIEWS[1..] {
        hand.key(&[], V)?;
        let last = seen.last().ok_or("a view")?;
        // The reference grows, and is the picture but for noise.
        let (least, still) = match *name {
            "reference" => (0.0, 0),
            "difference" => (0.02, 0),
            _ => (0.02, 500),
        };
        let is_new = |screen: &Screen| stage.difference(last, screen) >= least;
        let now = hand.wait_for(WHOLE, Duration::from_millis(still), name, is_new)?;
        keep(&now, &format!("view-{name}"))?;
        println!("{name}: {} colours", stage.colors(&now));
        seen.push(now);
    }
    hand.key(&[], V)?;
    hand.wait(WHOLE, "the picture behind the last view", |screen| stage.difference(first, screen) < 1e-3)?;
    hand.key(&[SHIFT], V)?;
    let light = seen.last().ok_or("a view")?;
    hand.wait(WHOLE, "the last view before the first", |screen| stage.difference(light, screen) < 1e-3)?;
    Ok(())
}
