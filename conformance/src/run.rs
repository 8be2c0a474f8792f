use crate::{Broken, Exceeded, Report};

/// A suite under way: its measurements so far, and what is broken. For suites of one's own.
#[derive(Debug, Default)]
pub struct Run<M = ()> {
    /// The measurements.
    pub measured: M,
    broken: Vec<Broken>,
}

impl<M> Run<M> {
    /// Notes a fault: of each property the worst case stays.
    pub fn note(&mut self, property: &'static str, exceeded: Option<Exceeded>, case: impl FnOnce() -> String) {
        let worse = |old: &Broken| match (old.exceeded, exceeded) {
            (Some(old), Some(new)) => new.value > old.value || new.value.is_nan(),
            _ => false,
        };
        match self.broken.iter_mut().find(|b| b.property == property) {
            None => self.broken.push(Broken { property, exceeded, times: 1, case: case() }),
            Some(old) => {
                if worse(old) {
                    (old.exceeded, old.case) = (exceeded, case());
                }
                old.times += 1;
            }
        }
    }

    /// Notes a property that does not hold.
    pub fn ensure(&mut self, holds: bool, property: &'static str, case: impl FnOnce() -> String) {
        if !holds {
            self.note(property, None, case);
        }
    }

    /// The same for a value and the field of [`Limits`](crate::Limits) that it must not exceed.
    pub fn within(
        &mut self,
        value: f64,
        (field, limit): (&'static str, f64),
        property: &'static str,
        case: impl FnOnce() -> String,
    ) {
        // Nor is it to be NaN.
        if value.is_nan() || value > limit {
            self.note(property, Some(Exceeded { field, value, limit }), case);
        }
    }

    /// The measurements, or every property that does not hold.
    ///
    /// # Errors
    /// [`Report`].
    pub fn end(self) -> Result<M, Report> {
        if self.broken.is_empty() { Ok(self.measured) } else { Err(Report { broken: self.broken }) }
    }
}
