//! Wavefront MTL: the materials of OBJ files.

use crate::appearance::Appearance;
use crate::context::{Context, and_others};
use crate::files::extension;
use crate::hdr_header::RGB_OF_XYZ;
use crate::height::{self, Source};
use crate::image_file;
use brdf::{Lambert, Material, MetallicRoughness, Phong};
use core::f32::consts::FRAC_1_PI;
use glam::{Affine2, Mat2, Vec2, Vec3};
use scene::cut_out::CutOut;
use scene::{Channel, Encoding, SceneError, Surface, Texture, TextureMap, Wrap};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The materials of a library by name; a warning names the keywords that are not read.
///
/// `Kd`, `Ks`, `Ns` are those of Phong's model as the format prints it, so that a light of irradiance π gives `Kd`; with `Pr` or `Pm` the
/// material is metallic–roughness of base `Kd`. `Ke` is emission. Maps: `map_Kd`, `map_Ks`, `map_Ns`, `map_Ke`, `map_Pr`, `map_Pm`, `norm`.
/// `d`, `Tr` and `map_d` cut surfaces out where their opacity is below a half; `d` wins, and `Tr 1` without it is opaque, with a warning.
/// Names of images may have blanks, quotes and backslashes, and letters large or small. `bump` is a height, of white as many texels as `-bm` says, or
/// a normal map where its colours are normals.
pub(crate) fn parse(path: &Path, context: &mut Context) -> Result<HashMap<String, Appearance>, SceneError> {
    let text = decoded(&context.files.read(path)?);
    let mut reader = Reader { path, context, textures: HashMap::new(), unread: Vec::new(), inverted: 0, strange: 0 };
    let (mut all, mut entry): (HashMap<String, Appearance>, Option<Entry>) = (HashMap::new(), None);
    let mut twice = Vec::new();
    let unified = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines = unified.split('\n').enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = Cow::Borrowed(line);
        while let Some(head) = continued(&line) {
            line = Cow::Owned(format!("{head} {}", lines.next().map_or("", |(_, next)| next)));
        }
        let content = without_comment(&line).trim();
        let (word, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        let (word, rest) = (word, rest.trim());
        if word.eq_ignore_ascii_case("newmtl") {
            all.extend(entry.take().map(|entry| reader.finish(entry)));
            let name = rest.split_whitespace().collect::<Vec<_>>().join(" ");
            if all.contains_key(&name) && !twice.contains(&name) {
                twice.push(name.clone());
            }
            entry = Some(Entry { name, ..Entry::default() });
        } else if let Some(entry) = entry.as_mut().filter(|_| !word.is_empty()) {
            reader.line(entry, word, rest).map_err(|e| SceneError::at_line(path, number + 1, e))?;
        }
    }
    all.extend(entry.map(|entry| reader.finish(entry)));
    let Reader { unread, inverted, strange, .. } = reader;
    if inverted > 0 {
        let names = if inverted == 1 { "a material says".to_owned() } else { format!("{inverted} materials say") };
        context.warn(path, format!("{names} `Tr 1` and no `d`: surfaces are opaque, not invisible"));
    }
    if all.values().any(|appearance| appearance.cut_out.is_some()) {
        context.warn(path, "surfaces that are not opaque are cut out where their opacity is below a half");
    }
    if let [first, others @ ..] = &twice[..] {
        let more = and_others(others.len());
        context.warn(path, format!("material {first}{more} stands there more than once: the last is taken"));
    }
    if strange > 0 {
        let are = if strange == 1 { "1 number is".to_owned() } else { format!("{strange} numbers are") };
        context.warn(path, format!("{are} negative or out of range: the nearest that is not is taken"));
    }
    if !unread.is_empty() {
        context.warn(path, format!("not read: {}", unread.join(", ")));
    }
    Ok(all)
}

/// The text of a library. Names may be in any encoding: bytes that are not UTF-8 are replaced. UTF-16 is known by its mark.
fn decoded(bytes: &[u8]) -> String {
    let wide = |rest: &[u8], of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = rest.chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// The line without its end, if it continues in the next one: a backslash that stands alone. One at the end of a word is a part of a path.
fn continued(line: &str) -> Option<&str> {
    let head = line.trim_end().strip_suffix('\\')?;
    (head.is_empty() || head.ends_with(char::is_whitespace)).then_some(head)
}

/// The statements about a material so far.
#[derive(Default)]
struct Entry {
    name: String,
    kd: Option<Vec3>,
    ks: Option<Vec3>,
    ns: Option<f32>,
    /// `d`; below a half the surface is cut out.
    opacity: Option<f32>,
    transparency: Option<f32>,
    opacity_map: Option<TextureMap>,
    /// Whether `illum` selects a model without a specular part.
    is_matte: bool,
    roughness: Option<f32>,
    metallic: Option<f32>,
    surface: Surface,
}

impl Entry {
    fn finish(self) -> (String, Appearance) {
        let Self { name, kd, ks, ns, opacity, transparency, opacity_map, is_matte, roughness, metallic, mut surface } =
            self;
        let white = |map: &Option<TextureMap>| if map.is_some() { Vec3::ONE } else { Vec3::ZERO };
        let kd = kd.unwrap_or(if surface.color.is_some() { Vec3::ONE } else { Vec3::splat(0.5) });
        let ks = ks.unwrap_or(white(&surface.specular));
        if surface.emission == Vec3::ZERO {
            surface.emission = white(&surface.emission_map);
        }
        let is_metal =
            roughness.is_some() || metallic.is_some() || surface.roughness.is_some() || surface.metallic.is_some();
        let lambert: Material = Lambert { albedo: kd }.into();
        let material = if is_metal {
            // A map alone is the number.
            let metallic = metallic.unwrap_or(f32::from(u8::from(surface.metallic.is_some())));
            let base = kd.clamp(Vec3::ZERO, Vec3::ONE);
            MetallicRoughness::new(base, metallic, roughness.unwrap_or(1.0)).map_or(lambert, Into::into)
        } else if ks == Vec3::ZERO || is_matte {
            lambert
        } else {
            // A map alone is of the format's range.
            let alone = if surface.exponent.is_some() { 1000.0 } else { 0.0 };
            Phong { kd: kd * FRAC_1_PI, ks: ks * FRAC_1_PI, exponent: ns.unwrap_or(alone) }.into()
        };
        let factor = opacity.unwrap_or(1.0 - transparency.unwrap_or(0.0));
        let is_whole = opacity_map.is_none() && factor == 1.0;
        let cut_out = (!is_whole).then_some(CutOut { map: opacity_map, factor, limit: 0.5 });
        (name, Appearance { material, surface, cut_out })
    }
}

struct Reader<'a> {
    path: &'a Path,
    context: &'a mut Context,
    textures: HashMap<(String, Use), Option<(Texture, f32)>>,
    /// Words that mean something and are not read.
    unread: Vec<String>,
    /// Materials whose `Tr` is taken as an opacity.
    inverted: usize,
    /// Numbers that are out of the format's range.
    strange: usize,
}

/// The meaning of an image.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Use {
    Color,
    Number,
    Opacity(Option<Source>),
    Height { source: Source, is_repeated: bool },
}

const MAX_EXPONENT: f32 = 1e7;
const MAX_COLOR: f32 = 1e12;

/// The words that are read, and those that change nothing. Some programs write them with other letters large.
const KEYWORDS: [&str; 23] = [
    "Kd",
    "Ks",
    "Ke",
    "Ns",
    "Pr",
    "Pm",
    "illum",
    "map_Kd",
    "map_Ks",
    "map_Ke",
    "map_Ns",
    "map_Pr",
    "map_Pm",
    "norm",
    "bump",
    "map_bump",
    "map_d",
    "d",
    "Tr",
    "Ka",
    "map_Ka",
    "Ni",
    "sharpness",
];

/// A line before its comment: a `#` within a name is a part of that.
pub(crate) fn without_comment(line: &str) -> &str {
    let begins = |(at, _): &(usize, &str)| *at == 0 || line[..*at].ends_with(char::is_whitespace);
    line.match_indices('#').find(begins).map_or(line, |(at, _)| &line[..at])
}

impl Reader<'_> {
    /// A material that is whole. Some programs write opacity as `Tr`: a surface that is invisible would make no sense.
    fn finish(&mut self, mut entry: Entry) -> (String, Appearance) {
        if entry.opacity.is_none() && entry.opacity_map.is_none() && entry.transparency.is_some_and(|t| t >= 1.0) {
            entry.transparency = None;
            self.inverted += 1;
        }
        entry.finish()
    }

    fn line(&mut self, entry: &mut Entry, word: &str, rest: &str) -> Result<(), String> {
        let surface = &mut entry.surface;
        let known = KEYWORDS.iter().find(|known| known.eq_ignore_ascii_case(word));
        match known.copied().unwrap_or(word) {
            "Kd" => entry.kd = self.color(word, rest)?,
            "Ks" => entry.ks = self.color(word, rest)?,
            "Ke" => surface.emission = self.color(word, rest)?.unwrap_or(Vec3::ZERO),
            "Ns" => entry.ns = Some(self.within(word, rest, MAX_EXPONENT)?),
            "Pr" => entry.roughness = Some(self.within(word, rest, 1.0)?),
            "Pm" => entry.metallic = Some(self.within(word, rest, 1.0)?),
            "illum" => {
                entry.is_matte = matches!(rest, "0" | "1");
                // A constant colour: some programs write it for what is meant to be lit.
                if rest == "0" {
                    self.tell_unread("illum 0");
                }
            }
            "map_Kd" => surface.color = self.map(rest, |_| Use::Color)?.map(|(map, _)| map),
            "map_Ks" => surface.specular = self.map(rest, |_| Use::Color)?.map(|(map, _)| map),
            "map_Ke" => surface.emission_map = self.map(rest, |_| Use::Color)?.map(|(map, _)| map),
            "map_Ns" => surface.exponent = self.channel(rest)?,
            "map_Pr" => surface.roughness = self.channel(rest)?,
            "map_Pm" => surface.metallic = self.channel(rest)?,
            "norm" => surface.normal = self.map(rest, |_| Use::Number)?,
            "bump" | "map_bump" => {
                let of = |o: &Options| Use::Height {
                    source: o.source.unwrap_or(Source::Luminance),
                    is_repeated: o.wrap == Wrap::Repeat,
                };
                let bump = self.map(rest, of)?;
                surface.normal = surface.normal.take().or(bump);
            }
            "map_d" => entry.opacity_map = self.map(rest, |o| Use::Opacity(o.source))?.map(|(map, _)| map),
            "d" if !rest.starts_with("-halo") => entry.opacity = Some(self.within(word, rest, 1.0)?),
            // Some files mean the opposite by it: `d`, where it stands, is sure.
            "Tr" => entry.transparency = Some(self.within(word, rest, 1.0)?),
            "Ka" | "map_Ka" | "Ni" | "sharpness" => {}
            _ => self.tell_unread(word),
        }
        Ok(())
    }

    fn tell_unread(&mut self, word: &str) {
        if self.unread.iter().all(|known| known != word) {
            self.unread.push(word.to_owned());
        }
    }

    /// A colour; none for a spectrum or one in another space.
    fn color(&mut self, word: &str, rest: &str) -> Result<Option<Vec3>, String> {
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words.first() == Some(&"spectral") {
            self.tell_unread(&format!("{word} {}", words[0]));
            return Ok(None);
        }
        let is_xyz = words.first() == Some(&"xyz");
        let values = words.iter().skip(usize::from(is_xyz)).map(|w| number(word, w));
        let color = match values.collect::<Result<Vec<f32>, _>>()?[..] {
            [x] if is_xyz => RGB_OF_XYZ * Vec3::splat(x),
            [x, y, z] if is_xyz => RGB_OF_XYZ * Vec3::new(x, y, z),
            [grey] => Vec3::splat(grey),
            [r, g, b] => Vec3::new(r, g, b),
            _ => return Err(format!("{word}: expected one number or three")),
        };
        // Colours of other spaces may lie outside.
        self.strange += usize::from(!is_xyz && (color.min_element() < 0.0 || color.max_element() > MAX_COLOR));
        let coefficient = |x: f32| if x > 0.0 { x.min(MAX_COLOR) } else { 0.0 };
        Ok(Some(Vec3::from_array(color.to_array().map(coefficient))))
    }

    /// A number, kept in [0, `most`].
    fn within(&mut self, word: &str, rest: &str, most: f32) -> Result<f32, String> {
        let x = number(word, rest)?;
        self.strange += usize::from(!(0.0..=most).contains(&x));
        Ok(x.clamp(0.0, most))
    }

    /// The channel of an image that gives a number: red by default.
    fn channel(&mut self, rest: &str) -> Result<Option<Channel>, String> {
        let mut index = 0;
        let map = self.map(rest, |options| {
            if let Some(Source::Channel(k)) = options.source {
                index = k;
            }
            Use::Number
        })?;
        Ok(map.map(|(map, _)| Channel { map, index }))
    }

    /// An image with its options, and the factor of x and y of normals; `None`, with a warning, where the image is missing.
    fn map(&mut self, rest: &str, of: impl FnOnce(&Options) -> Use) -> Result<Option<(TextureMap, f32)>, String> {
        let (mut scale, mut offset, mut bump) = (Vec2::ONE, Vec2::ZERO, 1.0);
        let mut options = Options { wrap: Wrap::Repeat, source: None };
        let mut words = rest.split_whitespace().peekable();
        // The rest after the options is the name, which may have spaces.
        let mut name = rest;
        while let Some(option) = words.peek().filter(|w| w.starts_with('-')).copied() {
            words.next();
            let mut taken = vec![option];
            let most = match option {
                "-s" | "-o" | "-t" => 3,
                "-mm" => 2,
                _ => 1,
            };
            while taken.len() <= most
                && let Some(word) = words.peek().copied()
                && (taken.len() == 1 || word.parse::<f32>().is_ok())
            {
                taken.push(word);
                words.next();
            }
            let value = |k: usize, default: f32| taken.get(k).and_then(|w| w.parse().ok()).unwrap_or(default);
            match option {
                "-s" => scale = Vec2::new(value(1, 1.0), value(2, 1.0)),
                "-o" => offset = Vec2::new(value(1, 0.0), value(2, 0.0)),
                "-bm" => bump = value(1, 1.0),
                "-clamp" if taken.get(1) == Some(&"on") => options.wrap = Wrap::Clamp,
                "-mm" if (value(1, 0.0), value(2, 1.0)) != (0.0, 1.0) => self.tell_unread("-mm"),
                "-t" if (1..=3).any(|k| value(k, 0.0) != 0.0) => self.tell_unread("-t"),
                "-imfchan" => options.source = source(taken.get(1).copied().unwrap_or(""))?,
                _ => {}
            }
            for word in taken {
                name = name.trim_start().strip_prefix(word).unwrap_or(name);
            }
        }
        let name = name.trim().to_owned();
        let Some((texture, steepness)) = self.texture(&name, of(&options))? else { return Ok(None) };
        if !(scale.is_finite() && offset.is_finite() && bump.is_finite()) {
            return Err(format!("the options of image \"{name}\" are not finite"));
        }
        // v counts from the lower edge there: v' = 1 − v.
        let translation = Vec2::new(offset.x, 1.0 - scale.y - offset.y);
        let transform = Affine2 { matrix2: Mat2::from_diagonal(scale), translation };
        let map = TextureMap { transform, wrap: [options.wrap; 2], ..TextureMap::new(texture) };
        Ok(Some((map, bump * steepness)))
    }

    /// The file of an image: the one of that name, else the one of its last part beside the library, with a warning: paths of the
    /// computer where the file was written.
    fn find(&mut self, name: &str) -> Option<PathBuf> {
        let found = self.context.files.beside(self.path, name);
        let last = name.trim_matches('"').rsplit(['/', '\\']).next().filter(|last| *last != name);
        found.or_else(|| {
            let file = self.context.files.beside(self.path, last?)?;
            self.context.warn(self.path, format!("image {name} is not there: {} is taken", file.display()));
            Some(file)
        })
    }

    /// An image, and the factor of x and y if it is a normal map.
    fn texture(&mut self, name: &str, used: Use) -> Result<Option<(Texture, f32)>, String> {
        let key = (name.to_owned(), used);
        if let Some(known) = self.textures.get(&key) {
            return Ok(known.clone());
        }
        if name.is_empty() {
            return Err("expected the name of an image".to_owned());
        }
        let texture = if let Some(file) = self.find(name) {
            let bytes = self.context.files.read(&file).map_err(|e| e.to_string())?;
            let ending = extension(&file);
            let budget = &*self.context.files.budget;
            let texels = || image_file::texels(name, &ending, &bytes, budget);
            Some(match used {
                Use::Color => (image_file::decode(name, &ending, &bytes, Encoding::Srgb, budget)?, 1.0),
                Use::Number => (image_file::decode(name, &ending, &bytes, Encoding::Linear, budget)?, 1.0),
                Use::Opacity(source) => {
                    let (size, texels) = texels()?;
                    (height::opacity(name, size, texels, source), 1.0)
                }
                Use::Height { source, is_repeated } => {
                    let (size, texels) = texels()?;
                    if height::shows_normals(&texels) {
                        let note = format!("bump map {name} shows normals: it is taken as a normal map");
                        self.context.warn(self.path, note);
                        (Texture::new(name, size, texels, Encoding::Linear), 1.0)
                    } else {
                        height::slopes(name, size, &texels, source, is_repeated)
                    }
                }
            })
        } else {
            self.context.warn(self.path, format!("image {name} is not there: its factor is taken alone"));
            None
        };
        self.textures.insert(key, texture.clone());
        Ok(texture)
    }
}

/// The options of an image.
struct Options {
    wrap: Wrap,
    /// The channel that gives a number, if stated.
    source: Option<Source>,
}

/// Of `-imfchan`.
fn source(word: &str) -> Result<Option<Source>, String> {
    match word {
        "r" => Ok(Some(Source::Channel(0))),
        "g" => Ok(Some(Source::Channel(1))),
        "b" => Ok(Some(Source::Channel(2))),
        "m" => Ok(Some(Source::Channel(3))),
        "l" => Ok(Some(Source::Luminance)),
        _ => Err(format!("-imfchan: expected r, g, b, m or l, found '{word}'")),
    }
}

fn number(name: &str, word: &str) -> Result<f32, String> {
    let first = word.split_whitespace().next().unwrap_or("");
    match first.parse::<f32>() {
        Ok(x) if !x.is_nan() => Ok(x),
        _ => Err(format!("{name}: cannot read number '{first}'")),
    }
}
