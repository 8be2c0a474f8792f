use crate::Edit;
use renderer::{RenderError, Renderer};

/// The steps that led here, and those that were taken back.
#[derive(Debug, Default)]
pub(crate) struct History {
    /// The edits that take each step back, the latest last.
    done: Vec<Edit>,
    /// The edits that make each again.
    undone: Vec<Edit>,
    /// Whether the next edit of the same thing belongs to the latest step.
    is_open: bool,
}

impl History {
    /// Makes an edit. Edits of the same thing one after the other are one step, until that is [closed](Self::close).
    pub(crate) fn apply(&mut self, edit: Edit, renderer: &mut Renderer) -> Result<(), RenderError> {
        let inverse = edit.apply(renderer)?;
        self.undone.clear();
        // The first inverse of a step leads back to where it began.
        if !(self.is_open && self.done.last().is_some_and(|last| last.is_of(&inverse))) {
            self.done.push(inverse);
        }
        self.is_open = true;
        Ok(())
    }

    pub(crate) const fn close(&mut self) {
        self.is_open = false;
    }

    /// Takes the latest step back; whether there was one.
    pub(crate) fn undo(&mut self, renderer: &mut Renderer) -> Result<bool, RenderError> {
        self.is_open = false;
        let Some(edit) = self.done.pop() else { return Ok(false) };
        self.undone.push(edit.apply(renderer)?);
        Ok(true)
    }

    /// Makes the step again that was taken back last; whether there was one.
    pub(crate) fn redo(&mut self, renderer: &mut Renderer) -> Result<bool, RenderError> {
        self.is_open = false;
        let Some(edit) = self.undone.pop() else { return Ok(false) };
        self.done.push(edit.apply(renderer)?);
        Ok(true)
    }

    /// Numbers of steps that can be taken back, and made again.
    pub(crate) fn steps(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    /// Forgets all steps: handles may be others now.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
