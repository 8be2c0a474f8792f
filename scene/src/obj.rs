//! Wavefront OBJ: positions, normals, smoothing groups, texture coordinates, colours, polygons by material. Lines and curves are ignored.

use crate::context::{Context, counted};
use crate::mtl::without_comment;
use crate::obj_libraries::Libraries;
use crate::obj_normals::{self, smoothing_group};
use crate::part::Part;
use crate::{Mesh, SceneError, polygon, vertex_colors};
use brdf::Lambert;
use glam::{DVec3, Vec2, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// A corner of a face: position, and normal and texture coordinates where given.
pub(crate) type Corner = (u32, Option<u32>, Option<u32>);

/// A triangle, and the smoothing group that it is in; 0 for none.
pub(crate) struct Face {
    pub(crate) corners: [Corner; 3],
    pub(crate) group: u32,
}

/// The lists that corners refer to.
#[derive(Default)]
struct Lists {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Of positions; shorter than those where some have none.
    colors: Vec<Vec3>,
}

/// The text of an OBJ file. Names and comments may be in any encoding: bytes that are not UTF-8 are replaced.
pub(crate) fn obj_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    const WORDS: [&[u8]; 6] = [b"o", b"g", b"s", b"usemtl", b"mtllib", b"usemap"];
    String::from_utf8(bytes).or_else(|e| {
        let bytes = e.into_bytes();
        for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
            let begin = line.trim_ascii_start();
            let word = begin.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            let free = begin.starts_with(b"#") || WORDS.contains(&word);
            // A comment may follow numbers.
            let read = line.split(|b| *b == b'#').next().unwrap_or_default();
            if !free && std::str::from_utf8(read).is_err() {
                return Err(SceneError::at_line(path, number + 1, "not UTF-8 text"));
            }
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    })
}

/// The meshes of a file: one for each material in use, or a single one where there are no materials.
pub(crate) fn parse(path: &Path, text: &str, context: &mut Context) -> Result<Vec<Part>, SceneError> {
    let mut lists = Lists::default();
    // Triangles by material, in the order of first use.
    let mut names: Vec<String> = vec![String::new()];
    let mut known: HashMap<String, usize> = HashMap::from([(String::new(), 0)]);
    let mut groups: Vec<Vec<Face>> = vec![Vec::new()];
    let (mut group, mut smoothing) = (0, 0);
    let (mut short, mut infinite) = (0, 0);
    let mut libraries = Libraries::default();

    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Bare carriage returns end lines too, and a backslash at the end of a line joins it with the next.
    let unified = if text.contains('\r') {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        Cow::Borrowed(text)
    };
    let mut face: Vec<Corner> = Vec::new();
    let mut number = 0;
    let mut lines = unified.split('\n');
    while let Some(line) = lines.next() {
        number += 1;
        let first = number;
        let mut joined = String::new();
        let mut line = line;
        while let Some(head) = line.trim_end().strip_suffix('\\') {
            joined.push_str(head);
            joined.push(' ');
            line = lines.next().unwrap_or("");
            number += 1;
        }
        let whole = if joined.is_empty() {
            line
        } else {
            joined.push_str(line);
            &joined
        };
        let fault = |message: String| SceneError::at_line(path, first, message);
        let content = whole.split('#').next().unwrap_or("");
        let mut words = content.split_whitespace();
        match words.next() {
            Some("v") => {
                let (position, color) = vertex(words, context.origin).map_err(fault)?;
                lists.colors.extend(color.filter(|_| lists.colors.len() == lists.positions.len()));
                lists.positions.push(position);
            }
            Some("vn") => lists.normals.push(Vec3::from_array(numbers(&mut words).map_err(fault)?)),
            Some("vt") => lists.uvs.push(texture_coordinates(words).map_err(fault)?),
            Some("f") => {
                face.clear();
                for word in words {
                    face.push(corner(word, &lists).map_err(fault)?);
                }
                if face.len() < 3 {
                    short += 1;
                } else if !face.iter().all(|c| lists.positions[c.0 as usize].is_finite()) {
                    infinite += 1;
                } else {
                    let places: Vec<_> = face.iter().map(|c| lists.positions[c.0 as usize].as_dvec3()).collect();
                    polygon::ears(&places, &mut |triangle| {
                        groups[group].push(Face { corners: triangle.map(|k| face[k]), group: smoothing });
                    });
                }
            }
            Some("usemtl") => {
                let name = name_of(whole).split_whitespace().collect::<Vec<_>>().join(" ");
                group = *known.entry(name).or_insert_with_key(|name| {
                    names.push(name.clone());
                    groups.push(Vec::new());
                    names.len() - 1
                });
            }
            Some("s") => smoothing = smoothing_group(words),
            Some("mtllib") => libraries.add(path, name_of(whole), context),
            _ => {}
        }
    }
    let looks = libraries.looks(path, context)?;
    let mut left_out = vec![
        counted(short, "face", "fewer than three corners"),
        counted(infinite, "face", "corners that are NaN, infinite or beyond single precision (3.4e38)"),
    ];
    left_out.retain(|what| !what.is_empty());
    context.left_out(path, groups.iter().all(Vec::is_empty), &left_out.join(", "))?;
    let is_bare = groups.iter().flatten().all(|face| face.corners.iter().all(|c| c.1.is_none()));
    let broken = obj_normals::complete(&mut groups, &lists.positions, &mut lists.normals);
    if broken > 0 {
        context.warn(path, format!("{broken} corners have normals without a direction: they get those of their faces"));
    }
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let has_colors = lists.colors.len() == lists.positions.len();
    if let Some(one) = vertex_colors::decode(&mut lists.colors) {
        context.warn(path, vertex_colors::note(one));
    }
    // Names that no library has mean nothing: their faces stay together.
    let mut unnamed: Vec<Face> = Vec::new();
    let mut parts: Vec<Part> = Vec::new();
    for (number, (material, corners)) in names.into_iter().zip(groups).enumerate() {
        match looks.get(&material) {
            Some(look) if !corners.is_empty() => {
                let cut_out = look.cut_out.as_ref();
                let wants_uvs = look.surface.has_textures() || cut_out.is_some_and(|cut_out| cut_out.map.is_some());
                let mut mesh = assemble(&lists, &corners, wants_uvs, has_colors);
                if let Some(cut_out) = cut_out {
                    context.cut_out(path, &material, cut_out, (&mut mesh, &[]), false);
                }
                parts.push(Part::fixed(material, mesh, Some((number + 1, look.clone()))));
            }
            _ => unnamed.extend(corners),
        }
    }
    if !unnamed.is_empty() {
        let look = has_colors.then(|| (0, Lambert { albedo: Vec3::ONE }.into()));
        let mesh = assemble(&lists, &unnamed, true, has_colors);
        parts.insert(0, Part::fixed(name.clone(), mesh, look));
    }
    parts.iter_mut().for_each(|part| part.is_bare = is_bare);
    let take = |part: &Part| context.files.budget.take_mesh(&part.mesh, 1, &part.name);
    parts.iter().try_for_each(take).map_err(|message| SceneError::file(path, message))?;
    if let [part] = &mut parts[..] {
        part.name = name;
    }
    Ok(parts)
}

/// One vertex for each combination of position, normal and texture coordinates in use; these last where all corners have them and
/// they are wanted.
fn assemble(lists: &Lists, faces: &[Face], wants_uvs: bool, has_colors: bool) -> Mesh {
    let mut corners = faces.iter().flat_map(|face| &face.corners);
    let with_normals = corners.clone().all(|c| c.1.is_some());
    let with_uvs = wants_uvs && corners.all(|c| c.2.is_some());
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    // Without normals and texture coordinates a position is one vertex; else one for each combination.
    let mut places = vec![u32::MAX; if with_normals || with_uvs { 0 } else { lists.positions.len() }];
    let mut index: HashMap<Corner, u32> = HashMap::new();
    for face in faces {
        let triangle = face.corners.map(|(p, n, t)| {
            let key = (p, n.filter(|_| with_normals), t.filter(|_| with_uvs));
            let place = match places.get_mut(p as usize) {
                Some(place) => place,
                None => index.entry(key).or_insert(u32::MAX),
            };
            if *place == u32::MAX {
                *place = mesh.positions.len() as u32;
                mesh.positions.push(lists.positions[p as usize]);
                mesh.normals.extend(key.1.map(|n| lists.normals[n as usize]));
                uvs.extend(key.2.map(|t| lists.uvs[t as usize]));
                mesh.colors.extend(has_colors.then(|| lists.colors[p as usize]));
            }
            *place
        });
        mesh.triangles.push(triangle);
    }
    if with_uvs {
        mesh.uv_sets.push(uvs);
    }
    if with_normals {
        mesh.repair_normals();
    }
    mesh
}

/// The name that a statement gives, which may have blanks and `#`.
fn name_of(line: &str) -> &str {
    without_comment(line).trim().split_once(char::is_whitespace).map_or("", |(_, name)| name.trim())
}

fn number(word: &str) -> Result<f32, String> {
    word.parse().map_err(|_| format!("cannot read number '{word}'"))
}

fn numbers<'w>(words: &mut impl Iterator<Item = &'w str>) -> Result<[f32; 3], String> {
    let mut out = [0.0; 3];
    for slot in &mut out {
        *slot = number(words.next().ok_or("expected three numbers")?)?;
    }
    Ok(out)
}

/// `u`, `u v` or `u v w`; v counts from the lower edge of the image.
fn texture_coordinates<'w>(mut words: impl Iterator<Item = &'w str>) -> Result<Vec2, String> {
    let u = number(words.next().ok_or("expected a number")?)?;
    let v = words.next().map_or(Ok(0.0), number)?;
    Ok(Vec2::new(u, 1.0 - v))
}

/// `x y z`, `x y z w` (homogeneous) or `x y z r g b`, perhaps with alpha, which means nothing: a position, relative to an origin, and an
/// sRGB colour of any range.
fn vertex<'w>(words: impl Iterator<Item = &'w str> + Clone, origin: DVec3) -> Result<(Vec3, Option<Vec3>), String> {
    let mut more = words.clone().skip(3);
    let color = match [more.next(), more.next(), more.next()] {
        [Some(r), Some(g), Some(b)] => Some(Vec3::new(number(r)?, number(g)?, number(b)?)),
        _ => None,
    };
    Ok((position(words, origin)?, color))
}

fn position<'w>(mut words: impl Iterator<Item = &'w str> + Clone, origin: DVec3) -> Result<Vec3, String> {
    let fine = words.clone();
    let p = Vec3::from_array(numbers(&mut words)?);
    let (weight, mut is_one) = (words.next().map(number).transpose()?, true);
    for word in words {
        number(word)?;
        is_one = false;
    }
    if origin != DVec3::ZERO {
        let fine: Vec<f64> = fine.filter_map(|word| word.parse().ok()).collect();
        let w = if let [_, _, _, w] = fine[..] { w } else { 1.0 };
        return Ok((DVec3::from_slice(&fine) / w - origin).as_vec3());
    }
    match weight.filter(|_| is_one) {
        Some(w) if w != 0.0 => Ok(p / w),
        Some(_) => Err("vertex weight is 0".to_owned()),
        None => Ok(p),
    }
}

/// `p`, `p/t`, `p//n` or `p/t/n`: counted from 1, or from the last one back when negative.
fn corner(word: &str, lists: &Lists) -> Result<Corner, String> {
    let resolve = |field: &str, count: usize, what: &str| -> Result<u32, String> {
        let i: i64 = field.parse().map_err(|_| format!("cannot read face corner '{word}'"))?;
        let index = if i > 0 { i - 1 } else { i + count as i64 };
        if i == 0 || index < 0 || index >= count as i64 {
            return Err(format!("face uses {what} {i}, there are {count} so far"));
        }
        u32::try_from(index).map_err(|_| format!("too many {what}s"))
    };
    let mut fields = word.split('/');
    let p = resolve(fields.next().unwrap_or(""), lists.positions.len(), "vertex")?;
    let t = match fields.next() {
        None | Some("") => None,
        // Files that name coordinates that they do not have are drawn without.
        Some(field) => resolve(field, lists.uvs.len(), "texture coordinate").ok(),
    };
    let n = match fields.next() {
        None | Some("") => None,
        Some(field) => Some(resolve(field, lists.normals.len(), "normal")?),
    };
    if fields.next().is_some_and(|f| !f.is_empty()) {
        return Err(format!("cannot read face corner '{word}'"));
    }
    Ok((p, n, t))
}
