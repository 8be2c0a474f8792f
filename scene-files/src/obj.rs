//! Wavefront OBJ: positions, normals, smoothing groups, texture coordinates, colours, polygons by material. Points, lines, curves and surfaces are left out.

use crate::appearance::Appearance;
use crate::context::{Context, broken_uvs, counted};
use crate::mtl::without_comment;
use crate::obj_libraries::Libraries;
use crate::obj_lines::{self, Run, UNREAD};
use crate::obj_normals::{self, smoothing_group};
use crate::part::Part;
use crate::polygon::{self, Cut};
use crate::vertex_colors;
use brdf::Lambert;
use glam::{Vec2, Vec3};
use scene::{Mesh, SceneError};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
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
    /// Positions with a colour.
    colored: usize,
    /// Elements of each kind that is not read.
    unread: [usize; UNREAD.len()],
    /// First words of lines of no known kind.
    unknown: BTreeSet<String>,
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
    let (mut lists, groups, [short, infinite]) = read(path, text, context)?;
    let Groups { names, lists: mut groups, libraries, tangled, .. } = groups;
    context.tell_tangled(path, tangled);
    lists.tell_unknown(path, context);
    context.tell_broken_uvs(path, broken_uvs(&lists.uvs));
    let has_libraries = libraries.are_there();
    let appearances = libraries.appearances(path, context)?;
    match unknown(&names, &groups, &appearances, has_libraries) {
        Some(note) if has_libraries => context.warn(path, note),
        note => context.no_library = note.map(|note| SceneError::file(path, note).to_string()),
    }
    let mut left_out = vec![
        counted(short, "face", "fewer than three corners"),
        counted(infinite, "face", "corners that are NaN, infinite or beyond single precision (3.4e38)"),
    ];
    left_out.extend(UNREAD.iter().zip(lists.unread).map(|((_, name), count)| counted(count, name, "being no face")));
    left_out.retain(|what| !what.is_empty());
    context.left_out(path, groups.iter().all(Vec::is_empty), &left_out.join(", "))?;
    let is_bare = groups.iter().flatten().all(|face| face.corners.iter().all(|c| c.1.is_none()));
    let broken = obj_normals::complete(&mut groups, &lists.positions, &mut lists.normals);
    if broken > 0 {
        context.warn(path, format!("{broken} corners have normals without a direction: they get those of their faces"));
    }
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let has_colors = lists.decode_colors(path, context);
    // Names that no library has mean nothing: their faces stay together.
    let mut unnamed: Vec<Face> = Vec::new();
    let mut parts: Vec<Part> = Vec::new();
    for (number, (material, corners)) in names.into_iter().zip(groups).enumerate() {
        match appearances.get(&material) {
            Some(appearance) if !corners.is_empty() => {
                let mesh = textured(path, (&material, appearance), (&lists, has_colors), &corners, context);
                parts.push(Part::fixed(material, mesh, Some((number + 1, appearance.clone()))));
            }
            _ => unnamed.extend(corners),
        }
    }
    if !unnamed.is_empty() {
        let appearance = has_colors.then(|| (0, Lambert { albedo: Vec3::ONE }.into()));
        let mesh = assemble(&lists, &unnamed, faces_without_uvs(&unnamed) == 0, has_colors);
        parts.insert(0, Part::fixed(name.clone(), mesh, appearance));
    }
    parts.iter_mut().for_each(|part| part.is_bare = is_bare);
    let take = |part: &Part| context.files.budget.take_mesh(&part.mesh, 1, &part.name);
    parts.iter().try_for_each(take).map_err(|message| SceneError::file(path, message))?;
    if let [part] = &mut parts[..] {
        part.name = name;
    }
    Ok(parts)
}

/// The mesh of the faces of one material. Those without texture coordinates beside others that have some show a corner of its images.
fn textured(
    path: &Path,
    (material, appearance): (&str, &Appearance),
    (lists, has_colors): (&Lists, bool),
    faces: &[Face],
    context: &mut Context,
) -> Mesh {
    let cut_out = appearance.cut_out.as_ref();
    let wants_uvs = appearance.surface.has_textures() || cut_out.is_some_and(|cut_out| cut_out.map.is_some());
    let bare = faces_without_uvs(faces);
    let with_uvs = wants_uvs && bare < faces.len();
    if with_uvs && bare > 0 {
        let note =
            format!("{bare} faces of {material} have no texture coordinates: they show a corner of its textures");
        context.warn(path, note);
    }
    let mut mesh = assemble(lists, faces, with_uvs, has_colors);
    if let Some(cut_out) = cut_out {
        context.cut_out(path, material, cut_out, (&mut mesh, &[]), false);
    }
    mesh
}

/// The number of faces of which a corner has no texture coordinates.
fn faces_without_uvs(faces: &[Face]) -> usize {
    faces.iter().filter(|face| face.corners.iter().any(|corner| corner.2.is_none())).count()
}

/// A line about materials that faces use and no library has.
fn unknown(
    names: &[String],
    groups: &[Vec<Face>],
    appearances: &HashMap<String, Appearance>,
    has_libraries: bool,
) -> Option<String> {
    let used = names.iter().zip(groups).filter(|(name, faces)| !name.is_empty() && !faces.is_empty());
    let unknown: Vec<&str> =
        used.filter(|(name, _)| !appearances.contains_key(*name)).map(|(name, _)| &name[..]).collect();
    let where_to = if has_libraries { "no library has" } else { "the file names no library (mtllib) of" };
    match unknown[..] {
        [] => None,
        [name] => Some(format!("{where_to} the material {name}: its faces have the default one")),
        [first, ..] => {
            let count = unknown.len();
            Some(format!("{where_to} {count} materials ({first}, …): their faces have the default one"))
        }
    }
}

/// All numbers and faces of a file, and how many faces were left out for each of two reasons: too few corners, and infinite ones.
fn read(path: &Path, text: &str, context: &mut Context) -> Result<(Lists, Groups, [usize; 2]), SceneError> {
    let mut lists = Lists::default();
    let mut groups = Groups::default();
    let (mut short, mut infinite) = (0, 0);

    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Bare carriage returns end lines too, and a backslash at the end of a line joins it with the next.
    let unified = if text.contains('\r') {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        Cow::Borrowed(text)
    };
    let mut face: Vec<Corner> = Vec::new();
    let mut lines = 0;
    for run in obj_lines::read(&unified, context.origin) {
        let base = lists.counts();
        lists.append(&run);
        let mut others = run.others.iter().peekable();
        let mut begin = 0;
        for (number, line) in run.faces.iter().enumerate() {
            while let Some(other) = others.next_if(|other| other.faces <= number) {
                groups.read(path, &other.text, context);
            }
            face.clear();
            let counts = [0, 1, 2].map(|k| base[k] + line.before[k] as usize);
            for corner in &run.corners[begin..line.end] {
                let fault = |message: String| SceneError::at_line(path, lines + line.line as usize, message);
                face.push(resolved(corner, counts).map_err(fault)?);
            }
            begin = line.end;
            if face.len() < 3 {
                short += 1;
            } else if !face.iter().all(|c| lists.positions[c.0 as usize].is_finite()) {
                infinite += 1;
            } else {
                groups.add(&face, &lists.positions);
            }
        }
        others.for_each(|other| groups.read(path, &other.text, context));
        if let Some((line, message)) = run.fault {
            return Err(SceneError::at_line(path, lines + line, message));
        }
        lines += run.lines;
    }
    Ok((lists, groups, [short, infinite]))
}

/// One vertex for each combination of position, normal and texture coordinates in use; these last are those of an image's lower left corner
/// where a corner has none.
fn assemble(lists: &Lists, faces: &[Face], with_uvs: bool, has_colors: bool) -> Mesh {
    let with_normals = faces.iter().flat_map(|face| &face.corners).all(|c| c.1.is_some());
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    // Without normals and texture coordinates a position is one vertex; else one for each combination.
    let mut places = vec![u32::MAX; if with_normals || with_uvs { 0 } else { lists.positions.len() }];
    let mut index: HashMap<Corner, u32, foldhash::fast::RandomState> = HashMap::default();
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
                uvs.extend(with_uvs.then(|| key.2.map_or(Vec2::Y, |t| lists.uvs[t as usize])));
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

/// A corner as written, with so many positions, texture coordinates and normals before it: counted from 1, or from the last one back when
/// negative.
fn resolved(&[p, t, n]: &[i32; 3], counts: [usize; 3]) -> Result<Corner, String> {
    let index = |i: i32, count: usize| {
        let index = if i > 0 { i64::from(i) - 1 } else { i64::from(i) + count as i64 };
        let is_there = i != 0 && (0..count as i64).contains(&index);
        u32::try_from(index).ok().filter(|_| is_there)
    };
    let resolve = |i: i32, count: usize, what: &str| {
        index(i, count).ok_or_else(|| format!("face uses {what} {i}, there are {count} so far"))
    };
    let p = resolve(p, counts[0], "vertex")?;
    // Files that name coordinates that they do not have are drawn without.
    let t = index(t, counts[1]);
    let n = if n == obj_lines::ABSENT { None } else { Some(resolve(n, counts[2], "normal")?) };
    Ok((p, n, t))
}

/// The triangles of a file by material, in the order of first use.
struct Groups {
    names: Vec<String>,
    known: HashMap<String, usize>,
    lists: Vec<Vec<Face>>,
    /// The present material and smoothing group.
    material: usize,
    smoothing: u32,
    libraries: Libraries,
    /// Faces that cross themselves.
    tangled: usize,
}

impl Default for Groups {
    fn default() -> Self {
        Self {
            names: vec![String::new()],
            known: HashMap::from([(String::new(), 0)]),
            lists: vec![Vec::new()],
            material: 0,
            smoothing: 0,
            libraries: Libraries::default(),
            tangled: 0,
        }
    }
}

impl Groups {
    /// Adds a face of three corners or more.
    fn add(&mut self, face: &[Corner], positions: &[Vec3]) {
        let (group, list) = (self.smoothing, &mut self.lists[self.material]);
        if let [a, b, c] = *face {
            list.push(Face { corners: [a, b, c], group });
            return;
        }
        let places: Vec<_> = face.iter().map(|c| positions[c.0 as usize].as_dvec3()).collect();
        let cut = polygon::ears(&places, &mut |triangle| list.push(Face { corners: triangle.map(|k| face[k]), group }));
        self.tangled += usize::from(cut == Cut::Tangled);
    }

    /// Reads a line that is neither a list's nor a face.
    fn read(&mut self, path: &Path, line: &str, context: &mut Context) {
        let content = line.split('#').next().unwrap_or("");
        let mut words = content.split_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("usemtl") => {
                let name = name_of(line).split_whitespace().collect::<Vec<_>>().join(" ");
                self.material = *self.known.entry(name).or_insert_with_key(|name| {
                    self.names.push(name.clone());
                    self.lists.push(Vec::new());
                    self.names.len() - 1
                });
            }
            Some("s") => self.smoothing = smoothing_group(words),
            Some("mtllib") => self.libraries.add(path, name_of(line), context),
            _ => {}
        }
    }
}

impl Lists {
    /// Makes colours linear. Returns whether all positions have one: else they are left out, with a warning.
    fn decode_colors(&mut self, path: &Path, context: &mut Context) -> bool {
        let (some, all) = (self.colored, self.positions.len());
        if some < all {
            if some > 0 {
                context.warn(path, format!("{some} of {all} vertices have colours: these are left out"));
            }
            return false;
        }
        if let Some(note) = vertex_colors::decode(&mut self.colors) {
            context.warn(path, note);
        }
        true
    }

    /// Warns of lines of no known kind.
    fn tell_unknown(&self, path: &Path, context: &mut Context) {
        let few: Vec<String> = self.unknown.iter().take(8).map(|word| format!("\"{}\"", word.escape_debug())).collect();
        if !few.is_empty() {
            context.warn(path, format!("lines that begin with {} are not read", few.join(", ")));
        }
    }

    /// Positions, texture coordinates and normals.
    fn counts(&self) -> [usize; 3] {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    fn append(&mut self, run: &Run<'_>) {
        if self.colors.len() == self.positions.len() {
            self.colors.extend_from_slice(&run.colors);
        }
        self.colored += run.colored;
        self.unknown.extend(run.unknown.iter().cloned());
        self.unread.iter_mut().zip(run.unread).for_each(|(sum, count)| *sum += count);
        self.positions.extend_from_slice(&run.positions);
        self.normals.extend_from_slice(&run.normals);
        self.uvs.extend_from_slice(&run.uvs);
    }
}
