//! What of a curve or an area lies inside the frame.

use super::svg::Place;

/// Left, top, right, bottom.
pub(super) type Sides = [f64; 4];

/// The pieces of a broken line inside the frame; `None` breaks the line.
pub(super) fn line(points: impl Iterator<Item = Option<Place>>, frame: Sides) -> Vec<Vec<Place>> {
    let mut pieces: Vec<Vec<Place>> = Vec::new();
    let mut before: Option<Place> = None;
    for point in points {
        if let (Some(a), Some(b)) = (before, point)
            && let Some((a, b)) = segment(a, b, frame)
        {
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&a) => piece.push(b),
                _ => pieces.push(vec![a, b]),
            }
        }
        before = point;
    }
    pieces
}

/// The part of a segment inside the frame (Liang and Barsky).
pub(super) fn segment(
    a: Place,
    b: Place,
    [left, top, right, bottom]: Sides,
) -> Option<(Place, Place)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (k, low, high) in [(0, left, right), (1, top, bottom)] {
        let step = b[k] - a[k];
        if step == 0.0 {
            if a[k] < low || a[k] > high {
                return None;
            }
            continue;
        }
        let (enters, leaves) = ((low - a[k]) / step, (high - a[k]) / step);
        from = from.max(enters.min(leaves));
        to = to.min(enters.max(leaves));
    }
    let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    // An end inside stays the very number it was, so that pieces join.
    (from <= to).then(|| {
        (
            if from == 0.0 { a } else { at(from) },
            if to == 1.0 { b } else { at(to) },
        )
    })
}

/// The part of a polygon inside the frame (Sutherland and Hodgman).
pub(super) fn polygon(points: &[Place], [left, top, right, bottom]: Sides) -> Vec<Place> {
    let mut shape = points.to_vec();
    for (k, edge, sign) in [
        (0, left, 1.0),
        (0, right, -1.0),
        (1, top, 1.0),
        (1, bottom, -1.0),
    ] {
        let inside = |p: &Place| sign * (p[k] - edge) >= 0.0;
        let mut cut = Vec::new();
        for (i, b) in shape.iter().enumerate() {
            let a = &shape[(i + shape.len() - 1) % shape.len()];
            if inside(a) != inside(b) {
                let t = (edge - a[k]) / (b[k] - a[k]);
                cut.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
            if inside(b) {
                cut.push(*b);
            }
        }
        shape = cut;
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Sides = [0.0, 0.0, 10.0, 10.0];

    #[test]
    fn a_line_is_cut_at_the_frame_and_broken_where_it_has_no_place() {
        let points = [
            Some([-5.0, 5.0]),
            Some([5.0, 5.0]),
            Some([5.0, 20.0]),
            None,
            Some([1.0, 1.0]),
            Some([2.0, 1.0]),
        ];
        assert_eq!(
            line(points.into_iter(), FRAME),
            [
                vec![[0.0, 5.0], [5.0, 5.0], [5.0, 10.0]],
                vec![[1.0, 1.0], [2.0, 1.0]]
            ]
        );
        assert!(line([Some([-1.0, 5.0]), Some([5.0, 50.0])].into_iter(), FRAME).is_empty());
    }

    #[test]
    fn a_line_across_the_whole_frame_is_seen_though_no_point_is_inside() {
        assert_eq!(
            line(
                [Some([-10.0, -10.0]), Some([20.0, 20.0])].into_iter(),
                FRAME
            ),
            [vec![[0.0, 0.0], [10.0, 10.0]]]
        );
    }

    #[test]
    fn an_area_keeps_what_is_inside() {
        let cut = polygon(&[[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]], FRAME);
        let next = cut.iter().cycle().skip(1);
        let area: f64 = cut
            .iter()
            .zip(next)
            .map(|(a, b)| 0.5 * (a[0] * b[1] - b[0] * a[1]))
            .sum();
        assert!((area.abs() - 25.0).abs() < 1e-12, "{cut:?}");
        assert!(polygon(&[[-5.0, -5.0], [-1.0, -5.0], [-1.0, -1.0]], FRAME).is_empty());
    }
}
