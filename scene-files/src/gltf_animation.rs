//! Clips of a glTF document.

use crate::gltf_buffers::Buffers;
use glam::Vec4;
use gltf::json::accessor::Type;
use gltf::json::animation::{Animation, Channel, Property, Sampler};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root, animation};
use scene::MAX_COORDINATE;
use scene::motion::{Clock, Interpolation, Local, MAX_SECONDS, Meaning, Skeleton, Track};

/// The name of a clip: its number where it has none.
pub(crate) fn clip_name(root: &Root, clip: usize) -> String {
    root.animations[clip].name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| clip.to_string())
}

/// The clip of that name, else of that number.
pub(crate) fn find_clip(root: &Root, wanted: &str) -> Result<usize, String> {
    let count = root.animations.len();
    let number = || wanted.parse().ok().filter(|&i: &usize| i < count);
    (0..count).find(|&i| clip_name(root, i) == wanted).or_else(number).ok_or_else(|| {
        if count == 0 {
            return format!("there is no clip \"{wanted}\": the file has no animations");
        }
        let list: Vec<String> = (0..count).map(|i| format!("\"{}\"", clip_name(root, i))).collect();
        format!("there is no clip \"{wanted}\": expected one of {}", list.join(", "))
    })
}

/// The unsupported features of a clip, one line each.
pub(crate) struct Played {
    pub(crate) notes: Vec<String>,
    /// Whether at least one of its channels is supported.
    pub(crate) usable: bool,
}

/// Gives the nodes the tracks of a clip. A fault leaves the nodes in an unspecified state.
pub(crate) fn play(root: &Root, buffers: &Buffers<'_>, clip: usize, skeleton: &mut Skeleton) -> Result<Played, String> {
    let animation = &root.animations[clip];
    let (mut notes, mut played) = (Vec::new(), 0);
    let (mut first, mut last) = (f32::INFINITY, 0.0_f32);
    for (c, channel) in animation.channels.iter().enumerate() {
        let fault = |e: String| format!("animation {clip}, channel {c}: {e}");
        let s = channel.sampler.value();
        let sampler = animation.samplers.get(s).ok_or_else(|| {
            fault(format!("there is no sampler {s}: expected one of the {} that it has", animation.samplers.len()))
        })?;
        match add(buffers, channel, sampler, skeleton).map_err(fault)? {
            Ok(([start, end], is_second)) => {
                (first, last, played) = (first.min(start), last.max(end), played + 1);
                if is_second {
                    notes.push(fault("an earlier one moves the same: it is left out".to_owned()));
                }
            }
            Err(note) => notes.push(fault(note)),
        }
    }
    skeleton.clock = Clock { first: first.clamp(0.0, last), last, repeats: true };
    Ok(Played { notes, usable: played > 0 })
}

/// The bytes of a clip's keys. Each channel has its own, though several may name the same accessors.
pub(crate) fn key_bytes(root: &Root, animation: &Animation) -> u64 {
    let of = |index: Index<Accessor>| {
        let Some(accessor) = root.accessors.get(index.value()) else { return 0 };
        let width = if let Checked::Valid(kind) = accessor.type_ { kind.multiplicity() } else { 1 };
        let claimed = accessor.count.0.saturating_mul((width * size_of::<f32>()) as u64);
        // A byte of a view may be a number.
        let view = accessor.buffer_view.and_then(|view| root.buffer_views.get(view.value()));
        view.map_or(claimed, |view| claimed.min(view.byte_length.0.saturating_mul(size_of::<f32>() as u64)))
    };
    let samplers = animation.channels.iter().filter_map(|channel| animation.samplers.get(channel.sampler.value()));
    samplers.map(|sampler| of(sampler.input).saturating_add(of(sampler.output))).fold(0, u64::saturating_add)
}

/// The first and the last key's time of the channel, and whether an earlier one moved the same, or why it is left out.
fn add(
    buffers: &Buffers<'_>,
    channel: &Channel,
    sampler: &Sampler,
    skeleton: &mut Skeleton,
) -> Result<Result<([f32; 2], bool), String>, String> {
    let node = channel.target.node.value();
    let nodes = skeleton.bones.len();
    let bone = skeleton
        .bones
        .get_mut(node)
        .ok_or_else(|| format!("there is no node {node}: expected one of the {nodes} that the file has"))?;
    let (kind, width, meaning) = match &channel.target.path {
        Checked::Invalid => return Ok(Err("unknown path: left out".to_owned())),
        Checked::Valid(Property::Rotation) => (Type::Vec4, 4, Meaning::Rotation),
        Checked::Valid(Property::Translation | Property::Scale) => (Type::Vec3, 3, Meaning::Numbers),
        Checked::Valid(Property::MorphTargetWeights) => (Type::Scalar, bone.rest_weights.len(), Meaning::Numbers),
    };
    if width == 0 {
        return Ok(Err(format!("node {node} has no morph targets: left out")));
    }
    let track = read_track(buffers, sampler, kind, width, meaning)?;
    let span = [track.start(), track.end()];
    if let (Local::Matrix(m), true) = (&bone.local, kind != Type::Scalar) {
        let (scale, rotation, translation) = m.to_scale_rotation_translation();
        if !(scale.is_finite() && rotation.is_finite() && translation.is_finite()) {
            return Err(format!("node {node} has a matrix that is no scale, rotation and translation"));
        }
        bone.local = Local::Parts { scale, rotation, translation };
    }
    let slot = match channel.target.path {
        Checked::Valid(Property::Rotation) => &mut bone.rotation,
        Checked::Valid(Property::Translation) => &mut bone.translation,
        Checked::Valid(Property::Scale) => &mut bone.scale,
        _ => &mut bone.weights,
    };
    let is_second = slot.replace(track).is_some();
    Ok(Ok((span, is_second)))
}

/// The keys of a channel, `width` numbers each.
fn read_track(
    buffers: &Buffers<'_>,
    sampler: &Sampler,
    kind: Type,
    width: usize,
    meaning: Meaning,
) -> Result<Track, String> {
    let interpolation = match sampler.interpolation {
        Checked::Valid(animation::Interpolation::Linear) => Interpolation::Linear,
        Checked::Valid(animation::Interpolation::Step) => Interpolation::Step,
        Checked::Valid(animation::Interpolation::CubicSpline) => Interpolation::Cubic,
        Checked::Invalid => return Err("unknown interpolation: expected LINEAR, STEP or CUBICSPLINE".to_owned()),
    };
    let times = buffers.floats(sampler.input, Type::Scalar)?;
    if let Some(t) = times.iter().find(|t| t.is_nan() || t.abs() > MAX_SECONDS) {
        return Err(format!("key at {t:e} s: times must lie within ±{MAX_SECONDS} s"));
    }
    // Equal times are a jump, which does no harm.
    if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
        return Err(format!("key times are not in order: {} s after {} s", pair[1], pair[0]));
    }
    let values = buffers.floats(sampler.output, kind)?;
    let rows = if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if values.len() != times.len() * width * rows {
        let (n, keys) = (values.len() / kind.multiplicity(), times.len());
        return Err(format!("{n} values for {keys} keys: expected {}", keys * rows * width / kind.multiplicity()));
    }
    if let Some(v) = values.iter().find(|v| v.is_nan() || v.abs() > MAX_COORDINATE) {
        return Err(format!("value {v}: keys must lie within ±1e9"));
    }
    if meaning == Meaning::Rotation {
        // Of a cubic key's three rows the middle one is the rotation.
        let quaternions = values.chunks_exact(4).skip(rows / 2).step_by(rows);
        if let Some(k) = quaternions.map(Vec4::from_slice).position(|q| q.length() < 1e-6) {
            return Err(format!("rotation key {k} has length 0: expected a unit quaternion"));
        }
    }
    Ok(Track::new(times, values, width, interpolation, meaning))
}
