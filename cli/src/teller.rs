//! The events of a renderer, as bars and lines for the user.

use crate::console::{Fit, counted, note, progress};
use cosine_lobes::renderer::{Event, MapReduction};
use cosine_lobes::visibility_shadowmap::MapFineness;
use indicatif::ProgressBar;
use std::ops::ControlFlow;

/// Tells the user.
pub(crate) struct Teller {
    quiet: bool,
    /// The number of pictures to come, and of those that are done.
    pictures: u64,
    done: u64,
    /// The requested time budget, in milliseconds.
    budget: Option<f32>,
    fit: Option<(String, Fit)>,
    tables: Option<ProgressBar>,
    shading: Option<ProgressBar>,
    /// The number of maps that were not fine enough.
    coarse: usize,
}

/// Lines about the maps of lights, at most: as many lights as a scene has are alike.
const MAPS: usize = 4;

impl Teller {
    pub(crate) fn new(quiet: bool) -> Self {
        Self { quiet, pictures: 1, done: 0, budget: None, fit: None, tables: None, shading: None, coarse: 0 }
    }

    /// For a number of pictures, and a time budget.
    pub(crate) fn of_pictures(quiet: bool, pictures: usize, budget: Option<f32>) -> Self {
        Self { pictures: pictures as u64, budget, ..Self::new(quiet) }
    }

    /// Another picture follows.
    pub(crate) fn next_picture(&mut self) {
        self.done += 1;
    }

    /// Takes the bars away.
    pub(crate) fn end(&mut self) {
        self.tables.take().iter().chain(&self.shading.take()).for_each(ProgressBar::finish_and_clear);
    }

    /// A [`Listener`](cosine_lobes::renderer::Listener).
    pub(crate) fn hear(&mut self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Fitting { object, spheres, done } => {
                let what = format!("object \"{object}\": {}", counted(spheres, "sphere"));
                if self.fit.as_ref().is_none_or(|(of, _)| *of != what) {
                    self.fit = Some((what.clone(), Fit::new(&what, self.quiet)));
                }
                if let Some((_, fit)) = &mut self.fit {
                    fit.report(done);
                }
            }
            Event::Fitted { .. } => {
                if let Some((_, fit)) = self.fit.take() {
                    fit.end();
                }
            }
            Event::Tables { done } => {
                let bar = self.tables.get_or_insert_with(|| progress("product table", 1000, self.quiet));
                bar.set_position((1000.0 * done) as u64);
            }
            Event::Pixels { done, of } => {
                self.tables.take().iter().for_each(ProgressBar::finish_and_clear);
                let length = self.pictures * of;
                let bar = self.shading.get_or_insert_with(|| progress("shading", length, self.quiet));
                bar.set_position(self.done * of + done);
            }
            other if !self.quiet => self.tell(other),
            _ => {}
        }
        ControlFlow::Continue(())
    }

    /// Prints a line about an event, if it is worth one.
    fn tell(&mut self, event: Event<'_>) {
        match event {
            Event::Damaged { path } => {
                note(format_args!("lobes: warning: {}: damaged; made anew", path.display()));
            }
            Event::PoorFit { object, error } => {
                let percent = 100.0 * error;
                note(format_args!(
                    "lobes: warning: object \"{object}\": its spheres miss {percent:.0} % of its silhouette: silhouettes are \
                     exact, or more spheres (its keys `visibility` and `proxy`)"
                ));
            }
            Event::MapsReduced(MapReduction { wanted, needed, room, drawn }) => {
                let (needed, room) = (needed.div_ceil(1_000_000), room / 1_000_000);
                note(format_args!(
                    "lobes: note: shadow maps of {wanted}² texels take {needed} MB, there is room for {room} MB: drawn with \
                     {drawn}², so penumbrae are less exact"
                ));
            }
            Event::Map { light, advice } => {
                let instead = match advice.fineness {
                    MapFineness::Fine => return,
                    MapFineness::Coarse => "",
                    MapFineness::TooCoarse => "; `--visibility silhouettes` needs no map",
                };
                self.coarse += 1;
                match self.coarse {
                    1..=MAPS => note(format_args!("lobes: note: light {light}: {advice}{instead}")),
                    more if more == MAPS + 1 => note(format_args!("lobes: note: light {light} and others: as these")),
                    _ => {}
                }
            }
            Event::Chosen { accuracy, milliseconds: total, is_within } => {
                let (percent, depth) = (100.0 * accuracy.tolerance, accuracy.depth);
                let verdict = if is_within { "" } else { ", no setting is faster" };
                let milliseconds = self.budget.unwrap_or_default();
                note(format_args!(
                    "lobes: --time-budget {milliseconds}: tolerance {percent} %, depth {depth}, about {total:.1} ms a frame{verdict}"
                ));
            }
            _ => {}
        }
    }
}
