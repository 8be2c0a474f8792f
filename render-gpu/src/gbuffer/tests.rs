//! The structs that Rust writes for the kernels of rays have the layout that WGSL reads.

use super::*;
use crate::bvh::{GpuNode, GpuPrimitive};
use crate::validated;
use core::mem::{offset_of, size_of};
use naga::TypeInner;

fn module() -> naga::Module {
    validated::module(&trace_text(64).text)
}

/// Size and offsets of the members of a struct.
#[track_caller]
fn check(module: &naga::Module, name: &str, size: usize, offsets: &[usize]) {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).expect(name).1;
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    assert_eq!(*span as usize, size, "{name}");
    assert_eq!(members.iter().map(|m| m.offset as usize).collect::<Vec<_>>(), offsets, "{name}");
}

#[test]
fn structs_are_laid_out_as_in_rust() {
    let module = module();
    let node =
        [offset_of!(GpuNode, low), offset_of!(GpuNode, count), offset_of!(GpuNode, high), offset_of!(GpuNode, first)];
    check(&module, "BvhNode", size_of::<GpuNode>(), &node);
    let primitive = [
        offset_of!(GpuPrimitive, a),
        offset_of!(GpuPrimitive, object),
        offset_of!(GpuPrimitive, b),
        offset_of!(GpuPrimitive, material),
        offset_of!(GpuPrimitive, c),
        offset_of!(GpuPrimitive, corners),
    ];
    check(&module, "Primitive", size_of::<GpuPrimitive>(), &primitive);
    check(&module, "View", size_of::<GpuView>(), &GpuView::OFFSETS);
}

#[test]
fn a_workgroup_is_a_tile() {
    assert!(trace_text(64).text.contains("@workgroup_size(64)") && TILE * TILE == 64);
}

/// Every pixel of a window has one place, in the order of tiles.
#[test]
fn places_are_pixels() {
    for (columns, rows) in [(0..20, 0..9), (5..19, 3..17), (8..16, 8..16)] {
        let camera = scene::builtin().camera;
        let view = GpuView::new(&camera, [20, 17], [&columns, &rows], &scene::Bounds::EMPTY, 1.0);
        let [across, down] = view.tiles();
        let tile = |place: u32| place / (TILE * TILE);
        let pixels: Vec<_> = (0..across * down * TILE * TILE)
            .filter_map(|place| view.pixel(place).map(|pixel| (tile(place), pixel)))
            .collect();
        assert!(pixels.is_sorted());
        let mut all: Vec<_> = pixels.iter().map(|(_, pixel)| *pixel).collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..(columns.len() * rows.len()) as u32));
    }
}
