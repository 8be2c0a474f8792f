use crate::app::beside;
use cosine_lobes::{Output, write_png};
use eframe::egui::{ColorImage, Context};
use std::path::{Path, PathBuf};

/// Saves the window beside the scene; the line that says where.
pub(crate) fn take(context: &Context, scene: Option<&Path>) -> String {
    let path = beside(scene, "png");
    let line = format!("The window is saved as {}", path.display());
    save(context, path, |fault| {
        if let Err(line) = fault {
            eprintln!("lobes-view: error: {line}");
        }
    });
    line
}

/// Saves the window as it is next seen.
pub(crate) fn save(context: &Context, path: PathBuf, then: impl FnOnce(Result<(), String>) + Send + 'static) {
    let waker = context.clone();
    context.request_screenshot(move |image| {
        then(write(&image, &path));
        waker.request_repaint();
    });
    context.request_repaint();
}

fn write(image: &ColorImage, path: &Path) -> Result<(), String> {
    let rgb: Vec<u8> = image.pixels.iter().flat_map(|color| [color.r(), color.g(), color.b()]).collect();
    let [width, height] = image.size;
    let output = Output::create(path).map_err(|error| error.to_string())?;
    write_png(output, width, height, &rgb).map_err(|error| error.to_string())
}
