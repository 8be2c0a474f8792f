//! Parts of a whole, as horizontal bars.

use super::canvas::{Draw, failed};
use crate::drawing::COLORS;
use plotters::coord::Shift;
use plotters::prelude::*;

pub(super) struct Bars {
    pub(super) stages: [&'static str; 5],
    /// Per cent of each stage.
    pub(super) bars: Vec<(String, [f64; 5])>,
}

/// Left of the bars, for their names.
const NAMES: i32 = 150;
const WIDTH: i32 = 500;
const STEP: i32 = 24;
/// Above the bars, for the key.
const HEAD: i32 = 40;
/// Bars of one figure.
const GROUP: usize = 3;

impl Bars {
    fn top(&self, i: usize) -> i32 {
        HEAD + STEP * i as i32 + 10 * (i / GROUP) as i32
    }
}

impl Draw for Bars {
    fn size(&self) -> (u32, u32) {
        ((NAMES + WIDTH + 40) as u32, (self.top(self.bars.len()) + 26) as u32)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        let small = ("sans-serif", 14).into_font();
        let text =
            |words: &str, at: (i32, i32)| root.draw(&Text::new(words.to_owned(), at, small.clone())).map_err(failed);
        let block =
            |corners, k: usize| root.draw(&Rectangle::new(corners, COLORS[k].mix(0.8).filled())).map_err(failed);
        let mut left = 10;
        for (k, stage) in self.stages.iter().enumerate() {
            block([(left, 10), (left + 14, 24)], k)?;
            text(stage, (left + 20, 9))?;
            left += 40 + 8 * stage.len() as i32;
        }
        for (i, (name, shares)) in self.bars.iter().enumerate() {
            let top = self.top(i);
            text(name, (10, top + 2))?;
            let mut sum = 0.0;
            for (k, share) in shares.iter().enumerate() {
                let place = |share: f64| NAMES + (share / 100.0 * f64::from(WIDTH)).round() as i32;
                block([(place(sum), top), (place(sum + share), top + 18)], k)?;
                // Narrower bars have no room for their number.
                if *share >= 6.0 {
                    text(&format!("{share:.0}"), (place(sum + 0.5 * share) - 8, top + 2))?;
                }
                sum += share;
            }
        }
        let bottom = self.top(self.bars.len());
        for percent in [0, 25, 50, 75, 100] {
            text(&format!("{percent} %"), (NAMES + percent * WIDTH / 100 - 14, bottom + 4))?;
        }
        Ok(())
    }
}
