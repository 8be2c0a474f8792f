//! The state between the calls of the page.

use crate::desk::Desk;
use crate::files::Given;
use crate::request::{Request, Rows};
use glam::Vec3;
use renderer::{Image, RenderError};
use session::Task;

/// By how much the sides of the picture are shorter that warms a GPU up.
#[cfg(feature = "gpu")]
const COARSE: u32 = 8;

/// The mail between JavaScript and the scene that is open.
#[derive(Debug, Default)]
pub(crate) struct Page {
    /// Bytes of JavaScript's.
    given: Vec<u8>,
    reply: Vec<u8>,
    files: Given,
    desk: Option<Desk>,
    task: Option<Task>,
    /// The parts of the last task.
    parts: Vec<Option<Result<Image, RenderError>>>,
}

impl Page {
    pub(crate) fn reserve(&mut self, length: usize) -> *mut u8 {
        self.given.clear();
        self.given.resize(length, 0);
        self.given.as_mut_ptr()
    }

    pub(crate) fn reply(&self) -> &[u8] {
        &self.reply
    }

    pub(crate) fn put_file(&mut self, name: usize) {
        let (name, bytes) = self.given.split_at(name.min(self.given.len()));
        self.files.put(&String::from_utf8_lossy(name), bytes.to_vec());
        self.given = Vec::new();
    }

    pub(crate) fn request(&mut self) {
        self.reply.clear();
        if let Err(line) = self.answer() {
            self.reply = line.into_bytes();
        }
    }

    fn answer(&mut self) -> Result<(), String> {
        let request = serde_json::from_slice(&self.given).map_err(|error| error.to_string())?;
        if let Request::Open { path, columns, leads } = request {
            // Files are needed no longer once the scene is read.
            let files = core::mem::take(&mut self.files);
            self.desk = Some(Desk::open(&files, path.as_deref(), columns, leads)?);
            (self.task, self.parts) = (None, Vec::new());
            return Ok(());
        }
        self.desk.as_mut().map_or(Ok(()), |desk| desk.follow_request(request))
    }

    pub(crate) fn task(&mut self, hands: usize) {
        self.reply.clear();
        self.task = self.desk.as_mut().and_then(|desk| desk.task(hands));
        self.parts.clear();
        if let Some(task) = &self.task {
            self.parts.resize_with(hands.max(1), || None);
            self.reply = json(&Rows::from(task));
        }
    }

    pub(crate) fn shade(&mut self, part: usize, of: usize) {
        self.reply.clear();
        let Some(task) = self.task_of_part() else { return };
        let Some(desk) = &mut self.desk else { return };
        let done = desk.driver.shade(&task, part, of);
        if let Ok(image) = &done {
            self.reply.extend_from_slice(bytemuck::cast_slice(&image.radiance));
        }
        if let Some(place) = self.parts.get_mut(part) {
            *place = Some(done);
        }
    }

    /// The task of which a part is to be shaded: a helper is given it, the leader has it.
    fn task_of_part(&self) -> Option<Task> {
        match serde_json::from_slice::<Rows>(&self.given) {
            Ok(rows) if self.parts.is_empty() => Some(rows.into()),
            _ => self.task.clone(),
        }
    }

    /// As [`shade`](Self::shade), for helpers on WebGPU. An error is a line for the user.
    #[cfg(feature = "gpu")]
    pub(crate) async fn shade_async(&mut self, part: usize, of: usize) -> Result<(), String> {
        self.reply.clear();
        let Some(task) = self.task_of_part() else { return Ok(()) };
        let Some(desk) = &mut self.desk else { return Ok(()) };
        let image = desk.driver.shade_async(&task, part, of).await.map_err(|error| error.to_string())?;
        self.reply.extend_from_slice(bytemuck::cast_slice(&image.radiance));
        Ok(())
    }

    /// Compiles the kernels of the scene, with the first rows of a coarse picture.
    #[cfg(feature = "gpu")]
    pub(crate) async fn warm_up(&mut self) -> Result<(), String> {
        let Some(desk) = &mut self.desk else { return Ok(()) };
        let size = desk.editor.scene().size.map(|side| (side as usize).div_ceil(COARSE as usize));
        let task = Task { divisor: COARSE, size, rows: 0..size[1] };
        desk.driver.shade_async(&task, 0, 1).await.map(drop).map_err(|error| error.to_string())
    }

    pub(crate) fn put_part(&mut self, part: usize) {
        let (Some(task), of) = (&self.task, self.parts.len()) else { return };
        let radiance: Vec<Vec3> =
            self.given.chunks_exact(size_of::<Vec3>()).map(bytemuck::pod_read_unaligned).collect();
        if part < of && radiance.len() == task.pixels(part, of) {
            self.parts[part] = Some(Ok(Image { radiance, ..Image::default() }));
        }
    }

    /// Whether there is a new picture.
    pub(crate) fn finish(&mut self) -> bool {
        let (Some(desk), Some(task)) = (&mut self.desk, self.task.take()) else { return false };
        let of = self.parts.len();
        let mut parts = Vec::with_capacity(of);
        for (part, done) in core::mem::take(&mut self.parts).into_iter().enumerate() {
            // A part that a helper has not done is done here.
            parts.push(done.unwrap_or_else(|| desk.driver.shade(&task, part, of)));
        }
        desk.driver.finish(parts);
        desk.follow()
    }

    pub(crate) fn follow(&mut self) {
        if let Some(desk) = &mut self.desk {
            desk.driver.show_scene();
            desk.follow();
        }
    }

    pub(crate) fn redraw(&mut self) {
        if let Some(desk) = &mut self.desk {
            desk.driver.redraw();
        }
    }

    pub(crate) fn report(&mut self) {
        self.reply = self.desk.as_mut().map(|desk| json(&desk.report())).unwrap_or_default();
    }

    pub(crate) fn pixel(&mut self) {
        self.reply = self.desk.as_ref().and_then(Desk::pixel).map(|pixel| json(&pixel)).unwrap_or_default();
    }

    pub(crate) fn pixels(&mut self) {
        self.reply.clear();
        if let Some(desk) = &self.desk {
            desk.pixels(&mut self.reply);
        }
    }

    pub(crate) fn radiance(&mut self) {
        self.reply.clear();
        if let Some(desk) = &self.desk {
            self.reply.extend_from_slice(bytemuck::cast_slice(&desk.editor.picture().radiance));
        }
    }
}

/// Reports have strings for keys, and numbers that JSON has: there is no error.
fn json(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).unwrap_or_default()
}
