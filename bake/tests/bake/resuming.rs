//! Bakes that are interrupted.

use crate::support::{File, WHOLE};
use bake::{BakeError, BakeSettings, Baked, Baker, Form, Stage, Steps};
use core::ops::ControlFlow;
use glam::Vec3;
use renderer::Settings;
use scene_files::LoadOptions;
use serde_json::json;

/// Steps in memory.
#[derive(Clone, Default)]
struct Kept {
    steps: Vec<Vec<u8>>,
    taken: usize,
    made: usize,
}

impl Steps for Kept {
    fn resume(&mut self) -> Option<Vec<u8>> {
        let next = self.steps.get(self.taken).filter(|_| self.made == 0).cloned();
        self.taken += usize::from(next.is_some());
        next
    }

    fn keep(&mut self, result: Vec<u8>) {
        self.made += 1;
        self.steps.truncate(self.taken + self.made - 1);
        self.steps.push(result);
    }
}

/// Bakes until a number of reports of light have come, if one is given.
fn bake(file: &File, settings: BakeSettings, kept: &mut Kept, reports: Option<usize>) -> Result<Baked, BakeError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, file.glb()).unwrap();
    let mut baker = Baker::open(&path, &LoadOptions::new(), settings, Settings::default()).unwrap();
    let mut count = 0;
    let mut hear = |stage: Stage, _: f32| {
        count += usize::from(stage == Stage::Light);
        if reports.is_some_and(|most| count >= most) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    baker.bake_with(&mut hear, kept)
}

/// A bake that was stopped after any step has the bytes of one that was not, and takes the finished steps up, in every form.
#[test]
fn the_bytes_are_those_of_an_uninterrupted_bake() {
    let mut file = File::new();
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], WHOLE);
    file.block("block", Vec3::Y * 0.3, Vec3::splat(0.2));
    file.light(json!({"type": "point", "intensity": 5.0}), Vec3::new(0.5, 1.0, 0.3));
    // Bands of 85 rows of 8 × 8 points.
    let texels = BakeSettings { page: 96, samples: 8, ..BakeSettings::DEFAULT };
    let colors = BakeSettings { form: Form::VertexColors, ..BakeSettings::DEFAULT };
    for (settings, least) in [
        (BakeSettings { form: Form::Lightmap, per_light: true, ..texels }, 4),
        (texels, 4),
        (colors, 2),
        (BakeSettings { subdivide: Some(0.05), ..colors }, 4),
    ] {
        let mut all = Kept::default();
        let want = bake(&file, settings, &mut all, None).unwrap();
        assert!(all.made >= least && all.taken == 0, "{settings:?}: {} steps, {:?}", all.made, want.pages);
        for reports in [1, 2].into_iter().take(if settings.samples > 2 { 1 } else { 2 }) {
            let mut kept = Kept::default();
            let stopped = bake(&file, settings, &mut kept, Some(reports));
            assert!(stopped.is_err_and(|error| error.is_cancelled()));
            let finished = kept.steps.len();
            assert!(finished >= reports && finished <= all.made, "{finished} of {}", all.made);
            kept = Kept { steps: kept.steps, ..Kept::default() };
            let found = bake(&file, settings, &mut kept, None).unwrap();
            assert_eq!((kept.taken, kept.made), (finished, all.made - finished));
            assert!(found.glb == want.glb && found.maps == want.maps, "{settings:?} after {reports}");
            assert!(kept.steps == all.steps);
        }
        // A step that is no result is made again.
        let mut damaged = Kept { steps: vec![vec![1, 2, 3]], ..Kept::default() };
        assert!(bake(&file, settings, &mut damaged, None).unwrap().glb == want.glb);
    }
}
