//! Small files in which one thing stands for many.

use cosine_lobes::lobe_core::oracle::Random;
use fuzz::TARGETS;
use image::{GrayImage, ImageFormat, Luma, Rgba, RgbaImage};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Bytes that files of one input may have.
const MOST: usize = 300_000;

/// A kind of files.
pub(crate) struct Growth {
    pub(crate) name: &'static str,
    /// Writes files to a folder, and returns the one that a program is to open.
    write: fn(&Path, &mut Random) -> PathBuf,
}

pub(crate) const KINDS: [Growth; 14] = [
    Growth { name: "nodes of one mesh", write: nodes },
    Growth { name: "nodes of one lamp", write: lamps },
    Growth { name: "nodes of one round lamp", write: round_lamps },
    Growth { name: "primitives of one accessor", write: primitives },
    Growth { name: "instances", write: instances },
    Growth { name: "chains of nodes", write: chain },
    Growth { name: "a face of many corners", write: face },
    Growth { name: "one library many times", write: libraries },
    Growth { name: "materials that are missing", write: missing },
    Growth { name: "images as many maps", write: maps },
    Growth { name: "checkers of alpha", write: checkers },
    Growth { name: "lights", write: lights },
    Growth { name: "objects", write: objects },
    Growth { name: "parts of seeds, repeated", write: repeated },
];

impl Growth {
    /// Writes files of this kind, and returns the one to open.
    pub(crate) fn write(&self, folder: &Path, random: &mut Random) -> PathBuf {
        (self.write)(folder, random)
    }
}

/// A whole number whose logarithm is even.
fn count(random: &mut Random, from: f64, to: f64) -> usize {
    random.log_uniform(from, to) as usize
}

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let file = folder.join(name);
    fs::write(&file, bytes).expect("room for an input");
    file
}

/// A buffer of positions and one of indices, and the number of corners.
type Buffers = ([Vec<u8>; 2], usize);

/// A closed strip of triangles, `n` in length.
fn ring(n: usize) -> Buffers {
    let corner = |k: usize| {
        let (sin, cos) = (k as f32 / n as f32 * core::f32::consts::TAU).sin_cos();
        [cos, if k.is_multiple_of(2) { 0.0 } else { 0.3 }, sin]
    };
    let positions = (0..n).flat_map(corner).flat_map(f32::to_le_bytes).collect();
    let triangle = |k: usize| [k, (k + 1) % n, (k + 2) % n].map(|k| k as u16);
    ([positions, (0..n).flat_map(triangle).flat_map(u16::to_le_bytes).collect()], n)
}

/// A sphere of `n` times twice as many quads.
fn globe(n: usize) -> Buffers {
    let around = 2 * n;
    let corner = |k: usize| {
        let turn = |part: usize, all: usize| (part as f32 / all as f32 * core::f32::consts::PI).sin_cos();
        let ((sin, cos), (s, c)) = (turn(k / around, n), turn(2 * (k % around), around));
        [sin * c, cos, sin * s]
    };
    let triangles = |k: usize| {
        let [a, d] = [k, k + around];
        let [b, c] = [a, d].map(|first| first - k % around + (k + 1) % around);
        [a, b, c, a, c, d].map(|k| k as u16)
    };
    let positions = (0..around * (n + 1)).flat_map(corner).flat_map(f32::to_le_bytes).collect();
    ([positions, (0..around * n).flat_map(triangles).flat_map(u16::to_le_bytes).collect()], around * (n + 1))
}

/// A glTF file of one mesh; the texts are those of its nodes, of what stands beside its primitive, and of more at the top. Bytes of
/// `more` are a view of their own.
fn gltf(folder: &Path, mesh: Buffers, [nodes, roots, primitive, top]: [&str; 4], times: usize, more: &[u8]) -> PathBuf {
    let ([positions, indices], corners) = mesh;
    let count = indices.len() / 2;
    let (from, to) = (positions.len(), positions.len() + indices.len());
    let mut bin = [positions, indices].concat();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let behind = bin.len();
    bin.extend(more);
    let one = format!("{{\"attributes\":{{\"POSITION\":0}},\"indices\":1{primitive}}}");
    let primitives = vec![one; times].join(",");
    let translations = if more.is_empty() {
        String::new()
    } else {
        format!(",{{\"bufferView\":2,\"componentType\":5126,\"count\":{},\"type\":\"VEC3\"}}", more.len() / 12)
    };
    let view = if more.is_empty() {
        String::new()
    } else {
        format!(",{{\"buffer\":0,\"byteOffset\":{behind},\"byteLength\":{}}}", more.len())
    };
    put(folder, "m.bin", &bin);
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{roots}]}}],\"nodes\":[{nodes}],\
         \"meshes\":[{{\"primitives\":[{primitives}]}}],\"buffers\":[{{\"uri\":\"m.bin\",\"byteLength\":{}}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{from}}},{{\"buffer\":0,\"byteOffset\":{from},\"byteLength\":{}}}{view}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":{corners},\"type\":\"VEC3\",\
         \"min\":[-1,-1,-1],\"max\":[1,1,1]}},{{\"bufferView\":1,\"componentType\":5123,\"count\":{},\"type\":\"SCALAR\"}}\
         {translations}]{top}}}",
        bin.len(),
        to - from,
        count,
    );
    put(folder, "m.gltf", text)
}

/// Numbers with commas between them.
fn numbers(count: usize) -> String {
    (0..count).map(|k| k.to_string()).collect::<Vec<_>>().join(",")
}

/// Copies of a mesh, of even or uneven scales.
fn many_nodes(
    folder: &Path,
    random: &mut Random,
    copies: usize,
    mesh: Buffers,
    [primitive, top]: [&str; 2],
) -> PathBuf {
    let is_even = random.bits().is_multiple_of(2);
    let node = |k: usize| {
        let scale = 1.0 + k as f64 * 1e-4;
        let high = if is_even { scale } else { 1.0 };
        format!(
            "{{\"mesh\":0,\"translation\":[{},0,{}],\"scale\":[{scale},{high},{scale}]}}",
            3 * (k % 40),
            3 * (k / 40)
        )
    };
    let nodes = (0..copies).map(node).collect::<Vec<_>>().join(",");
    gltf(folder, mesh, [&nodes, &numbers(copies), primitive, top], 1, &[])
}

fn nodes(folder: &Path, random: &mut Random) -> PathBuf {
    let copies = count(random, 1.0, 3000.0);
    let mesh = ring(count(random, 8.0, 8000.0));
    many_nodes(folder, random, copies, mesh, ["", ""])
}

/// A material that emits.
const LAMP: [&str; 2] = [",\"material\":0", ",\"materials\":[{\"emissiveFactor\":[1,1,1]}]"];

fn lamps(folder: &Path, random: &mut Random) -> PathBuf {
    let copies = count(random, 1.0, 3000.0);
    let mesh = ring(count(random, 8.0, 8000.0));
    many_nodes(folder, random, copies, mesh, LAMP)
}

fn round_lamps(folder: &Path, random: &mut Random) -> PathBuf {
    let copies = count(random, 1.0, 3000.0);
    let mesh = globe(count(random, 2.0, 32.0));
    many_nodes(folder, random, copies, mesh, LAMP)
}

fn primitives(folder: &Path, random: &mut Random) -> PathBuf {
    let times = count(random, 1.0, 5000.0);
    gltf(folder, ring(count(random, 8.0, 8000.0)), ["{\"mesh\":0}", "0", "", ""], times, &[])
}

fn instances(folder: &Path, random: &mut Random) -> PathBuf {
    let places: Vec<u8> = (0..3 * count(random, 1.0, 10_000.0))
        .flat_map(|_| (random.between(-50.0, 50.0) as f32).to_le_bytes())
        .collect();
    let node = "{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}}";
    let used = ",\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"]";
    gltf(folder, ring(count(random, 8.0, 8000.0)), [node, "0", "", used], 1, &places)
}

fn chain(folder: &Path, random: &mut Random) -> PathBuf {
    let length = count(random, 2.0, 10_000.0);
    let node = |k: usize| {
        let inner = if k + 1 < length { format!("\"children\":[{}]", k + 1) } else { "\"mesh\":0".to_owned() };
        format!("{{{inner}}}")
    };
    let nodes = (0..length).map(node).collect::<Vec<_>>().join(",");
    gltf(folder, ring(8), [&nodes, "0", "", ""], 1, &[])
}

fn face(folder: &Path, random: &mut Random) -> PathBuf {
    let corners = count(random, 3.0, 12_000.0);
    let mut text = String::new();
    for _ in 0..corners {
        writeln!(text, "v {:.4} {:.4} 0", random.uniform(), random.uniform()).expect("memory");
    }
    let all = (1..=corners).map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    put(folder, "m.obj", format!("{text}f {all}\n"))
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn libraries(folder: &Path, random: &mut Random) -> PathBuf {
    let materials = (0..count(random, 1.0, 9000.0)).map(|k| format!("newmtl a{k}\nKd .5 .5 .5\n"));
    put(folder, "m.mtl", materials.collect::<String>());
    let lines = "mtllib m.mtl\n".repeat(count(random, 1.0, 3000.0));
    put(folder, "m.obj", format!("{lines}{TRIANGLE}usemtl a0\nf 1 2 3\n"))
}

fn missing(folder: &Path, random: &mut Random) -> PathBuf {
    let faces = (0..count(random, 1.0, 12_000.0)).map(|k| format!("usemtl q{k}\nf 1 2 3\n"));
    put(folder, "m.obj", format!("{TRIANGLE}{}", faces.collect::<String>()))
}

/// The beginning of a scene file, and a square with a material.
const HEAD: &str = "[camera]\neye = [0, 1, 6]\ntarget = [0, 0, 0]\n";
const LIGHT: &str = "[[lights]]\nkind = \"sphere\"\ncenter = [0, 4, 3]\nradius = 0.5\nradiance = 9\n";

fn square(k: usize, material: &str) -> String {
    let [x, y] = [k % 8, k / 8].map(|at| at as f32 - 3.5);
    format!(
        "[[objects]]\nquad = {{ center = [{x:?}, {y:?}, 0.0], u = [0.4, 0, 0], v = [0, 0.4, 0] }}\nmaterial = \"{material}\"\n"
    )
}

fn maps(folder: &Path, random: &mut Random) -> PathBuf {
    let side = count(random, 1.0, 4096.0) as u32;
    GrayImage::from_pixel(side, side, Luma([128]))
        .save_with_format(folder.join("g.png"), ImageFormat::Png)
        .expect("room for an image");
    let mut text = HEAD.to_owned() + LIGHT;
    for k in 0..count(random, 1.0, 64.0) {
        let all = ["color_map", "roughness_map", "metallic_map", "normal_map", "coat_map"]
            .map(|map| format!("{map} = \"g.png\"\n"));
        write!(
            text,
            "[materials.m{k}]\nmodel = \"metallic-roughness\"\n{}{}",
            all.concat(),
            square(k, &format!("m{k}"))
        )
        .expect("memory");
    }
    put(folder, "m.toml", text)
}

fn checkers(folder: &Path, random: &mut Random) -> PathBuf {
    let side = count(random, 1.0, 300.0) as u32;
    let texel = |x: u32, y: u32| Rgba([200, 200, 200, if (x + y).is_multiple_of(2) { 255 } else { 0 }]);
    RgbaImage::from_fn(side, side, texel)
        .save_with_format(folder.join("a.png"), ImageFormat::Png)
        .expect("room for an image");
    let material = "[materials.m]\nmodel = \"lambert\"\ncolor_map = \"a.png\"\nalpha_cutoff = 0.5\n";
    let squares = (0..count(random, 1.0, 16.0)).map(|k| square(k, "m")).collect::<String>();
    put(folder, "m.toml", format!("{HEAD}{LIGHT}{material}{squares}"))
}

fn lights(folder: &Path, random: &mut Random) -> PathBuf {
    const KINDS: [&str; 4] = [
        "kind = \"point\"\nintensity = 1",
        "kind = \"disc\"\nnormal = [0, -1, 0]\nradius = 0.3\nradiance = 1",
        "kind = \"rectangle\"\nu = [0.3, 0, 0]\nv = [0, 0, 0.3]\nradiance = 1",
        "kind = \"sphere\"\nradius = 0.3\nradiance = 1",
    ];
    let kind = KINDS[(random.bits() % 4) as usize];
    let light = |k: usize| format!("[[lights]]\ncenter = [{}, 4, {}]\n{kind}\n", k % 60, k / 60);
    let all = (0..count(random, 1.0, 3000.0)).map(light).collect::<String>();
    put(folder, "m.toml", format!("{HEAD}{all}[[objects]]\nsphere = {{ center = [0, 0, 0], radius = 1 }}\n"))
}

fn objects(folder: &Path, random: &mut Random) -> PathBuf {
    const KINDS: [&str; 3] = [
        "sphere = { center = [0, 0, 0], radius = 0.4 }",
        "box = { center = [0, 0, 0], size = [0.5, 0.5, 0.5] }",
        "plane = { point = [0, 0, 0], normal = [0, 1, 0], size = 0.8 }",
    ];
    let kind = KINDS[(random.bits() % 3) as usize];
    let object = |k: usize| format!("[[objects]]\n{kind}\ntranslate = [{}, 0, {}]\n", k % 60, k / 60);
    let all = (0..count(random, 1.0, 3000.0)).map(object).collect::<String>();
    put(folder, "m.toml", format!("{HEAD}{LIGHT}{all}"))
}

fn repeated(folder: &Path, random: &mut Random) -> PathBuf {
    let names = ["obj", "ply", "gltf", "scene_file"];
    let name = names[(random.bits() % 4) as usize];
    let target = TARGETS.iter().find(|target| target.name == name).expect("a target");
    let seeds = target.seeds();
    let seed = &seeds[(random.bits() % seeds.len() as u64) as usize];
    let [from, length] = [seed.len(), 200].map(|below| (random.bits() % (below as u64 + 1)) as usize);
    let part = &seed[from..(from + length).min(seed.len())];
    let times = count(random, 1.0, (MOST / part.len().max(1)) as f64 + 2.0);
    let data = [&seed[..from], &part.repeat(times), &seed[from..]].concat();
    let ending = if name == "scene_file" { "toml" } else { name };
    put(folder, &format!("m.{ending}"), data)
}
