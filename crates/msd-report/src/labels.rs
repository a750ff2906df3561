//! Places of names beside their lines, where they hide the least, found by trying.

use crate::pen::Point;

/// A name that wants a place.
#[derive(Clone, Debug)]
pub struct Name {
    /// Its width, pixels.
    pub width: f64,
    /// The points it may stand beside, the best first.
    pub beside: Vec<Point>,
}

/// Marks and lines that names should not hide.
#[derive(Clone, Debug, Default)]
pub struct Obstacles {
    /// Lines.
    pub lines: Vec<[Point; 2]>,
    /// Marks.
    pub marks: Vec<Point>,
}

/// A box by its upper left and its lower right corner.
pub type Box2 = (Point, Point);

/// Height that a name takes, pixels.
pub const HEIGHT: f64 = 14.0;

/// The middle of the left edge of every name inside `page`, none where there is no room.
pub fn place(names: &[&Name], obstacles: &Obstacles, page: Box2) -> Vec<Option<Point>> {
    let mut taken: Vec<Box2> = Vec::new();
    let mut places = Vec::new();
    for name in names {
        let mut best: Option<(f64, Box2)> = None;
        for (rank, &point) in name.beside.iter().enumerate() {
            for (turn, spot) in around(point, name.width).into_iter().enumerate() {
                let free = inside(spot, page) && !taken.iter().any(|&other| touch(spot, other));
                let cost = hidden(spot, obstacles) + 0.6 * rank as f64 + 0.2 * turn as f64;
                if free && best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, spot));
                }
            }
        }
        taken.extend(best.map(|(_, spot)| spot));
        places.push(best.map(|(_, ((x, top), (_, bottom)))| (x, 0.5 * (top + bottom))));
    }
    places
}

/// Points with the last first, then the first: a line ends where it is least among others.
pub fn ends_first(mut points: Vec<Point>) -> Vec<Point> {
    points.reverse();
    if let Some(first) = points.pop() {
        points.insert(points.len().min(1), first);
    }
    points
}

/// Boxes beside a point: right, above, below, left, and the corners.
fn around((x, y): Point, width: f64) -> Vec<Box2> {
    let (near, half) = (10.0, 0.5 * HEIGHT);
    let above = y - near - HEIGHT;
    let corners = [
        (x + near, y - half),
        (x + near, above + 6.0),
        (x + near, y + near - 6.0),
        (x - 0.5 * width, above),
        (x - 0.5 * width, y + near),
        (x - near - width, y - half),
        (x - near - width, above + 6.0),
        (x - near - width, y + near - 6.0),
    ];
    corners.iter().map(|&(x, y)| ((x, y), (x + width, y + HEIGHT))).collect()
}

/// Returns how much a box hides or nearly hides: names beside many lines could be any one’s.
fn hidden(spot: Box2, obstacles: &Obstacles) -> f64 {
    let ((left, top), (right, bottom)) = spot;
    let near = 5.0;
    let wide = ((left - near, top - near), (right + near, bottom + near));
    let covers = |&&(x, y): &&Point| {
        left - near <= x && x <= right + near && top - near <= y && y <= bottom + near
    };
    let marks = obstacles.marks.iter().filter(covers).count();
    let lines = obstacles.lines.iter().filter(|&&line| crosses(line, spot)).count();
    let close = obstacles.lines.iter().filter(|&&line| crosses(line, wide)).count();
    3.0 * marks as f64 + 2.0 * lines as f64 + close as f64
}

/// Returns whether a line passes through a box: whether a part of it is left after cutting at each
/// side.
fn crosses([from, to]: [Point; 2], ((left, top), (right, bottom)): Box2) -> bool {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    let sides = [(from.0, to.0, left, right), (from.1, to.1, top, bottom)];
    for (start, end, low, high) in sides {
        let length = end - start;
        if length == 0.0 {
            if start < low || high < start {
                return false;
            }
            continue;
        }
        let (one, other) = ((low - start) / length, (high - start) / length);
        enter = enter.max(one.min(other));
        leave = leave.min(one.max(other));
    }
    enter <= leave
}

fn inside((corner, opposite): Box2, (from, to): Box2) -> bool {
    from.0 <= corner.0 && from.1 <= corner.1 && opposite.0 <= to.0 && opposite.1 <= to.1
}

/// Returns whether two boxes are nearer than words of two lines should be.
fn touch(a: Box2, b: Box2) -> bool {
    let gap = 6.0;
    a.0.0 < b.1.0 + gap && b.0.0 < a.1.0 + gap && a.0.1 < b.1.1 + gap && b.0.1 < a.1.1 + gap
}

/// Moves heights apart until none is nearer to the next than `gap`, within a range.
pub fn spread(heights: &mut [f64], gap: f64, (top, bottom): (f64, f64)) {
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let mut free = top;
    for &row in &order {
        heights[row] = heights[row].max(free);
        free = heights[row] + gap;
    }
    let mut free = bottom;
    for &row in order.iter().rev() {
        heights[row] = heights[row].min(free);
        free = heights[row] - gap;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_avoids_a_line_and_names_do_not_touch() {
        let wall = Obstacles { lines: vec![[(70.0, 0.0), (70.0, 300.0)]], marks: Vec::new() };
        let name = Name { width: 30.0, beside: vec![(45.0, 100.0)] };
        let page = ((0.0, 0.0), (200.0, 200.0));
        let places = place(&[&name, &name], &wall, page);
        let (first, second) = (places[0].expect("room"), places[1].expect("room"));
        assert!(first.0 + 30.0 <= 70.0 && second.0 + 30.0 <= 70.0, "{places:?}");
        assert!((first.1 - second.1).abs() >= HEIGHT, "{places:?}");
    }

    #[test]
    fn spread_heights_keep_their_order_and_their_gap() {
        let mut heights = [50.0, 51.0, 20.0, 52.0];
        spread(&mut heights, 10.0, (0.0, 60.0));
        assert!(heights[2] < heights[0] && heights[0] < heights[1] && heights[1] < heights[3]);
        assert!(heights[1] - heights[0] >= 10.0 && heights[3] - heights[1] >= 10.0);
        assert!(heights[3] <= 60.0);
    }
}
