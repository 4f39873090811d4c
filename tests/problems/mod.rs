//! Problems of our own making, the same on every run: rigid boxes and brick walls under gravity.
//!
//! Everything follows from masses, contact points and velocities by arithmetic and square roots, so a machine that
//! rounds as IEEE 754 asks writes the same files.

mod bodies;

use bodies::{Rig, box_on_plane, wall};
use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::fclib::{Cone, FclibError, Info, Problem};

/// A problem under the name of its file.
pub(crate) struct Named {
    pub(crate) name: &'static str,
    pub(crate) problem: Problem,
}

/// Factor between the units of a problem and those of its badly scaled twin.
pub(crate) const UNITS: f64 = 1e6;

/// Every problem of the folder `tests/data`.
pub(crate) fn all() -> Result<Vec<Named>, FclibError> {
    let mut problems = Vec::new();
    let mut add = |name, description: &str, problem: Problem| {
        let info = Info {
            title: Some(String::from(name)),
            description: Some(description.into()),
            math_info: problem.info.math_info.clone(),
        };
        problems.push(Named { name, problem: Problem { info, ..problem } });
    };

    planar(&mut add)?;
    spatial(&mut add)?;
    Ok(problems)
}

type Add<'a> = dyn FnMut(&'static str, &str, Problem) + 'a;

fn planar(add: &mut Add<'_>) -> Result<(), FclibError> {
    // A box that touches with its centre column: W = diag(1/m, 1/m) and a lever of half its height.
    let one = |velocity: [f64; 3], mu| box_on_plane::<2>(1, &velocity, mu);
    add("planar-take-off", "a box that leaves the plane", local(&one([0.3, 0.2, 0.0], 0.4))?);
    add("planar-stick", "a box that hits the plane and sticks", local(&one([0.02, -1.0, 0.0], 0.7))?);
    add("planar-slide", "a box that hits the plane and slides", local(&one([2.0, -1.0, 0.0], 0.3))?);

    let three = box_on_plane::<2>(3, &[1.0, -1.0, 0.4], 0.3);
    add("planar-three", "a box on three points, redundant: rank 3 of 6", local(&three)?);
    add("planar-three-global", "planar-three with its body", three.problem());
    add(
        "planar-rank-deficient",
        "a box on six points: rank 3 of 12",
        local(&box_on_plane::<2>(6, &[0.7, -1.0, -0.3], 0.4))?,
    );

    let ten = wall::<2>(3, 10, &|_| 0.5);
    let cone = planar_cone(&ten)?;
    add("planar-ten", "ten contacts of a small wall of bricks", Problem::from_cone(&cone, Info::default())?);
    add("planar-ten-global", "planar-ten with its bodies", ten.problem());
    add("planar-asymmetric", "planar-ten with W made asymmetric by 1e-3", skewed(&cone)?);
    add(
        "planar-impulse-units",
        "planar-ten with percussions counted in units 1e6 times larger",
        scaled(&cone, UNITS, 1.0)?,
    );
    add(
        "planar-velocity-units",
        "planar-ten with velocities counted in units 1e6 times smaller",
        scaled(&cone, UNITS, UNITS)?,
    );
    add("planar-duplicated", "planar-ten with every contact given twice", picked(&cone, &twice(10))?);
    add("planar-permuted", "planar-ten with its contacts in another order", picked(&cone, &shuffled(10))?);
    let friction = |k: usize| 10.0 * k as f64 / 9.0;
    add("planar-friction", "ten contacts with μ from 0 to 10", local(&wall::<2>(3, 10, &friction))?);
    add("planar-hundred", "a hundred contacts of a wall of bricks", local(&wall::<2>(10, 100, &|_| 0.5))?);
    Ok(())
}

fn spatial(add: &mut Add<'_>) -> Result<(), FclibError> {
    let one = |velocity: [f64; 6], mu| box_on_plane::<3>(1, &velocity, mu);
    add(
        "spatial-take-off",
        "a box that leaves the plane",
        local(&one([0.3, -0.1, 0.2, 0.0, 0.0, 0.1], 0.4))?,
    );
    add(
        "spatial-stick",
        "a box that hits the plane and sticks",
        local(&one([0.02, 0.01, -1.0, 0.0, 0.0, 0.0], 0.7))?,
    );
    add(
        "spatial-slide",
        "a box that hits the plane and slides",
        local(&one([2.0, -1.5, -1.0, 0.0, 0.0, 0.0], 0.3))?,
    );

    let three = box_on_plane::<3>(3, &[1.0, 0.5, -1.0, 0.4, -0.2, 0.3], 0.3);
    add("spatial-three", "a box on three points, redundant: rank 6 of 9", local(&three)?);
    add("spatial-three-global", "spatial-three with its body", three.problem());
    let eight = box_on_plane::<3>(8, &[0.7, -0.4, -1.0, -0.3, 0.2, 0.5], 0.4);
    add("spatial-rank-deficient", "a box on eight points: rank 6 of 24", local(&eight)?);

    let ten = wall::<3>(2, 10, &|_| 0.5);
    let cone = spatial_cone(&ten)?;
    add("spatial-ten", "ten contacts of a small wall of bricks", Problem::from_cone(&cone, Info::default())?);
    add("spatial-ten-global", "spatial-ten with its bodies", ten.problem());
    add("spatial-asymmetric", "spatial-ten with W made asymmetric by 1e-3", skewed(&cone)?);
    add(
        "spatial-impulse-units",
        "spatial-ten with percussions counted in units 1e6 times larger",
        scaled(&cone, UNITS, 1.0)?,
    );
    add(
        "spatial-velocity-units",
        "spatial-ten with velocities counted in units 1e6 times smaller",
        scaled(&cone, UNITS, UNITS)?,
    );
    add("spatial-duplicated", "spatial-ten with every contact given twice", picked(&cone, &twice(10))?);
    add("spatial-permuted", "spatial-ten with its contacts in another order", picked(&cone, &shuffled(10))?);
    let friction = |k: usize| 10.0 * k as f64 / 9.0;
    add("spatial-friction", "ten contacts with μ from 0 to 10", local(&wall::<3>(2, 10, &friction))?);
    add("spatial-hundred", "a hundred contacts of a wall of bricks", local(&wall::<3>(7, 100, &|_| 0.5))?);
    Ok(())
}

fn planar_cone(rig: &Rig<2>) -> Result<ConeProblem<f64, 2>, FclibError> {
    match rig.problem().cone()? {
        Cone::Planar(cone) => Ok(cone),
        Cone::Spatial(_) => unreachable!("a planar rig"),
    }
}

fn spatial_cone(rig: &Rig<3>) -> Result<ConeProblem<f64, 3>, FclibError> {
    match rig.problem().cone()? {
        Cone::Spatial(cone) => Ok(cone),
        Cone::Planar(_) => unreachable!("a spatial rig"),
    }
}

fn local<const D: usize>(rig: &Rig<D>) -> Result<Problem, FclibError> {
    match rig.problem().cone()? {
        Cone::Planar(cone) => Problem::from_cone(&cone, Info::default()),
        Cone::Spatial(cone) => Problem::from_cone(&cone, Info::default()),
    }
}

/// W with the entries of each pair of places moved apart by 1e-3 √(W_ii W_jj).
fn skewed<const D: usize>(cone: &ConeProblem<f64, D>) -> Result<Problem, FclibError> {
    rebuilt(
        cone,
        &(0..cone.contacts()).collect::<Vec<_>>(),
        |place, block, sizes| {
            SMatrix::from_fn(|i, j| {
                let (row, column) = (place.0 * D + i, place.1 * D + j);
                let side = if row < column { 1.0 } else { -1.0 };
                let skew = if row == column { 0.0 } else { side * 5e-4 * (sizes.0[i] * sizes.1[j]).sqrt() };
                block[(i, j)] + skew
            })
        },
        1.0,
    )
}

/// W × `operator` and b × `velocity`: the same motion in other units.
fn scaled<const D: usize>(
    cone: &ConeProblem<f64, D>,
    operator: f64,
    velocity: f64,
) -> Result<Problem, FclibError> {
    rebuilt(cone, &(0..cone.contacts()).collect::<Vec<_>>(), |_, block, _| block * operator, velocity)
}

/// The problem of the contacts `picks`, in that order, repeated where an index is repeated.
fn picked<const D: usize>(cone: &ConeProblem<f64, D>, picks: &[usize]) -> Result<Problem, FclibError> {
    rebuilt(cone, picks, |_, block, _| *block, 1.0)
}

/// Contact k as contacts 2k and 2k + 1.
pub(crate) fn twice(contacts: usize) -> Vec<usize> {
    (0..2 * contacts).map(|k| k / 2).collect()
}

/// A permutation without fixed points for 10 contacts: k → 3k + 5 modulo the number, which 3 does not divide.
pub(crate) fn shuffled(contacts: usize) -> Vec<usize> {
    assert!(!contacts.is_multiple_of(3), "3k + 5 permutes only where 3 does not divide");
    (0..contacts).map(|k| (3 * k + 5) % contacts).collect()
}

type Diagonals<'a, const D: usize> = (&'a SVector<f64, D>, &'a SVector<f64, D>);

fn rebuilt<const D: usize>(
    cone: &ConeProblem<f64, D>,
    picks: &[usize],
    change: impl Fn((usize, usize), &SMatrix<f64, D, D>, Diagonals<'_, D>) -> SMatrix<f64, D, D>,
    velocity: f64,
) -> Result<Problem, FclibError> {
    let mut result = ConeProblem::<f64, D>::default();
    let (delassus, b, friction) = result.parts_mut();
    let mut own = BlockMatrix::new();
    let w = cone.delassus().form_in(&mut own);
    for (row, &i) in picks.iter().enumerate() {
        delassus.start_row();
        for (column, &j) in picks.iter().enumerate() {
            if let Some((_, block)) = w.row(i).find(|&(k, _)| k == j) {
                let sizes = (cone.diagonal(i).diagonal(), cone.diagonal(j).diagonal());
                delassus.push(column, change((row, column), block, (&sizes.0, &sizes.1)));
            }
        }
        b.push(cone.b()[i] * velocity);
        friction.push(cone.cones()[i]);
    }
    Problem::from_cone(&result, Info::default())
}
