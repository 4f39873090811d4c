//! The multifrontal LU of the Newton systems beside faer's sparse LU: `cargo bench --bench sparse_lu`.
//!
//! W + 10⁻⁴ I of walls and packings, ordered once, then factored and solved; all contacts closed, and every second one
//! open, as a Newton method meets them: ours leaves those out, faer's keeps identity rows, so that its order serves too.

#[allow(dead_code)]
mod families;

use divan::{Bencher, black_box};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};
use families::{packing, wall};
use nonsmooth::cone::Form;
use nonsmooth::linalg::{Multifrontal, SolveBuffers};

const D: usize = 3;

/// Name, size and share of closed contacts.
const CASES: &[(&str, usize, usize)] = &[
    ("wall", 7, 1),
    ("wall", 7, 2),
    ("wall", 16, 1),
    ("wall", 16, 2),
    ("packing", 5, 1),
    ("packing", 5, 2),
    ("packing", 8, 1),
    ("packing", 8, 2),
];

/// W + 10⁻⁴ I in block rows, its blocks in columns, and which contacts are closed.
struct Case {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    closed: Vec<bool>,
}

impl Case {
    fn new(&(name, side, every): &(&str, usize, usize)) -> Self {
        let family = if name == "wall" { wall(side, side, 1) } else { packing(side, side, 2) };
        let problem = family.problem(Form::Formed, 0.0);
        let w = problem.delassus().formed().expect("formed");
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for i in 0..w.rows() {
            for (j, block) in w.row(i) {
                columns.push(j);
                for c in 0..D {
                    let diagonal = |r| if (i, r) == (j, c) { 1e-4 } else { 0.0 };
                    values.extend((0..D).map(|r| block[(r, c)] + diagonal(r)));
                }
            }
            starts.push(columns.len());
        }
        let closed = (0..w.rows()).map(|i| i % every == 0).collect();
        Self { starts, columns, values, closed }
    }

    fn size(&self) -> usize {
        self.closed.len() * D
    }

    /// Compressed scalar columns: the pattern is symmetric, so that the columns of blocks are the rows.
    fn scalar(&self) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..self.closed.len() {
            for c in 0..D {
                for &i in &self.columns[self.starts[j]..self.starts[j + 1]] {
                    let row = self.starts[i]..self.starts[i + 1];
                    let entry = row.start
                        + self.columns[row].binary_search(&j).expect("a symmetric pattern has its mirror");
                    for r in 0..D {
                        rows.push(D * i + r);
                        let value = self.values[entry * D * D + c * D + r];
                        let identity = if (i, r) == (j, c) { 1.0 } else { 0.0 };
                        values.push(if self.closed[i] && self.closed[j] { value } else { identity });
                    }
                }
                starts.push(rows.len());
            }
        }
        (starts, rows, values)
    }
}

#[divan::bench(args = CASES.iter().map(|case| format!("{} {} 1/{}", case.0, case.1, case.2)))]
fn multifrontal(bencher: Bencher, name: &str) {
    let case = case(name);
    let mut lu = Multifrontal::new();
    lu.analyse(&case.starts, &case.columns, D).expect("a symmetric pattern");
    let (mut x, mut buffers) = (vec![1.0; case.size()], SolveBuffers::default());
    bencher.bench_local(|| {
        lu.factor(black_box(&case.values), &case.closed).expect("positive definite");
        x.fill(1.0);
        lu.solve(&mut x, &mut buffers);
        x[0]
    });
}

#[divan::bench(args = CASES.iter().map(|case| format!("{} {} 1/{}", case.0, case.1, case.2)))]
fn faer_lu(bencher: Bencher, name: &str) {
    let case = case(name);
    let n = case.size();
    let (starts, rows, values) = case.scalar();
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let symbolic = factorize_symbolic_lu(pattern, Default::default()).expect("enough memory");
    let mut numeric = NumericLu::new();
    let need = symbolic
        .factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default())
        .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
    let mut memory = MemBuffer::new(need);
    let mut x = vec![1.0; n];
    bencher.bench_local(|| {
        let stack = MemStack::new(&mut memory);
        let matrix = SparseColMatRef::new(pattern, black_box(&values[..]));
        symbolic
            .factorize_numeric_lu(&mut numeric, matrix, Par::Seq, stack, Default::default())
            .expect("positive definite");
        x.fill(1.0);
        let right = MatMut::from_column_major_slice_mut(&mut x, n, 1);
        LuRef::new_unchecked(&symbolic, &numeric).solve_in_place_with_conj(Conj::No, right, Par::Seq, stack);
        x[0]
    });
}

fn case(name: &str) -> Case {
    let case = CASES.iter().find(|case| format!("{} {} 1/{}", case.0, case.1, case.2) == name);
    Case::new(case.expect("a case of the list"))
}

fn main() {
    for case in CASES {
        let case = Case::new(case);
        let closed = case.closed.iter().filter(|closed| **closed).count();
        println!("{} contacts, {closed} closed, {} blocks", case.closed.len(), case.columns.len());
    }
    divan::main();
}
