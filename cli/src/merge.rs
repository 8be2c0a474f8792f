//! Parts of a picture put together.

use crate::args::MergeArgs;
use crate::console::say;
use crate::failure::Failure;
use crate::files::{self, Files};
use cosine_lobes::{ImageFileError, merge_exr};

pub(crate) fn run(args: &MergeArgs) -> Result<(), Failure> {
    files::distinct(&args.output, &args.parts)?;
    let mut whole = merge_exr(&args.parts)?;
    // One run would not have said it of the whole.
    let exposure = args.exposure.or(whole.exposure.take()).unwrap_or_default();
    let [width, height] = whole.window.image;
    let path = args.parts.first().cloned().unwrap_or_default();
    if ["R", "G", "B"].iter().any(|name| whole.channel(name).is_none()) {
        let message = "no R, G, B channels".to_owned();
        return Err(ImageFileError::Format { path, message }.into());
    }
    Files::create(&args.output, None)?.write_part(&args.png.display(exposure), whole)?;
    if !args.quiet {
        let names: Vec<String> = args.output.iter().map(|p| p.display().to_string()).collect();
        say(format_args!("{}: {width} x {height} from {} parts", names.join(", "), args.parts.len()));
    }
    Ok(())
}
