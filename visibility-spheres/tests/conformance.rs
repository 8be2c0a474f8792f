//! The suite that all visibility strategies keep.

use conformance::{Limits, Setting, check};
use visibility_mask::{MaskVisibility, Mixture};
use visibility_spheres::SphereBlockers;

fn blockers(spheres: &[lobe_core::Sphere]) -> SphereBlockers {
    SphereBlockers::new(spheres, &vec![0; spheres.len()], &[])
}

#[test]
fn spheres() {
    let measured = check(&|s: &Setting<'_>| MaskVisibility::new(blockers(s.spheres)), &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}

/// The same masks, given as lobes.
#[test]
fn spheres_as_lobes() {
    let strategy = |s: &Setting<'_>| MaskVisibility::new(blockers(s.spheres)).with_lobes();
    let measured = check(&strategy, &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}

/// Every other sphere in the second half of a mixture: the limits are those of the parts.
#[test]
fn mixture() {
    let mixed = |s: &Setting<'_>| {
        let half = |k: usize| blockers(&s.spheres.iter().skip(k).step_by(2).copied().collect::<Vec<_>>());
        MaskVisibility::new(Mixture::new(half(0), half(1)))
    };
    let measured = check(&mixed, &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}
