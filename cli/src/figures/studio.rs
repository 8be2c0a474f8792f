//! Data that figures share: the paper's tables and the model with its spheres, made when they are first needed.

use super::sets::{Model, fitted, spot};
use crate::console::Fit;
use crate::failure::Failure;
use crate::input::cache_folder;
use crate::teller::Teller;
use cosine_lobes::paper::Tables;
use cosine_lobes::renderer::paper_tables;
use cosine_lobes::scene::Mesh;
use cosine_lobes::sphere_sets::SphereSet;
use std::collections::BTreeMap;
use std::rc::Rc;

pub(super) struct Studio {
    quiet: bool,
    tables: Option<Rc<Tables>>,
    mesh: Option<Mesh>,
    sets: BTreeMap<usize, SphereSet>,
}

impl Studio {
    pub(super) fn new(quiet: bool) -> Self {
        Self { quiet, tables: None, mesh: None, sets: BTreeMap::new() }
    }

    /// The paper's tables.
    pub(super) fn tables(&mut self) -> Result<Rc<Tables>, Failure> {
        if let Some(tables) = &self.tables {
            return Ok(tables.clone());
        }
        let mut teller = Teller::new(self.quiet);
        let tables = Rc::new(paper_tables(cache_folder().as_deref(), &mut |event| teller.hear(event))?);
        teller.end();
        self.tables = Some(tables.clone());
        Ok(tables)
    }

    /// The model as this number of spheres.
    pub(super) fn model(&mut self, count: usize) -> Result<Model, Failure> {
        let mesh = match &self.mesh {
            Some(mesh) => mesh,
            None => self.mesh.insert(spot().map_err(Failure::new)?),
        };
        // One sphere less is no other set.
        let fit = if count == 484 { 485 } else { count };
        if !self.sets.contains_key(&fit) {
            let mut bar = None;
            let mut report = |done| {
                bar.get_or_insert_with(|| Fit::new(&format!("cow: {fit} spheres"), self.quiet)).report(done);
            };
            let set = fitted(mesh, fit, cache_folder().as_deref(), &mut report).map_err(Failure::new)?;
            if let Some(bar) = bar {
                bar.end();
            }
            self.sets.insert(fit, set);
        }
        match self.sets.get(&fit) {
            Some(set) => Ok(Model { mesh: mesh.clone(), set: set.clone(), count }),
            None => Err(Failure::new(format_args!("no set of {count} spheres"))),
        }
    }
}
