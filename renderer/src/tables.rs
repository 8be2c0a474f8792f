use crate::event::tell;
use crate::{Event, Listener, RenderError, cache};
use paper::{ProductTable, Resolution, Tables, fit_product};
use rayon::prelude::*;
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

/// The extension of the file of a table.
const ENDING: &str = "table";

/// The paper's tables: read from the `cache`, or else computed on all cores in some seconds and written to it.
///
/// # Errors
/// [`RenderError::Cancelled`].
pub fn paper_tables(cache: Option<&Path>, listener: &mut Listener<'_>) -> Result<Tables, RenderError> {
    let Some(folder) = cache else { return Ok(Tables::with_products(build(listener)?)) };
    let key = key();
    let read = |bytes: Vec<u8>| ProductTable::from_bytes(&bytes).ok().filter(|t| t.resolution() == Resolution::PAPER);
    let products = match cache::find(folder, &key, ENDING, read, listener)? {
        Some((_, products)) => products,
        None => {
            let products = build(listener)?;
            // The disk may be full: the next run then computes the table again.
            let _ = cache::store(folder, &key, ENDING, &products.to_bytes());
            products
        }
    };
    Ok(Tables::with_products(products))
}

fn build(listener: &mut Listener<'_>) -> Result<ProductTable, RenderError> {
    let resolution = Resolution::PAPER;
    let count = resolution.exponents();
    // The rows between two reports: enough that no core waits for long.
    let step = 4 * rayon::current_num_threads();
    let mut rows = Vec::with_capacity(count);
    while rows.len() < count {
        tell(listener, Event::Tables { done: rows.len() as f32 / count as f32 })?;
        let next = rows.len()..(rows.len() + step).min(count);
        rows.par_extend(next.into_par_iter().map(|row| ProductTable::build_row(resolution, row)));
    }
    Ok(ProductTable::from_rows(resolution, rows))
}

/// A hash of some of the table's fits, computed now: another way to fit or to sample has another key.
fn key() -> String {
    let resolution = Resolution::PAPER;
    let (exponents, angles) = (resolution.exponents(), resolution.angles);
    let mut hash = Xxh3::new();
    for i in 0..200 {
        let at = |step: usize, count: usize| i * step % count;
        let (e1, e2) = (resolution.exponent(at(7, exponents)), resolution.exponent(at(11, exponents)));
        let fit = fit_product(e1, e2, resolution.angle(at(13, angles)));
        [fit.scale, fit.exponent].iter().for_each(|x| hash.update(&x.to_bits().to_le_bytes()));
    }
    format!("{:016x}", hash.digest())
}
