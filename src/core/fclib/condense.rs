//! From bodies to contacts: W = Hᵀ K⁻¹ H, part by part of K.
//!
//! K is split into the parts that do not touch each other (bodies, or structures held together by stiffness or
//! joints); each is factored alone, and only the contacts it touches meet in W. So W has the sparsity of the contact
//! graph, and a thousand bodies cost a thousand small factorisations.

use faer::Mat;

use super::parts::{Factor, Parts};
use super::problem::{Global, Local, LocalBilateral};
use super::{FclibError, SparseMatrix};

/// Largest number of scalar entries of a condensed W (2²⁶, 1 GiB while it is assembled): beyond, every contact meets
/// thousands of others through one body, and a solver that keeps M and H is the right one.
pub const CONDENSED_LIMIT: u64 = 1 << 26;

/// Right-hand sides solved at a time.
const BATCH: usize = 64;

type Entries = Vec<(usize, usize, f64)>;

/// K and f of a global problem: M and f, or with G the matrix [M, G; Gᵀ, 0] of (v, −λ) and (f, −b).
fn system(global: &Global) -> (Entries, Vec<f64>, &'static str) {
    let n = global.force.len();
    let mut matrix: Entries = global.mass.entries().collect();
    let mut force = global.force.clone();
    let Some(bilateral) = &global.bilateral else { return (matrix, force, "M") };
    for (i, j, x) in bilateral.directions.entries() {
        matrix.push((i, n + j, x));
        matrix.push((n + j, i, x));
    }
    force.extend(bilateral.velocity.iter().map(|b| -b));
    (matrix, force, "[M G; Gᵀ 0]")
}

/// Velocities v and multipliers λ of a global problem under the percussions r.
pub(super) fn bodies(global: &Global, r: &[f64]) -> Result<(Vec<f64>, Vec<f64>), FclibError> {
    let (matrix, mut force, name) = system(global);
    let n = global.force.len();
    global.directions.multiply_add(r, &mut force[..n]);
    let mut v = solve(&matrix, force, name)?;
    let multipliers = v.split_off(n).into_iter().map(|x| -x).collect();
    Ok((v, multipliers))
}

/// λ = −R⁻¹ (Vᵀ r + s).
pub(super) fn multipliers(bilateral: &LocalBilateral, r: &[f64]) -> Result<Vec<f64>, FclibError> {
    let mut rhs = bilateral.velocity.clone();
    bilateral.directions.multiply_add_transposed(r, &mut rhs);
    rhs.iter_mut().for_each(|x| *x = -*x);
    solve(&bilateral.compliance.entries().collect::<Vec<_>>(), rhs, "R")
}

/// K⁻¹ f, part by part.
fn solve(
    matrix: &[(usize, usize, f64)],
    mut rhs: Vec<f64>,
    name: &'static str,
) -> Result<Vec<f64>, FclibError> {
    let parts = Parts::of(matrix, rhs.len());
    let mut local = vec![0_usize; rhs.len()];
    for part in parts.iter() {
        part.rows.iter().enumerate().for_each(|(k, &i)| local[i] = k);
        let entries = part.entries.iter().map(|&e| matrix[e]).map(|(i, j, x)| (local[i], local[j], x));
        let singular = || FclibError::Singular { matrix: name, row: part.rows[0] };
        let factor = Factor::new(part.rows.len(), entries).ok_or_else(singular)?;
        let mut x = Mat::from_fn(part.rows.len(), 1, |k, _| rhs[part.rows[k]]);
        if !factor.solve(x.as_mut()) {
            return Err(singular());
        }
        part.rows.iter().enumerate().for_each(|(k, &i)| rhs[i] = x[(k, 0)]);
    }
    Ok(rhs)
}

/// W and b of a global problem.
pub(super) fn condense_global(global: &Global) -> Result<(SparseMatrix, Vec<f64>), FclibError> {
    let (matrix, force, name) = system(global);
    let mut b = global.velocity.clone();
    let w = schur(&matrix, &global.directions, &force, name, &mut b)?;
    Ok((SparseMatrix::from_entries(b.len(), b.len(), &w), b))
}

/// W − V R⁻¹ Vᵀ and q − V R⁻¹ s.
pub(super) fn condense_local(local: &Local) -> Result<(SparseMatrix, Vec<f64>), FclibError> {
    let mut b = local.velocity.clone();
    let mut entries: Vec<_> = local.delassus.entries().map(|(i, j, x)| (i as u32, j as u32, x)).collect();
    if let Some(bilateral) = &local.bilateral {
        // Hᵀ K⁻¹ H with H = Vᵀ and K = −R, on the right-hand side s.
        let matrix: Vec<_> = bilateral.compliance.entries().map(|(i, j, x)| (i, j, -x)).collect();
        let transposed: Vec<_> =
            bilateral.directions.entries().map(|(i, j, x)| (j as u32, i as u32, x)).collect();
        let directions = SparseMatrix::from_entries(bilateral.velocity.len(), b.len(), &transposed);
        entries.extend(schur(&matrix, &directions, &bilateral.velocity, "R", &mut b)?);
    }
    Ok((SparseMatrix::from_entries(b.len(), b.len(), &entries), b))
}

/// The entries of Hᵀ K⁻¹ H, and b ← b + Hᵀ K⁻¹ f; K has as many rows as `force`, H may have fewer (zeros follow).
fn schur(
    matrix: &[(usize, usize, f64)],
    directions: &SparseMatrix,
    force: &[f64],
    name: &'static str,
    b: &mut [f64],
) -> Result<Vec<(u32, u32, f64)>, FclibError> {
    let parts = Parts::of(matrix, force.len());
    let row_of = |i: usize| (i < directions.rows()).then(|| directions.row(i)).into_iter().flatten();
    let mut result = Vec::new();
    let mut booked = 0_u64;
    // Place of a column of H among those its part touches.
    let mut place = vec![usize::MAX; directions.columns()];
    let mut local = vec![0_usize; force.len()];
    for part in parts.iter() {
        let mut columns: Vec<usize> = Vec::new();
        for (k, &i) in part.rows.iter().enumerate() {
            local[i] = k;
            for (j, _) in row_of(i) {
                if place[j] == usize::MAX {
                    place[j] = columns.len();
                    columns.push(j);
                }
            }
        }
        if columns.is_empty() {
            continue;
        }
        booked += (columns.len() as u64).pow(2);
        if booked > CONDENSED_LIMIT {
            return Err(FclibError::Dense { entries: booked, limit: CONDENSED_LIMIT });
        }
        let entries = part.entries.iter().map(|&e| matrix[e]).map(|(i, j, x)| (local[i], local[j], x));
        let singular = || FclibError::Singular { matrix: name, row: part.rows[0] };
        let factor = Factor::new(part.rows.len(), entries).ok_or_else(singular)?;

        // K⁻¹ of the right-hand sides [H f], a batch at a time; f is the last column.
        let mut begin = 0;
        while begin <= columns.len() {
            let end = (begin + BATCH).min(columns.len() + 1);
            let mut x = Mat::<f64>::zeros(part.rows.len(), end - begin);
            for (k, &i) in part.rows.iter().enumerate() {
                for (j, value) in row_of(i) {
                    if (begin..end).contains(&place[j]) {
                        x[(k, place[j] - begin)] = value;
                    }
                }
                if end == columns.len() + 1 {
                    x[(k, end - 1 - begin)] = force[i];
                }
            }
            if !factor.solve(x.as_mut()) {
                return Err(singular());
            }
            for c in begin..end {
                let solved = x.col(c - begin);
                let mut image = vec![0.0; columns.len()];
                for (k, &i) in part.rows.iter().enumerate() {
                    row_of(i).for_each(|(j, value)| image[place[j]] += value * solved[k]);
                }
                match columns.get(c) {
                    Some(&column) => {
                        let line = columns.iter().zip(&image).filter(|&(_, &value)| value != 0.0);
                        result.extend(line.map(|(&row, &value)| (row as u32, column as u32, value)));
                    }
                    None => columns.iter().zip(&image).for_each(|(&row, &value)| b[row] += value),
                }
            }
            begin = end;
        }
        columns.iter().for_each(|&j| place[j] = usize::MAX);
    }
    Ok(result)
}
