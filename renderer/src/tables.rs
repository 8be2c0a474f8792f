use crate::event::tell;
use crate::{Event, Listener, RenderError};
use lobe_core::paper::{ProductTable, Resolution, Tables};
use rayon::prelude::*;

/// The paper's tables, on all cores: some seconds.
///
/// # Errors
/// [`RenderError::Cancelled`].
pub fn paper_tables(listener: &mut Listener<'_>) -> Result<Tables, RenderError> {
    let resolution = Resolution::PAPER;
    let count = resolution.exponents();
    // So many rows between two reports that no core waits for long.
    let step = 4 * rayon::current_num_threads();
    let mut rows = Vec::with_capacity(count);
    while rows.len() < count {
        tell(listener, Event::Tables { done: rows.len() as f32 / count as f32 })?;
        let next = rows.len()..(rows.len() + step).min(count);
        rows.par_extend(next.into_par_iter().map(|row| ProductTable::build_row(resolution, row)));
    }
    Ok(Tables::with_products(ProductTable::from_rows(resolution, rows)))
}
