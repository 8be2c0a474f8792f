use crate::sets::{Model, fitted, spot};
use cosine_lobes::scene::Mesh;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The cow with this number of spheres: each set is fitted once and kept beside the program.
pub(crate) struct Models {
    mesh: Mesh,
    folder: Option<PathBuf>,
    models: BTreeMap<usize, Model>,
}

impl Models {
    pub(crate) fn new() -> Result<Self, String> {
        let folder = std::env::current_exe().ok().and_then(|p| Some(p.parent()?.join("results_table.sets")));
        Ok(Self { mesh: spot()?, folder, models: BTreeMap::new() })
    }

    pub(crate) fn of(&mut self, count: usize) -> Result<&Model, String> {
        if !self.models.contains_key(&count) {
            let mut is_told = false;
            let mut report = |_| {
                if !core::mem::replace(&mut is_told, true) {
                    eprintln!("fitting {count} spheres to the cow");
                }
            };
            let set = fitted(&self.mesh, count, self.folder.as_deref(), &mut report)?;
            self.models.insert(count, Model { mesh: self.mesh.clone(), set, count });
        }
        self.models.get(&count).ok_or_else(|| format!("no set of {count} spheres"))
    }
}
