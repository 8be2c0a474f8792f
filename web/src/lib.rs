//! The session of a page: what its workers call.
//!
//! JavaScript writes bytes to [`reserve`], calls one of the other functions, and reads what it leaves at [`reply`]. Requests and reports
//! are JSON ([`Request`](request::Request), [`Report`](report::Report)). A page has one scene at a time.
//!
//! One instance leads: it decides which rows are shaded next ([`task`]), and makes the pictures ([`finish`]). Others may help: they are
//! sent the same requests in the same order, and [`shade`] their parts of the rows.
//!
//! The same module is the library of the package for npm. With the feature `gpu` it is another module, which is no library, shades on
//! WebGPU, and needs the JavaScript that `wasm-bindgen` writes.

mod desk;
mod files;
mod gesture;
#[cfg(feature = "gpu")]
mod gpu;
mod host;
#[cfg(not(feature = "gpu"))]
mod library;
mod page;
mod report;
mod request;

use crate::page::Page;
use std::cell::RefCell;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

fn with<R>(run: impl FnOnce(&mut Page) -> R) -> R {
    PAGE.with_borrow_mut(run)
}

/// Makes room for so many bytes of JavaScript's, for the next call.
// SAFETY: no other symbol of this module has that name; so with those below.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    with(|page| page.reserve(length))
}

/// Where the reply of the last call is.
#[unsafe(no_mangle)]
pub extern "C" fn reply() -> *const u8 {
    with(|page| page.reply().as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn reply_length() -> usize {
    with(|page| page.reply().len())
}

/// Takes a file: its name, of so many bytes, and its bytes.
#[unsafe(no_mangle)]
pub extern "C" fn put_file(name: usize) {
    host::hear_panics();
    with(|page| page.put_file(name));
}

/// Does what a [`Request`](request::Request) says. The reply is empty, or a line that says why not.
#[unsafe(no_mangle)]
pub extern "C" fn request() {
    host::hear_panics();
    with(Page::request);
}

/// The next [`Task`](request::Rows) for so many hands; the reply is empty where there is nothing to do.
#[unsafe(no_mangle)]
pub extern "C" fn task(hands: usize) {
    with(|page| page.task(hands));
}

/// Shades a part of a task: the reply is its radiance, three floats a pixel, empty where that fails.
#[unsafe(no_mangle)]
pub extern "C" fn shade(part: usize, of: usize) {
    with(|page| page.shade(part, of));
}

/// Takes the radiance of another hand's part of the last task.
#[unsafe(no_mangle)]
pub extern "C" fn put_part(part: usize) {
    with(|page| page.put_part(part));
}

/// Finishes the last task; parts that were not put are shaded first. Whether a picture is done with it: helpers [`follow`] then.
#[unsafe(no_mangle)]
pub extern "C" fn finish() -> bool {
    with(Page::finish)
}

/// Lets a helper follow what the leader has finished.
#[unsafe(no_mangle)]
pub extern "C" fn follow() {
    with(Page::follow);
}

/// Makes the picture anew, since another one shades it from now on.
#[unsafe(no_mangle)]
pub extern "C" fn redraw() {
    with(Page::redraw);
}

/// The [`Report`](report::Report) of the scene and its newest picture.
#[unsafe(no_mangle)]
pub extern "C" fn report() {
    with(Page::report);
}

/// The [`Pixel`](report::Pixel) that was taken apart last; empty where it shows no surface.
#[unsafe(no_mangle)]
pub extern "C" fn pixel() {
    with(Page::pixel);
}

/// The newest picture as a screen shows it: four bytes a pixel.
#[unsafe(no_mangle)]
pub extern "C" fn pixels() {
    with(Page::pixels);
}

/// Its linear radiance: three floats a pixel.
#[unsafe(no_mangle)]
pub extern "C" fn radiance() {
    with(Page::radiance);
}
