use lighting::{Environment, Light};
use lobe_core::Accuracy;
use std::sync::Arc;
use visibility_mask::sky::{SkyResolution, SkyTable};

/// The tables of the scene's environment, one for each resolution in use, kept from picture to picture: they follow the environment
/// alone, whatever moves before it.
#[derive(Debug, Default)]
pub struct KeptSky {
    of: Option<Arc<Environment>>,
    tables: Vec<SkyTable>,
    /// Tables that were made so far.
    made: u64,
}

/// An environment as a CPU sums it at once: its table, and which of the scene's lights it stands for.
#[derive(Clone, Debug)]
pub struct SkyFrame<'a> {
    pub(crate) table: &'a SkyTable,
    pub(crate) replaced: Vec<bool>,
}

impl KeptSky {
    /// The sky of a scene for an accuracy. None without an environment, and where its patches are not all among the lights as they were made:
    /// then they are lights like others.
    pub fn follow(
        &mut self,
        environment: Option<&Arc<Environment>>,
        lights: &[Light],
        accuracy: Accuracy,
    ) -> Option<SkyFrame<'_>> {
        let environment = environment?;
        let replaced = environment.patches_among(lights)?;
        if !replaced.contains(&true) {
            return None;
        }
        if self.of.as_ref().is_none_or(|of| !Arc::ptr_eq(of, environment)) {
            self.of = Some(Arc::clone(environment));
            self.tables.clear();
        }
        let resolution = SkyResolution::of_tolerance(accuracy.tolerance);
        let known = self.tables.iter().position(|table| table.meridians().resolution() == resolution);
        let place = known.unwrap_or_else(|| {
            let sky = environment.sky();
            self.tables.push(SkyTable::new(resolution, sky.size().x, |v| sky.radiance(v)));
            self.made += 1;
            self.tables.len() - 1
        });
        Some(SkyFrame { table: &self.tables[place], replaced })
    }

    /// Tables that were made so far.
    #[must_use]
    pub const fn made(&self) -> u64 {
        self.made
    }
}
