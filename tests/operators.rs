//! The form in which W is held does not change what is computed.

#[path = "../benches/families/mod.rs"]
#[allow(dead_code)]
mod families;

use nalgebra::{DMatrix, SVector};
use nonsmooth::cone::{ConeProblem, FactoredDelassus, FactoredError, Form};
use nonsmooth::linalg::{BlockRows, Symmetric};
use nonsmooth::solver::{ConeSolver, Hybrid, HybridSettings, Method, Nsgs, NsgsSettings, Stopping};

fn percussions(contacts: usize) -> Vec<SVector<f64, 3>> {
    (0..contacts)
        .map(|i| SVector::from([1.0 + (i % 7) as f64, (i % 5) as f64 - 2.0, (i % 3) as f64]))
        .collect()
}

#[test]
fn both_forms_measure_the_same_residual() {
    for family in [families::wall(4, 4, 3), families::packing(3, 3, 3)] {
        let (formed, factored) = (family.problem(Form::Formed, 0.0), family.problem(Form::Factored, 0.0));
        assert!(formed.factors().is_none() && factored.factors().is_some());
        let r = percussions(formed.contacts());
        let (a, b) = (formed.residual(&r), factored.residual(&r));
        // Some 50 products summed in another order; where two eigenvalues of W_αα agree, the cubic formula gives them
        // to √ε.
        assert!((a.natural - b.natural).abs() <= 1e-13 * a.natural, "{a:?} {b:?}");
        assert!((a.scaled - b.scaled).abs() <= 1e-7 * a.scaled, "{a:?} {b:?}");
        for i in 0..formed.contacts() {
            let difference = (formed.diagonal(i) - factored.diagonal(i)).norm();
            assert!(difference <= 1e-14 * formed.diagonal(i).norm());
        }
        for i in 0..formed.contacts() {
            // W is symmetric, and what the factored problem forms is the same W.
            let difference = formed.shifted_velocity(i, &r) - factored.shifted_velocity(i, &r);
            assert!(difference.norm() <= 1e-13 * formed.shifted_velocity(i, &r).norm().max(1.0));
        }
        formed.check_symmetric_semidefinite().expect("H M⁻¹ Hᵀ is symmetric positive semidefinite");
    }
}

#[test]
fn a_coupled_mass_gives_the_dense_product() {
    let n = 8;
    let mass = DMatrix::from_fn(n, n, |i, j| if i == j { 4.0 + i as f64 } else { 1.0 / (1 + i + j) as f64 });
    let mut h = BlockRows::<f64, 2>::new();
    let dense = DMatrix::from_fn(6, n, |i, j| ((3 * i + 5 * j) % 7) as f64 - 3.0);
    for contact in 0..3 {
        h.start_row();
        (0..n).for_each(|j| h.push(j, SVector::from([dense[(2 * contact, j)], dense[(2 * contact + 1, j)]])));
    }
    let operator = FactoredDelassus::new(&h, &Symmetric::dense(mass.clone()).expect("symmetric"), 2)
        .expect("invertible");
    let w = operator.form();
    let expected = &dense * mass.try_inverse().expect("invertible") * dense.transpose();
    for i in 0..3 {
        for (j, block) in w.row(i) {
            let reference = expected.view((2 * i, 2 * j), (2, 2));
            assert!((block - reference).norm() <= 1e-13 * expected.norm(), "{i} {j}: {block} {reference}");
        }
    }
    let b = vec![SVector::from([-1.0, 0.3]); 3];
    let problem = ConeProblem::factored(operator, Form::Factored, b, vec![0.4; 3]).expect("a problem");
    let mut solver = Hybrid::solver(Stopping::to(1e-12), HybridSettings::default()).expect("in range");
    let mut r = vec![SVector::zeros(); 3];
    let solution = solver.solve(&problem, &[SVector::zeros(); 3], &mut r).expect("solved");
    assert!(solution.residual.scaled <= 1e-12);
}

#[test]
fn body_space_and_contact_space_take_the_same_steps() {
    let family = families::wall(5, 5, 1);
    let mut steps = Vec::new();
    for form in [Form::Formed, Form::Factored] {
        let problem = family.problem(form, 0.0);
        let mut solver = Hybrid::solver(Stopping::to(1e-8), HybridSettings::default()).expect("in range");
        let mut r = vec![SVector::zeros(); problem.contacts()];
        let start = r.clone();
        let solution = solver.solve(&problem, &start, &mut r).expect("a small wall is solved");
        // Judged by the other form.
        let other = family.problem(Form::Formed, 0.0);
        assert!(other.residual(&r).scaled <= 1e-8 * (1.0 + 1e-3));
        steps.push(solution.iterations);
    }
    println!("iterations {steps:?}");
}

#[test]
fn sweeps_over_bodies_are_the_sweeps_over_rows() {
    let family = families::packing(3, 3, 5);
    let sweep = |form| {
        let problem = family.problem(form, 0.0);
        let stopping = Stopping { max_iterations: Some(3), ..Stopping::to(1e-14) };
        let mut solver =
            Nsgs::solver(stopping, NsgsSettings::default().with_acceleration(0)).expect("in range");
        let mut r = vec![SVector::zeros(); problem.contacts()];
        let start = r.clone();
        // Three sweeps do not converge; their iterate is what is compared.
        let _ = solver.solve(&problem, &start, &mut r);
        r
    };
    let (rows, bodies) = (sweep(Form::Formed), sweep(Form::Factored));
    let size = rows.iter().map(|r| r.norm()).fold(0.0, f64::max);
    for (a, b) in rows.iter().zip(&bodies) {
        assert!((a - b).norm() <= 1e-11 * size, "{a} {b}");
    }
}

#[test]
fn the_smaller_system_is_chosen() {
    // A wall has four points per joint: 24 percussions against six velocities. A sphere on the floor: 3 against 6.
    assert!(families::wall(4, 4, 1).problem(Form::Auto, 0.0).factors().is_some());
    let single = families::packing(1, 1, 1);
    assert!(single.problem(Form::Auto, 0.0).factors().is_none(), "{} contacts", single.contacts());
}

#[test]
fn bad_factors_are_refused_with_their_numbers() {
    let mass = Symmetric::diagonal(vec![1.0, 2.0, 3.0]).expect("positive");
    let row = |velocity: usize, value: f64| {
        let mut h = BlockRows::<f64, 1>::new();
        h.start_row();
        h.push(velocity, SVector::from([value]));
        h
    };
    let refused =
        |h: &BlockRows<f64, 1>, mass: &Symmetric<f64>, dofs| FactoredDelassus::new(h, mass, dofs).err();
    assert_eq!(refused(&row(0, 1.0), &mass, 2), Some(FactoredError::Blocks { velocities: 3, dofs: 2 }));
    assert_eq!(refused(&row(0, 1.0), &mass, 0), Some(FactoredError::Blocks { velocities: 3, dofs: 0 }));
    assert_eq!(
        refused(&row(3, 1.0), &mass, 1),
        Some(FactoredError::Velocity { contact: 0, velocity: 3, velocities: 3 })
    );
    assert_eq!(refused(&row(0, f64::NAN), &mass, 1), Some(FactoredError::NotFinite { what: "H", index: 0 }));
    let singular = Symmetric::Diagonal(vec![1.0, 0.0, 1.0]);
    assert_eq!(refused(&row(0, 1.0), &singular, 1), Some(FactoredError::Singular { block: 1 }));
}
