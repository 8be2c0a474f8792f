use std::ffi::OsString;
use std::path::PathBuf;

pub(crate) const HELP: &str = "The window of lobes: drag a light, see its shadow follow, and see why

Usage: lobes-view [FILE]

  FILE          scene (.toml) or model (.gltf, .glb, .obj, .ply); the built-in scene when left out
  --pixel X,Y   takes that pixel apart
  --spheres     draws the spheres that block light
  --shadow-map  shows the shadow map of the first light
  --gpu         shades on the GPU from the start
  --one-device  shades on the window's device also where that is a software driver
  --smoke PNG   opens, draws one picture, saves the window to PNG, and ends
  --shake       changes the window's size at each frame before it is saved
  --help        this";

/// The command line.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Args {
    pub(crate) file: Option<PathBuf>,
    /// Where the window is saved, by a run that ends by itself.
    pub(crate) smoke: Option<PathBuf>,
    /// The pixel that is taken apart as soon as there is a picture.
    pub(crate) pixel: Option<[u32; 2]>,
    /// Whether the spheres that block light are drawn.
    pub(crate) spheres: bool,
    /// Whether a shadow map is shown.
    pub(crate) shadow_map: bool,
    /// Whether the window changes its size before it is saved.
    pub(crate) shake: bool,
    /// Whether the GPU shades.
    pub(crate) gpu: bool,
    /// Whether the window's device shades, whatever it is.
    pub(crate) one_device: bool,
}

/// None where the help is requested.
pub(crate) fn parse(words: impl Iterator<Item = OsString>) -> Result<Option<Args>, String> {
    let mut args = Args::default();
    let mut words = words.peekable();
    let mut only_files = false;
    while let Some(word) = words.next() {
        match word.to_str() {
            Some("--") if !only_files => only_files = true,
            Some("--help" | "-h") if !only_files => return Ok(None),
            Some("--smoke") if !only_files => {
                args.smoke = Some(words.next().ok_or("--smoke needs the name of a PNG file")?.into());
            }
            Some("--spheres") if !only_files => args.spheres = true,
            Some("--shadow-map") if !only_files => args.shadow_map = true,
            Some("--shake") if !only_files => args.shake = true,
            Some("--gpu") if !only_files => args.gpu = true,
            Some("--one-device") if !only_files => args.one_device = true,
            Some("--pixel") if !only_files => {
                let given = words.next().and_then(|word| word.into_string().ok()).unwrap_or_default();
                let numbers = given.split_once(',').map(|(x, y)| [x, y].map(|n| n.parse::<u32>().ok()));
                let Some([Some(x), Some(y)]) = numbers else {
                    return Err(format!("--pixel is \"{given}\": expected column,row"));
                };
                args.pixel = Some([x, y]);
            }
            Some(option) if option.starts_with('-') && !only_files => {
                return Err(format!("there is no option {option}; see lobes-view --help"));
            }
            _ if args.file.is_some() => return Err("expected one FILE; see lobes-view --help".to_owned()),
            _ => args.file = Some(word.into()),
        }
    }
    Ok(Some(args))
}
