//! Stanford PLY: ascii and binary, positions, normals, colours, texture coordinates, polygons, images. Other elements and properties are skipped.

use crate::context::Context;
use crate::part::Part;
use crate::ply_mesh::{Face, PlyMesh};
use glam::{DVec3, Vec2, Vec3};
use scene::SceneError;
use std::path::Path;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    kind: Kind,
    /// The type of the length, for a list.
    length: Option<Kind>,
}

impl Property {
    /// From the words of its line behind the first.
    fn parse(words: &[&str]) -> Result<Self, String> {
        // Some programs begin names of colours with a capital.
        let named = |name: &str| name.to_ascii_lowercase();
        let kind = |word: &str| Kind::parse(word).ok_or_else(|| format!("unknown type \"{word}\""));
        match *words {
            ["list", length, item, name] => {
                Ok(Self { name: named(name), kind: kind(item)?, length: Some(kind(length)?) })
            }
            [item, name] => Ok(Self { name: named(name), kind: kind(item)?, length: None }),
            _ => Err("cannot read the property".to_owned()),
        }
    }
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    /// Without properties, in a file of `size` bytes.
    fn parse(name: &str, count: &str, size: usize) -> Result<Self, String> {
        let count: usize = count.parse().map_err(|_| format!("cannot read element count '{count}'"))?;
        if count > size {
            return Err(format!("{count} elements \"{name}\" in a file of {size} bytes"));
        }
        Ok(Self { name: name.to_owned(), count, properties: Vec::new() })
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ascii,
    Little,
    Big,
}

impl Format {
    fn parse(name: &str, version: &str) -> Result<Self, String> {
        if version != "1.0" {
            return Err(format!("version {version}: expected 1.0"));
        }
        Ok(match name {
            "ascii" => Self::Ascii,
            "binary_little_endian" => Self::Little,
            "binary_big_endian" => Self::Big,
            _ => return Err(format!("unknown format \"{name}\"")),
        })
    }
}

/// Values one after the other; in ascii files an element is a line.
struct Body<'a> {
    format: Format,
    bytes: &'a [u8],
    line: usize,
    words: Vec<&'a [u8]>,
    next_word: usize,
    /// Lines on which numbers were left when their element was read.
    longer: usize,
}

impl<'a> Body<'a> {
    fn start_element(&mut self) -> Result<(), String> {
        if self.format != Format::Ascii {
            return Ok(());
        }
        loop {
            if self.bytes.is_empty() {
                return Err("file ends early".to_owned());
            }
            let line = take_line(&mut self.bytes);
            self.line += 1;
            self.words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
            self.next_word = 0;
            if !self.words.is_empty() {
                return Ok(());
            }
        }
    }

    fn end_element(&mut self) {
        self.longer += usize::from(self.next_word < self.words.len());
    }

    fn value(&mut self, kind: Kind) -> Result<f64, String> {
        if self.format == Format::Ascii {
            let word = *self.words.get(self.next_word).ok_or("too few values")?;
            self.next_word += 1;
            let word = String::from_utf8_lossy(word);
            return word.parse().map_err(|_| format!("cannot read number '{word}'"));
        }
        let (head, tail) = self.bytes.split_at_checked(kind.size()).ok_or("file ends early")?;
        self.bytes = tail;
        let mut raw = [0_u8; 8];
        raw[..head.len()].copy_from_slice(head);
        if self.format == Format::Big {
            raw[..head.len()].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match kind {
            Kind::I8 => f64::from(a as i8),
            Kind::U8 => f64::from(a),
            Kind::I16 => f64::from(i16::from_le_bytes([a, b])),
            Kind::U16 => f64::from(u16::from_le_bytes([a, b])),
            Kind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Kind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Kind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::F64 => f64::from_le_bytes(raw),
        })
    }
}

/// The next line without its end; `\n`, `\r\n` and `\r` end lines.
fn take_line<'a>(bytes: &mut &'a [u8]) -> &'a [u8] {
    let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(bytes.len());
    let (line, rest) = bytes.split_at(end);
    let skip = if rest.starts_with(b"\r\n") { 2 } else { usize::from(!rest.is_empty()) };
    *bytes = &rest[skip..];
    line
}

/// Positions are relative to the context's origin. One part for each image that the file names, if it names any.
pub(crate) fn parse(path: &Path, bytes: &[u8], context: &mut Context) -> Result<Vec<Part>, SceneError> {
    let origin = context.origin;
    let mut rest = bytes;
    let mut line = 0;
    let header = header(&mut rest, &mut line, bytes.len()).map_err(|message| match line {
        0 | 1 => SceneError::file(path, message),
        _ => SceneError::at_line(path, line, message),
    })?;
    let Header { format, elements, images } = header;
    let mut body = Body { format, bytes: rest, line, words: Vec::new(), next_word: 0, longer: 0 };
    let mut mesh = PlyMesh::new(images);
    for element in &elements {
        for i in 0..element.count {
            let read = read_element(&mut body, element, origin, &mut mesh);
            read.map_err(|message| match format {
                Format::Ascii => SceneError::at_line(path, body.line, message),
                _ => SceneError::file(path, format!("{} {i}: {message}", element.name)),
            })?;
            body.end_element();
        }
    }
    tell_surplus(&body, path, context);
    let has_strips = elements.iter().any(|e| e.name == "tristrips" && e.count > 0);
    let is_empty = mesh.mesh.triangles.is_empty();
    if is_empty && has_strips {
        return Err(SceneError::file(path, "no triangles: strips (element tristrips) are not read"));
    }
    context.left_out(path, is_empty, &mesh.left_out())?;
    if has_strips {
        context.warn(path, "strips (element tristrips) are not read: only its faces are");
    }
    let mut properties = elements.iter().filter(|e| e.count > 0).flat_map(|e| &e.properties);
    if properties.any(|property| property.name == "material_index") {
        context.warn(path, "material_index is not read: its faces have one material");
    }
    if elements.iter().flat_map(|e| &e.properties).any(|property| property.name == "f_dc_0") {
        context.warn(path, "Gaussian splats are not read: only its faces are");
    }
    mesh.parts(path, context).map_err(|message| SceneError::file(path, message))
}

/// Warns of what the header does not announce: such a file is not what its header says.
fn tell_surplus(body: &Body<'_>, path: &Path, context: &mut Context) {
    match body.longer {
        0 => {}
        1 => context.warn(path, "a line has more numbers than its element: they are not read"),
        lines => context.warn(path, format!("{lines} lines have more numbers than their element: they are not read")),
    }
    let behind = body.bytes.trim_ascii().len();
    if behind > 0 {
        context.warn(path, format!("{behind} bytes behind its last element are not read"));
    }
}

struct Header {
    format: Format,
    elements: Vec<Element>,
    /// Names of images: MeshLab's comments.
    images: Vec<String>,
}

fn header(rest: &mut &[u8], line: &mut usize, size: usize) -> Result<Header, String> {
    let mut format = None;
    let mut images = Vec::new();
    let mut elements: Vec<Element> = Vec::new();
    loop {
        if rest.is_empty() {
            return Err(if *line == 0 { "file is empty" } else { "the header has no end_header" }.to_owned());
        }
        let text = String::from_utf8_lossy(take_line(rest)).into_owned();
        *line += 1;
        let words: Vec<&str> = text.split_whitespace().collect();
        match words[..] {
            ["ply"] if *line == 1 => {}
            _ if *line == 1 => return Err("not a PLY file".to_owned()),
            ["format", name, version] => format = Some(Format::parse(name, version)?),
            ["element", name, count] => elements.push(Element::parse(name, count, size)?),
            ["property", ref words @ ..] => {
                let property = Property::parse(words)?;
                elements.last_mut().ok_or("property before any element")?.properties.push(property);
            }
            ["end_header"] => break,
            ["comment", key, _, ..] if key.eq_ignore_ascii_case("TextureFile") => {
                // The name may have blanks.
                let name = text.split_once(key).map_or("", |(_, name)| name.trim());
                images.push(name.to_owned());
            }
            [] | ["comment" | "obj_info", ..] => {}
            [word, ..] => return Err(format!("unknown header line \"{word}\"")),
        }
    }
    let format = format.ok_or("the header states no format")?;
    let has = |element: &str, names: &[&str]| {
        let of = |e: &Element| names.iter().any(|n| e.properties.iter().any(|p| p.name == *n));
        elements.iter().find(|e| e.name == element).is_none_or(of)
    };
    for axis in ["x", "y", "z"] {
        if !has("vertex", &[axis]) {
            return Err(format!("vertex has no {axis}"));
        }
    }
    if !has("face", &["vertex_indices", "vertex_index"]) {
        return Err("face has no vertex_indices".to_owned());
    }
    let place = |element: &str| elements.iter().position(|e| e.name == element);
    if let (Some(face), Some(vertex)) = (place("face"), place("vertex"))
        && face < vertex
    {
        return Err("faces before vertices are not read: expected element vertex before element face".to_owned());
    }
    Ok(Header { format, elements, images })
}

fn read_element(body: &mut Body<'_>, element: &Element, origin: DVec3, all: &mut PlyMesh) -> Result<(), String> {
    body.start_element()?;
    let (is_vertex, is_face) = (element.name == "vertex", element.name == "face");
    let (mut position, mut normal, mut normal_parts) = (Vec3::ZERO, Vec3::ZERO, 0);
    let (mut color, mut uv): ([Option<f32>; 3], [Option<f32>; 2]) = ([None; 3], [None; 2]);
    let mut face = Face::default();
    for property in &element.properties {
        if property.length.is_some() {
            let known = all.mesh.positions.len();
            list(body, property, is_face.then_some((&mut face, known)))?;
            continue;
        }
        let fine = body.value(property.kind)?;
        let value = fine as f32;
        match property.name.as_str() {
            "x" => position.x = (fine - origin.x) as f32,
            "y" => position.y = (fine - origin.y) as f32,
            "z" => position.z = (fine - origin.z) as f32,
            "nx" => (normal.x, normal_parts) = (value, normal_parts + 1),
            "ny" => (normal.y, normal_parts) = (value, normal_parts + 1),
            "nz" => (normal.z, normal_parts) = (value, normal_parts + 1),
            "red" | "r" | "diffuse_red" => color[0] = Some(channel(fine, property.kind)),
            "green" | "g" | "diffuse_green" => color[1] = Some(channel(fine, property.kind)),
            "blue" | "b" | "diffuse_blue" => color[2] = Some(channel(fine, property.kind)),
            "alpha" if is_vertex || is_face => all.clear += usize::from(channel(fine, property.kind) < 1.0),
            "s" | "u" | "texture_u" => uv[0] = Some(value),
            // Counted from the lower edge of the image.
            "t" | "v" | "texture_v" => uv[1] = Some(1.0 - value),
            "texnumber" => face.image = Some(fine as i64),
            _ => {}
        }
    }
    let mesh = &mut all.mesh;
    if is_vertex {
        mesh.positions.push(position);
        if normal_parts == 3 {
            mesh.normals.push(normal);
        }
        if let [Some(r), Some(g), Some(b)] = color {
            mesh.colors.push(Vec3::new(r, g, b));
        }
        if let [Some(u), Some(v)] = uv {
            mesh.uv_sets.resize(1, Vec::new());
            mesh.uv_sets[0].push(Vec2::new(u, v));
        }
    } else if is_face {
        all.face(&Face { color, ..face })?;
    }
    Ok(())
}

/// Reads a list; those of a face that mean something into it, with the number of vertices that are known.
fn list(body: &mut Body<'_>, property: &Property, face: Option<(&mut Face, usize)>) -> Result<(), String> {
    let count = body.value(property.length.unwrap_or(property.kind))?;
    if !(count >= 0.0 && count.fract() == 0.0) {
        return Err(format!("a list of {count} values"));
    }
    let count = count as u64;
    match (property.name.as_str(), face) {
        ("vertex_indices" | "vertex_index", Some((face, known))) => {
            for _ in 0..count {
                let value = body.value(property.kind)?;
                if !(value >= 0.0 && value < known as f64 && value.fract() == 0.0) {
                    return Err(format!("face uses vertex {value}, there are {known}"));
                }
                face.corners.push(value as u32);
            }
        }
        ("texcoord", Some((face, _))) => {
            for _ in 0..count {
                face.uvs.push(body.value(property.kind)? as f32);
            }
        }
        _ => {
            for _ in 0..count {
                body.value(property.kind)?;
            }
        }
    }
    Ok(())
}

/// A colour's channel: integers are fractions of the largest; of 32 bits, as floats, they are of a range that their largest tells.
fn channel(value: f64, kind: Kind) -> f32 {
    let most = match kind {
        Kind::I8 => 127.0,
        Kind::U8 => 255.0,
        Kind::I16 => 32767.0,
        Kind::U16 => 65535.0,
        _ => 1.0,
    };
    (value / most) as f32
}
