//! Reduces the number of instants without changing the picture, for several curves at common
//! instants.

/// Minimum and maximum number of parts that each curve is divided into.
const PARTS: (usize, usize) = (8, 1500);

/// About `most` positions of `count` instants at most, chosen by [`places`]: how many coincide is
/// known only after they are chosen.
pub(super) fn fitting(curves: &[&[f64]], count: usize, most: usize, marks: &[usize]) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    let mut parts = (most / 2).clamp(PARTS.0, PARTS.1);
    loop {
        let chosen = places(curves, count, parts, marks);
        if chosen.len() <= most || parts == PARTS.0 {
            return chosen;
        }
        parts = (parts * most / chosen.len()).clamp(PARTS.0, parts - 1);
    }
}

/// Positions to keep of `count` instants: for each part and each curve the minimum and the maximum,
/// and where NaN begins, so that no spike and no gap is lost; also all `marks`.
fn places(curves: &[&[f64]], count: usize, parts: usize, marks: &[usize]) -> Vec<usize> {
    if count <= 2 * parts {
        return (0..count).collect();
    }
    let mut keep = vec![false; count];
    (keep[0], keep[count - 1]) = (true, true);
    for part in 0..parts {
        let (start, end) = (part * count / parts, (part + 1) * count / parts);
        for curve in curves {
            let (mut low, mut high, mut gap) = (None::<usize>, None::<usize>, None::<usize>);
            for place in start..end {
                let value = curve[place];
                if value.is_nan() {
                    gap = gap.or(Some(place));
                    continue;
                }
                low = low.filter(|low| curve[*low] <= value).or(Some(place));
                high = high.filter(|high| curve[*high] >= value).or(Some(place));
            }
            // One is enough for a part that is all NaN.
            [low, high, gap].into_iter().flatten().for_each(|place| keep[place] = true);
        }
    }
    marks.iter().for_each(|mark| keep[*mark] = true);
    (0..count).filter(|place| keep[*place]).collect()
}

/// This many positions, evenly spaced, including the first and the last.
pub(super) fn even(count: usize, most: usize) -> Vec<usize> {
    if count <= most || most < 2 {
        return (0..count.min(most.max(1))).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_and_gaps_survive() {
        let (mut a, mut b) = (vec![0.0; 100_000], vec![1.0; 100_000]);
        (a[54_321], b[76_543], b[20_000]) = (7.0, -3.0, f64::NAN);
        let kept = places(&[&a, &b], a.len(), 100, &[33]);
        assert!(kept.len() < 600, "{}", kept.len());
        for place in [0, 33, 20_000, 54_321, 76_543, 99_999] {
            assert!(kept.contains(&place), "{place}");
        }
        assert_eq!(places(&[&a[..5]], 5, 100, &[]), [0, 1, 2, 3, 4]);
        let kept = fitting(&[&a, &b], a.len(), 300, &[33]);
        assert!((150..=300).contains(&kept.len()) && kept.contains(&76_543), "{}", kept.len());
    }

    #[test]
    fn even_places_have_both_ends() {
        assert_eq!(even(101, 3), [0, 50, 100]);
        assert_eq!(even(2, 3), [0, 1]);
        assert_eq!(even(0, 3), [0_usize; 0]);
    }
}
