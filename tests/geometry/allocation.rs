//! Warm calls allocate nothing.

use allocation_counter::measure;
use nonsmooth::geometry::{BroadPhase, NarrowPhase, Shape};

use crate::common::{cube, prism, turned};

#[test]
fn warm_calls_allocate_nothing() {
    let shapes = [
        cube(),
        prism(12),
        Shape::ball(0.5).expect("a ball"),
        Shape::capsule(0.2, 0.5).expect("a capsule"),
        Shape::cylinder(0.5, 0.5, 16).expect("a cylinder"),
        Shape::cone(0.5, 1.0, 16).expect("a cone"),
        Shape::half_space(),
    ];
    let pose = |k: usize| {
        let x = |i: usize| ((k * 7919 + i * 104_729) % 97) as f64 / 97.0 - 0.5;
        turned([x(1), x(2), x(3)], [3.0 * x(4), 3.0 * x(5), 3.0 * x(6)])
    };
    let (mut narrow, mut broad) = (NarrowPhase::new(), BroadPhase::new());
    let (mut contacts, mut pairs, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
    let mut sweep = || {
        contacts.clear();
        for (i, a) in shapes.iter().enumerate() {
            for (j, b) in shapes.iter().enumerate() {
                for k in 0..20 {
                    narrow.contacts((a, &pose(i + k)), (b, &pose(j + 3 * k + 1)), 0.1, &mut contacts);
                }
            }
        }
        boxes.clear();
        boxes.extend((0..200).map(|k| shapes[k % 6].bounds(&pose(k), 0.0)));
        pairs.clear();
        broad.pairs(&boxes, |_, _| true, &mut pairs);
        contacts.len() + pairs.len()
    };
    let first = sweep();
    let mut again = 0;
    let allocated = measure(|| again = sweep());
    assert_eq!(allocated.count_total, 0);
    assert!(first == again && first > 1000, "{first} {again}");
}
