//! The suite that all visibility strategies keep.

use lobe_core::conformance::{Limits, Setting, check};
use visibility_mask::{MaskVisibility, Mixture};
use visibility_spheres::SphereBlockers;

fn blockers(balls: &[lobe_core::Sphere]) -> SphereBlockers {
    SphereBlockers::new(balls, &vec![0; balls.len()], &[])
}

#[test]
fn spheres() {
    let measured = check(&|s: &Setting<'_>| MaskVisibility::new(blockers(s.balls)), &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}

/// The same masks, given as lobes.
#[test]
fn spheres_as_lobes() {
    let strategy = |s: &Setting<'_>| MaskVisibility::new(blockers(s.balls)).with_lobes();
    let measured = check(&strategy, &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}

/// Every other ball in the second half of a mixture: the limits are those of the parts.
#[test]
fn mixture() {
    let mixed = |s: &Setting<'_>| {
        let half = |k: usize| blockers(&s.balls.iter().skip(k).step_by(2).copied().collect::<Vec<_>>());
        MaskVisibility::new(Mixture::new(half(0), half(1)))
    };
    let measured = check(&mixed, &Limits::default());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}
