//! The files that the page was given: fetched ones, and dropped ones.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Files by path, shared with the reading that goes on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Given(Arc<BTreeMap<PathBuf, Vec<u8>>>);

impl Given {
    pub(crate) fn put(&mut self, path: &str, bytes: Vec<u8>) {
        Arc::make_mut(&mut self.0).insert(PathBuf::from(path), bytes);
    }

    pub(crate) fn all(&self) -> Arc<BTreeMap<PathBuf, Vec<u8>>> {
        Arc::clone(&self.0)
    }
}
