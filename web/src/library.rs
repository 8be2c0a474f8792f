//! The library for JavaScript's own scenes: what the package for npm calls.
//!
//! JavaScript writes JSON, and arrays behind it, to [`library_reserve`], calls [`library_call`], and reads the answer in the same form.
//! Scenes and renderers are numbers, as many as there are until they are freed.

mod command;
mod fault;
mod given;
mod images;
mod light;
mod mail;
mod material;
mod progress;
mod reference;
mod renderers;
mod scenes;

use crate::host;
use crate::library::command::Command;
use crate::library::fault::Fault;
use crate::library::mail::{Answer, Arrays, Memory, Span};
use crate::library::renderers::RendererItem;
use crate::library::scenes::SceneItem;
use glam::Vec3;
use pictures::{Display, PngDepth, Window};
use scene::Animation;
use serde_json::json;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

thread_local! {
    static LIBRARY: RefCell<Library> = RefCell::default();
}

/// Makes room for a command of so many bytes.
// SAFETY: no other symbol of this module has that name; so with those below.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn library_reserve(length: usize) -> *mut u8 {
    LIBRARY.with_borrow_mut(|library| {
        library.given.clear();
        library.given.resize(length, 0);
        library.given.as_mut_ptr()
    })
}

/// Does a command, whose JSON has so many bytes. Whether it was done; else the answer's JSON says why not.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn library_call(json: usize) -> bool {
    host::hear_panics();
    LIBRARY.with_borrow_mut(|library| library.call(json))
}

/// Where the JSON of the last answer is, or with `arrays` its arrays.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn library_answer(arrays: bool) -> *const u8 {
    LIBRARY.with_borrow(|library| library.part(arrays).as_ptr())
}

/// How many bytes these have.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn library_answer_length(arrays: bool) -> usize {
    LIBRARY.with_borrow(|library| library.part(arrays).len())
}

/// Gives the memory of the last command and its answer back.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn library_forget() {
    LIBRARY.with_borrow_mut(|library| (library.given, library.json, library.arrays) = <_>::default());
}

/// All scenes and renderers, and the mail.
#[derive(Debug, Default)]
struct Library {
    given: Vec<u8>,
    json: Vec<u8>,
    arrays: Memory,
    scenes: BTreeMap<u32, SceneItem>,
    renderers: BTreeMap<u32, RendererItem>,
    next: u32,
}

impl Library {
    fn part(&self, arrays: bool) -> &[u8] {
        if arrays { self.arrays.bytes() } else { &self.json }
    }

    fn call(&mut self, json: usize) -> bool {
        let given = core::mem::take(&mut self.given);
        let (json, arrays) = given.split_at(json.min(given.len()));
        let done = serde_json::from_slice(json)
            .map_err(|error| Fault { class: "TypeError", line: error.to_string() })
            .and_then(|command| self.follow(command, Arrays(arrays)));
        let is_done = done.is_ok();
        let Answer { head, arrays } = done.unwrap_or_else(|Fault { class, line }| {
            // One line, whatever it quotes.
            Answer::of(json!({ "class": class, "line": line.replace('\n', " ") }))
        });
        self.json = serde_json::to_vec(&head).unwrap_or_default();
        self.arrays = arrays;
        is_done
    }

    fn follow(&mut self, command: Command, arrays: Arrays<'_>) -> Result<Answer, Fault> {
        let scene = match command {
            Command::NewScene => SceneItem::empty(),
            Command::Builtin => SceneItem::of((scene::builtin(), Animation::default(), Vec::new())),
            Command::Load { path, clip, files } => {
                let file = |(name, bytes): (String, Span)| Ok((PathBuf::from(name), arrays.bytes(bytes)?.to_vec()));
                let files = files.into_iter().map(file).collect::<Result<BTreeMap<_, _>, Fault>>()?;
                SceneItem::of(scene_files::load_from(Arc::new(files), path, clip.as_deref())?)
            }
            Command::NewRenderer { scene, settings } => {
                let renderer = RendererItem::new(self.scene(scene)?, &settings)?;
                let number = self.number();
                self.renderers.insert(number, renderer);
                return Ok(Answer::of(json!({ "number": number })));
            }
            Command::Free { number } => {
                self.scenes.remove(&number);
                self.renderers.remove(&number);
                return Ok(Answer::default());
            }
            Command::Exposed { radiance, size, exposure, tone } => {
                return exposed(&arrays.list(radiance)?, size, exposure, &tone);
            }
            Command::Scene { number, then } => return self.scene(number)?.follow(then, arrays),
            Command::Renderer { number, then } => {
                let renderer = self.renderers.get_mut(&number).ok_or_else(|| Fault::edit("the renderer was freed"))?;
                return renderer.follow(then, arrays);
            }
        };
        let number = self.number();
        self.scenes.insert(number, scene);
        Ok(Answer::of(json!({ "number": number })))
    }

    fn number(&mut self) -> u32 {
        self.next += 1;
        self.next
    }

    fn scene(&mut self, number: u32) -> Result<&mut SceneItem, Fault> {
        self.scenes.get_mut(&number).ok_or_else(|| Fault::edit("the scene was freed"))
    }
}

/// A picture as a screen shows it.
fn exposed(radiance: &[Vec3], [width, height]: [usize; 2], exposure: f32, tone: &str) -> Result<Answer, Fault> {
    if width.checked_mul(height) != Some(radiance.len()) {
        let count = radiance.len();
        return Err(Fault::range(format!("radiance has {count} pixels: expected {width} x {height}")));
    }
    let tone = crate::desk::tone_named(tone).map_err(Fault::range)?;
    let display = Display { exposure, tone, depth: PngDepth::Eight };
    let rgb = display.bytes(radiance, &Window::whole(width, height));
    let arrays = rgb.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
    Ok(Answer { head: json!({}), arrays: Memory::Bytes(arrays) })
}
