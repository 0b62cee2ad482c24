//! Reduces the number of points without changing the picture.
//!
//! A curve over x keeps the first, lowest, highest and last point of each pixel column, so that no
//! spike is lost; a path keeps points that are at least half a pixel apart. Of the remaining
//! points, those on the straight line between others are dropped (Ramer 1972, Douglas and Peucker
//! 1973).

/// Points closer than this to the straight line between others are dropped, px.
const STRAIGHT: f64 = 0.15;

/// The points to draw, given the size of one pixel in data units (x, y). The points are finite.
pub(super) fn decimate(points: &[(f64, f64)], pixel: (f64, f64)) -> Vec<(f64, f64)> {
    let thinned = if points.windows(2).all(|w| w[0].0 <= w[1].0) {
        over_x(points, pixel.0)
    } else {
        path(points, pixel)
    };
    straighten(&thinned, pixel)
}

/// Drops points on straight lines. Uses a list of open spans instead of recursion.
fn straighten(points: &[(f64, f64)], pixel: (f64, f64)) -> Vec<(f64, f64)> {
    let Some(last) = points.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut keep = vec![false; points.len()];
    (keep[0], keep[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((start, end)) = spans.pop() {
        let distance = |i: usize| distance(points[i], points[start], points[end], pixel);
        let farthest = (start + 1..end).max_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        if let Some(i) = farthest.filter(|i| distance(*i) > STRAIGHT) {
            keep[i] = true;
            spans.extend([(start, i), (i, end)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// Distance of a point from the segment between two others, px.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64), pixel: (f64, f64)) -> f64 {
    let from_a = |q: (f64, f64)| ((q.0 - a.0) / pixel.0, (q.1 - a.1) / pixel.1);
    let (p, b) = (from_a(p), from_a(b));
    let length_squared = b.0 * b.0 + b.1 * b.1;
    let along = if length_squared > 0.0 { (p.0 * b.0 + p.1 * b.1) / length_squared } else { 0.0 };
    let foot = along.clamp(0.0, 1.0);
    (p.0 - foot * b.0).hypot(p.1 - foot * b.1)
}

fn over_x(points: &[(f64, f64)], column: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let mut start = 0;
    while start < points.len() {
        let place = (points[start].0 / column).floor();
        let length = points[start..].iter().take_while(|p| (p.0 / column).floor() == place).count();
        keep_outline(&points[start..start + length], &mut kept);
        start += length;
    }
    kept
}

/// First, lowest, highest and last of the points of one column, in order.
fn keep_outline(column: &[(f64, f64)], kept: &mut Vec<(f64, f64)>) {
    let (mut low, mut high) = (0, 0);
    for (i, point) in column.iter().enumerate() {
        if point.1 < column[low].1 {
            low = i;
        }
        if point.1 > column[high].1 {
            high = i;
        }
    }
    let mut chosen = [0, low.min(high), low.max(high), column.len() - 1].to_vec();
    chosen.dedup();
    kept.extend(chosen.into_iter().map(|i| column[i]));
}

fn path(points: &[(f64, f64)], pixel: (f64, f64)) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (i, point) in points.iter().enumerate() {
        let far = kept.last().is_none_or(|last| {
            let (dx, dy) = ((point.0 - last.0) / pixel.0, (point.1 - last.1) / pixel.1);
            dx * dx + dy * dy >= 0.25
        });
        if far || i + 1 == points.len() {
            kept.push(*point);
        }
    }
    kept
}

/// The contiguous runs of points without NaN or infinity.
pub(super) fn finite_runs<T: Copy>(points: &[T], finite: impl Fn(&T) -> bool) -> Vec<Vec<T>> {
    points.split(|p| !finite(p)).filter(|run| !run.is_empty()).map(<[T]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_one_sample_wide_survives() {
        let mut points: Vec<_> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[76_543].1 = -3.0;
        let kept = decimate(&points, (100.0, 0.01));
        assert!(kept.len() <= 4 * 1000);
        assert!(kept.contains(&(54_321.0, 7.0)) && kept.contains(&(76_543.0, -3.0)));
        assert_eq!(kept.first(), points.first());
        assert_eq!(kept.last(), points.last());
    }

    #[test]
    fn a_path_that_turns_back_keeps_its_shape() {
        let angle = |i: i32| f64::from(i) * 0.001;
        let circle: Vec<_> = (0..6284).map(|i| (angle(i).cos(), angle(i).sin())).collect();
        let kept = decimate(&circle, (0.01, 0.01));
        assert!(kept.len() < 100, "{}", kept.len());
        for pair in kept.windows(2) {
            let middle = ((pair[0].0 + pair[1].0) / 2.0, (pair[0].1 + pair[1].1) / 2.0);
            assert!((1.0 - middle.0.hypot(middle.1)) / 0.01 < 0.2, "{middle:?}");
        }
    }

    #[test]
    fn a_straight_line_needs_two_points_and_a_corner_one_more() {
        let line: Vec<_> = (0..500).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(decimate(&line, (1.0, 1.0)), [line[0], line[499]]);
        let corner: Vec<_> = (0..500).map(|i| (f64::from(i), f64::from(i.min(200)))).collect();
        assert_eq!(decimate(&corner, (1.0, 1.0)), [corner[0], corner[200], corner[499]]);
        assert_eq!(decimate(&[], (1.0, 1.0)), []);
    }

    #[test]
    fn points_are_split_at_values_that_are_not_finite() {
        let runs = finite_runs(&[1.0, f64::NAN, f64::NAN, 2.0, 3.0], |v: &f64| v.is_finite());
        assert_eq!(runs, [vec![1.0], vec![2.0, 3.0]]);
    }
}
