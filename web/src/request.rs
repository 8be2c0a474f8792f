//! The messages that a page sends.

use serde::{Deserialize, Serialize};

/// The wishes of a page. Places are in pixels of the picture on the screen.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase")]
pub(crate) enum Request {
    /// Opens a file that was [put](crate::put_file), or the built-in scene; the picture gets so many columns. `leads`: makes pictures.
    Open {
        path: Option<String>,
        columns: u32,
        leads: bool,
    },
    /// The size of the picture on the screen.
    View {
        size: [f32; 2],
    },
    /// The pointer begins to drag.
    Press {
        at: [f32; 2],
        pans: bool,
    },
    /// It drags further.
    Drag {
        at: [f32; 2],
    },
    /// It ends.
    Release,
    /// A click that drags nothing.
    Click {
        at: [f32; 2],
    },
    /// Goes nearer or farther by a factor.
    Zoom {
        by: f32,
    },
    /// Looks at the whole scene.
    Frame,
    /// Selects a light, or nothing.
    Select {
        light: Option<usize>,
    },
    /// Changes a light: its size, the largest channel of its radiance, its colour, whether it shines.
    Light {
        number: usize,
        size: Option<f32>,
        radiance: Option<f32>,
        color: Option<[f32; 3]>,
        on: Option<bool>,
    },
    /// Changes the material of the selected object.
    Material {
        gloss: Option<f32>,
        color: Option<[f32; 3]>,
    },
    /// How the selected object blocks light; none: as the renderer chooses.
    Strategy {
        name: Option<String>,
    },
    /// How all objects block light; none: each as it says.
    Strategies {
        name: Option<String>,
    },
    /// The camera's projection.
    Projection {
        name: String,
    },
    /// The tolerance of shadows.
    Tolerance {
        value: f32,
    },
    /// Columns of the picture.
    Columns {
        count: u32,
    },
    /// How the picture is shown: exposure in stops, tone map.
    Look {
        exposure: f32,
        tone: String,
    },
    /// A moment of the animation.
    Seek {
        time: f32,
    },
    /// A slider rests.
    Rest,
    Undo,
    Redo,
}

/// A task between instances.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Rows {
    pub(crate) divisor: u32,
    pub(crate) size: [usize; 2],
    pub(crate) rows: [usize; 2],
}

impl From<&session::Task> for Rows {
    fn from(task: &session::Task) -> Self {
        Self { divisor: task.divisor, size: task.size, rows: [task.rows.start, task.rows.end] }
    }
}

impl From<Rows> for session::Task {
    fn from(rows: Rows) -> Self {
        Self { divisor: rows.divisor, size: rows.size, rows: rows.rows[0]..rows.rows[1] }
    }
}
