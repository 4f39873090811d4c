//! The broad phase against all pairs.

use nonsmooth::geometry::{Bounds, BroadPhase, Shape};
use proptest::prelude::*;

use crate::common::{pose, shape, v};

fn all_pairs(boxes: &[Bounds<f64>]) -> Vec<(usize, usize)> {
    let pairs = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| boxes[i].meets(&boxes[j])).collect()
}

proptest! {
    #[test]
    fn finds_the_pairs_that_overlap(
        centres in prop::collection::vec(prop::array::uniform3(-3.0..3.0f64), 0..120),
        halves in prop::collection::vec(prop::array::uniform3(0.0..0.7f64), 120),
        shift in prop::collection::vec(prop::array::uniform3(-0.2..0.2f64), 120),
        open in prop::collection::vec(0..20u8, 120),
    ) {
        let mut broad = BroadPhase::new();
        for round in 0..3 {
            let boxes: Vec<_> = centres.iter().enumerate().map(|(i, &[x, y, z])| {
                if open[i] == 0 {
                    return Bounds::everywhere();
                }
                let [a, b, c] = shift[i].map(|s| s * f64::from(round));
                let [k, l, m] = halves[i];
                Bounds::around(v(x + a, y + b, z + c), v(k, l, m))
            }).collect();
            let mut out = Vec::new();
            broad.pairs(&boxes, |_, _| true, &mut out);
            prop_assert_eq!(&out, &all_pairs(&boxes));
            out.clear();
            broad.pairs(&boxes, |i, j| (i + j) % 2 == 0, &mut out);
            prop_assert!(out.iter().all(|(i, j)| (i + j) % 2 == 0));
        }
    }

    #[test]
    fn bounds_hold_the_shape(shape in shape(), pose in pose(2.0)) {
        let bounds = shape.bounds(&pose, 0.0);
        if let Some(hull) = shape.as_polyhedron() {
            for x in hull.vertices() {
                let x = pose.place(x);
                prop_assert!((0..3).all(|k| x[k] >= bounds.low[k] - 1e-14 && x[k] <= bounds.high[k] + 1e-14));
            }
        }
        let grown = shape.bounds(&pose, 0.5);
        prop_assert!((grown.high - bounds.high - v(0.5, 0.5, 0.5)).norm() <= 1e-14);
    }
}

#[test]
fn boxes_without_bounds_meet_everybody() {
    let boxes =
        [Bounds::everywhere(), Bounds::around(v(0.0, 0.0, 0.0), v(1.0, 1.0, 1.0)), Bounds::everywhere()];
    let mut out = Vec::new();
    BroadPhase::<f64>::new().pairs(&boxes, |_, _| true, &mut out);
    assert_eq!(out, [(0, 1), (0, 2), (1, 2)]);
    assert!(
        Shape::<f64>::half_space().bounds(&nonsmooth::geometry::Pose::identity(), 0.0).low.x.is_infinite()
    );
}
