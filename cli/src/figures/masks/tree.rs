//! Fig. 9: the quad-tree of the visibility mask.

use super::super::canvas::{Draw, failed};
use super::super::gallery::Page;
use super::super::studio::Studio;
use super::setting::{DIST, GREY, Panel, Setting, corners, three, words};
use crate::failure::Failure;
use cosine_lobes::paper::ShadowNode;
use glam::Vec2;
use plotters::coord::Shift;
use plotters::prelude::*;

/// The depth of Fig. 9.
const DEPTH: u32 = 3;

/// The state of a node.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Outside,
    Lit,
    Partly,
    Shadow,
}

impl State {
    fn of(setting: &Setting, node: ShadowNode) -> Self {
        match covered(setting, node) {
            (0, _) => Self::Outside,
            (_, 0) => Self::Lit,
            (all, covered) if covered == all => Self::Shadow,
            _ => Self::Partly,
        }
    }
}

/// Of 24 × 24 directions through a node those that meet the light, and those of them that are blocked.
fn covered(setting: &Setting, node: ShadowNode) -> (usize, usize) {
    const STEPS: usize = 24;
    let [low, high] = corners(node);
    let at = |i: usize| Vec2::new((i % STEPS) as f32 + 0.5, (i / STEPS) as f32 + 0.5) / STEPS as f32;
    let inside = (0..STEPS * STEPS).map(|i| low + (high - low) * at(i)).filter(|p| p.length() < 0.5);
    inside.fold((0, 0), |(all, covered), p| (all + 1, covered + usize::from(setting.is_blocked(p))))
}

struct Tree<'a> {
    setting: &'a Setting,
    /// The shadow nodes with quad-trees of depth 1, 2, …
    steps: &'a [Vec<ShadowNode>],
}

impl Draw for Tree<'_> {
    fn size(&self) -> (u32, u32) {
        (820, 300)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        let panel = |k: i32| Panel { left: 10 + 203 * k, top: 32, side: 190 };
        let outlines = |panel: &Panel| {
            for sphere in &self.setting.spheres {
                let path = panel.path(&self.setting.outline(sphere));
                root.draw(&PathElement::new(path, GREY.stroke_width(2))).map_err(failed)?;
            }
            root.draw(&panel.disc()).map_err(failed)?;
            root.draw(&panel.frame()).map_err(failed)
        };
        words(root, "three spheres", (panel(0).left, 8))?;
        outlines(&panel(0))?;
        let [red, yellow, green] = [RGBColor(240, 120, 110), RGBColor(250, 225, 120), RGBColor(110, 190, 120)];
        for (k, nodes) in self.steps.iter().enumerate() {
            let (level, panel) = (k as u32 + 1, panel(k as i32 + 1));
            words(root, &format!("depth {level}"), (panel.left, 8))?;
            let side = 1_usize << level;
            let black = BLACK.stroke_width(1);
            for i in 0..side * side {
                let node = ShadowNode { level, x: i % side, y: i / side };
                // Inside of a node that was frozen before.
                let frozen = nodes.iter().any(|n| {
                    n.level <= level && (node.x >> (level - n.level), node.y >> (level - n.level)) == (n.x, n.y)
                });
                let last = level == DEPTH;
                let color = match State::of(self.setting, node) {
                    _ if frozen => continue,
                    State::Partly if last => yellow,
                    State::Partly => red,
                    _ => WHITE,
                };
                root.draw(&panel.rectangle(corners(node), color.filled())).map_err(failed)?;
                root.draw(&panel.rectangle(corners(node), GREY.stroke_width(1))).map_err(failed)?;
            }
            for node in nodes {
                root.draw(&panel.rectangle(corners(*node), green.filled())).map_err(failed)?;
                root.draw(&panel.rectangle(corners(*node), black)).map_err(failed)?;
            }
            outlines(&panel)?;
        }
        let keys =
            [(red, "partly covered: subdivided"), (green, "covered: frozen"), (yellow, "partly covered leaf: ignored")];
        for (k, (color, text)) in keys.into_iter().enumerate() {
            let left = 10 + 240 * k as i32;
            root.draw(&Rectangle::new([(left, 244), (left + 18, 262)], color.filled())).map_err(failed)?;
            words(root, text, (left + 26, 245))?;
        }
        words(root, "Circle: the light. Leaves outside of it count for nothing.", (10, 274))
    }
}

pub(in crate::figures) fn tree(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let setting = Setting::new(DIST, three());
    let steps: Vec<Vec<ShadowNode>> =
        (1..=DEPTH).map(|depth| Ok(setting.seen(depth, &tables)?.nodes)).collect::<Result<_, Failure>>()?;
    let counts: Vec<String> = steps.iter().map(|nodes| nodes.len().to_string()).collect();
    let [four, five] = [4, 5].map(|depth| setting.seen(depth, &tables).map(|seen| seen.nodes.len()));
    Ok(Page {
        title: "the quad-tree of the visibility mask",
        images: Tree { setting: &setting, steps: &steps }.images(name)?,
        shows: "Three spheres on the unit square, and the quad-tree that is built from them level by level. Nodes that are wholly covered are \
                frozen; partly covered ones are subdivided, up to the greatest depth, where they are ignored."
            .into(),
        paper: "Fig. 9 has three spheres and a depth of 2; §5.3 uses 4 or 5.".into(),
        here: format!(
            "Shadow nodes at depths 1 to 3: {}. At depth 4 there are {}, at 5 {}. The picture goes one level \
             farther than the paper's.",
            counts.join(", "),
            four?,
            five?
        ),
        differs: "The places of the paper's spheres are not given; its yellow leaves are those whose turn has not come, ours those that are \
                  ignored."
            .into(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::setting::tests::coarse;
    use super::*;

    #[test]
    fn frozen_nodes_are_covered_and_partly_covered_leaves_are_not() {
        let (setting, tables) = (Setting::new(DIST, three()), coarse());
        for depth in 2..=5 {
            let nodes = setting.seen(depth, &tables).unwrap().nodes;
            // The lines of a mask miss slivers between them, most of them in leaves at the light's rim.
            let area = |node: &ShadowNode| 0.25_f64.powi(node.level as i32);
            let open = |node: &ShadowNode| {
                let (all, covered) = covered(&setting, *node);
                area(node) * (all - covered) as f64 / all.max(1) as f64
            };
            let [open, whole] = [nodes.iter().map(open).sum::<f64>(), nodes.iter().map(area).sum()];
            assert!(open < 0.02 * whole, "{depth}: {open} of {whole}");
            // Leaves that are covered are in one of them; by samples an edge may be missed, so all but a few.
            let side = 1_usize << depth;
            let leaves = (0..side * side).map(|i| ShadowNode { level: depth, x: i % side, y: i / side });
            let covered: Vec<_> = leaves.filter(|leaf| State::of(&setting, *leaf) == State::Shadow).collect();
            let inside = |leaf: &&ShadowNode| {
                nodes.iter().any(|n| (leaf.x >> (depth - n.level), leaf.y >> (depth - n.level)) == (n.x, n.y))
            };
            let found = covered.iter().filter(inside).count();
            assert!(covered.len() - found <= covered.len() / 20, "{depth}: {found} of {}", covered.len());
        }
    }
}
