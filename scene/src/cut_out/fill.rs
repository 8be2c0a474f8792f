//! Triangles between outlines.

use super::outline::{Corner, Loop};
use earcut::Earcut;
use glam::DVec2;

/// Corners of one part and its holes: some laces need the square of their number.
const MOST_CORNERS: usize = 20_000;
/// Sides that are looked at to find which part each hole is in.
const MOST_SIDES: usize = 1 << 27;
/// How much of its area a part may lose to outlines that touch each other.
const LOST: f64 = 1e-4;

/// Corners, and triangles of their numbers that turn as the outlines do.
pub(super) type Filled = (Vec<Corner>, Vec<[usize; 3]>);

fn doubled_area(line: &[Corner]) -> f64 {
    let n = line.len();
    (0..n).map(|k| (line[k].place - line[0].place).perp_dot(line[(k + 1) % n].place - line[0].place)).sum()
}

/// Fills what lies on the left of outlines if `sense` is 1, on their right if it is −1. `None` where there are too many corners, or where
/// outlines cross.
pub(super) fn filled(outlines: &[Loop], sense: f64) -> Option<Filled> {
    let (mut parts, mut holes) = (Vec::new(), Vec::new());
    for outline in outlines {
        let area = sense * doubled_area(&outline.full);
        if area > 0.0 { parts.push((area, vec![outline])) } else { holes.push(outline) }
    }
    parts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    if holes.len() * outlines.iter().map(|outline| outline.full.len()).sum::<usize>() > MOST_SIDES {
        return None;
    }
    for hole in holes {
        // In the smallest that is around it. A hole beside all parts has no area.
        let inner = 0.5 * (hole.full[0].place + hole.full[1].place);
        let around = parts.iter_mut().find(|(_, lines)| is_inside(inner, &lines[0].full));
        if let Some((_, lines)) = around {
            lines.push(hole);
        }
    }
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (_, lines) in &parts {
        let of = |line: fn(&Loop) -> &Vec<Corner>| part(lines.iter().map(|outline| line(outline)), sense);
        let (own, filling) = match of(|outline| &outline.simple)? {
            (found, lost) if lost <= LOST => found,
            _ => of(|outline| &outline.full).filter(|(_, lost)| *lost <= LOST)?.0,
        };
        let first = corners.len();
        corners.extend(own);
        triangles.extend(filling.into_iter().map(|triangle| triangle.map(|k| first + k)));
    }
    Some((corners, triangles))
}

/// The corners of a part and of its holes, its triangles, and how much of its area they miss.
fn part<'a>(lines: impl Iterator<Item = &'a Vec<Corner>>, sense: f64) -> Option<(Filled, f64)> {
    let (mut corners, mut holes) = (Vec::new(), Vec::new());
    for (k, line) in lines.enumerate() {
        match (k, line.len() < 3) {
            // Specks.
            (0, true) => return Some((Filled::default(), 0.0)),
            (_, true) => {}
            (_, false) => {
                holes.extend((k > 0).then_some(corners.len()));
                corners.extend_from_slice(line);
            }
        }
    }
    if corners.len() > MOST_CORNERS {
        return None;
    }
    let flat = || corners.iter().map(|corner| corner.place.to_array());
    let mut numbers: Vec<usize> = Vec::new();
    Earcut::new().earcut(flat(), &holes, &mut numbers);
    let lost = earcut::deviation(flat(), &holes, &numbers);
    let place = |k: usize| corners[k].place;
    let turned = |[a, b, c]: [usize; 3]| {
        if sense * (place(b) - place(a)).perp_dot(place(c) - place(a)) < 0.0 { [a, c, b] } else { [a, b, c] }
    };
    let triangles = numbers.as_chunks::<3>().0.iter().map(|triangle| turned(*triangle)).collect();
    Some(((corners, triangles), lost))
}

/// By the sides that a ray to the right crosses.
fn is_inside(p: DVec2, line: &[Corner]) -> bool {
    let n = line.len();
    let crosses = |k: &usize| {
        let (a, b) = (line[*k].place, line[(k + 1) % n].place);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..n).filter(crosses).count() % 2 == 1
}
