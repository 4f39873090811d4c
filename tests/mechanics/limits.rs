//! The event-driven limit h → 0 of the impacting stick, from 30-digit arithmetic.

/// Impact times, tangential works, and the state at [`END`] under one law; every test takes what it needs.
#[allow(dead_code)]
pub(crate) struct Limit {
    pub(crate) law: &'static str,
    pub(crate) times: [f64; 2],
    pub(crate) works: [f64; 2],
    pub(crate) q: [f64; 3],
    pub(crate) v: [f64; 3],
}

/// Where the motion ends (s).
pub(crate) const END: f64 = 0.2;

pub(crate) const LIMITS: [Limit; 2] = [
    Limit {
        law: "newton",
        times: [0.0602740890931335, 0.163275784399643],
        works: [7.07557531928671e-4, -5.96201880021998e-4],
        q: [0.252917082969242, 0.247184152996499, 1.08198050693022],
        v: [-0.506857186185685, -1.21428138143152, 3.20697486630626],
    },
    Limit {
        law: "fremond",
        times: [0.0602740890931335, 0.163426487041862],
        works: [-6.77436191397145e-4, -6.24721696746364e-4],
        q: [0.253954653570177, 0.246505034604781, 1.08347693476027],
        v: [-0.499431898486806, -1.21909485547438, 3.21913960453411],
    },
];
