// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers of the sparse Cholesky factor, supernode by supernode, with a look at the monitor between.

use faer::{Accum, MatMut, MatRef, Par};
use mtb_operator::dense::{Unfactored, WORK_UNWATCHED, Watch, cholesky_columns, lower_product};

use super::assembly::Lower;
use super::factor::{Failure, Symbolic};

/// Columns of an update that are formed at once: bounds its memory.
const COLUMNS: usize = 128;

/// Operations from which on threads share a product.
const SHARED: f64 = 2e6;

/// No supernode.
const NONE: usize = usize::MAX;

/// Memory [bytes] that [`factorise`] takes: the values and one update.
pub(super) fn memory(symbolic: &Symbolic) -> f64 {
    8.0 * (symbolic.entries() + symbolic.longest() * COLUMNS) as f64
}

/// Values of the factor in faer's layout: supernodes one after the other, each by columns, its square first.
///
/// Left-looking [GeorgeLiu1981]: a supernode takes its columns of the matrix, less the products of all earlier
/// supernodes that reach it, and is factorised in its place.
pub(super) fn factorise(
    symbolic: &Symbolic,
    matrix: &Lower,
    watch: &mut Watch<'_>,
) -> Result<Vec<f64>, Failure> {
    let (structure, supernode_of) = (&symbolic.structure, &symbolic.supernode_of);
    let n_supernodes = structure.n_supernodes();
    let (begin, end) = (structure.supernode_begin(), structure.supernode_end());
    let first_value = structure.col_ptr_for_val();
    let pattern = |s: usize| structure.supernode(s).pattern();
    let mut values = reserved(structure.len_val())?;
    let mut product = reserved(symbolic.longest() * COLUMNS)?;
    product.resize(product.capacity(), 0.0);
    // row of the present supernode in which each unknown below it stands
    let mut local_row = vec![0; structure.nrows()];
    let mut targets = Vec::new();
    // earlier supernodes that reach each one: lists, and where in its pattern each has come to
    let mut reaches = vec![NONE; n_supernodes];
    let mut next = vec![NONE; n_supernodes];
    let mut passed = vec![0; n_supernodes];
    for s in 0..n_supernodes {
        let size = end[s] - begin[s];
        let n_rows = size + pattern(s).len();
        values.resize(first_value[s + 1], 0.0);
        let (earlier, own) = values.split_at_mut(first_value[s]);
        for (i, row) in (begin[s]..end[s])
            .chain(pattern(s).iter().copied())
            .enumerate()
        {
            local_row[row] = i;
        }
        for (column, own) in (begin[s]..end[s]).zip(own.chunks_exact_mut(n_rows)) {
            let range = matrix.start[column]..matrix.start[column + 1];
            for (&row, &value) in matrix.row[range.clone()].iter().zip(&matrix.value[range]) {
                own[local_row[row]] = value;
            }
        }
        let mut d = reaches[s];
        while d != NONE {
            let columns = end[d] - begin[d];
            let rows = &pattern(d)[passed[d]..];
            let reached = rows.partition_point(|&row| row < end[s]);
            let all = &earlier[first_value[d]..first_value[d + 1]];
            let all = MatRef::from_column_major_slice(all, columns + pattern(d).len(), columns);
            let factor = all.subrows(columns + passed[d], rows.len());
            targets.clear();
            targets.extend(rows.iter().map(|&row| local_row[row]));
            subtract(own, n_rows, factor, &targets, reached, &mut product, watch)?;
            passed[d] += reached;
            let following = next[d];
            append(d, rows.get(reached), supernode_of, &mut reaches, &mut next);
            d = following;
        }
        let own = MatMut::from_column_major_slice_mut(own, n_rows, size);
        cholesky_columns(own, parallelism((n_rows * size * size) as f64), watch).map_err(
            |unfactored| match unfactored {
                Unfactored::Pivot(column) => Failure::Pivot(begin[s] + column),
                Unfactored::Interrupted => Failure::Interrupted,
            },
        )?;
        append(s, pattern(s).first(), supernode_of, &mut reaches, &mut next);
    }
    Ok(values)
}

/// Puts `d` on the list of the supernode that has its row `row`.
fn append(
    d: usize,
    row: Option<&usize>,
    supernode_of: &[usize],
    reaches: &mut [usize],
    next: &mut [usize],
) {
    if let Some(&row) = row {
        let s = supernode_of[row];
        next[d] = std::mem::replace(&mut reaches[s], d);
    }
}

/// Subtracts the first `columns` columns of `factor factor^T` from a supernode of `n_rows` rows, the rows and
/// columns being those of `targets`.
fn subtract(
    own: &mut [f64],
    n_rows: usize,
    factor: MatRef<'_, f64>,
    targets: &[usize],
    columns: usize,
    product: &mut [f64],
    watch: &mut Watch<'_>,
) -> Result<(), Failure> {
    let depth = 2 * factor.ncols() + 1;
    let most = (WORK_UNWATCHED / (depth * targets.len()) as f64) as usize;
    let step = most.clamp(1, COLUMNS);
    for first in (0..columns).step_by(step) {
        let count = step.min(columns - first);
        let targets = &targets[first..];
        let rows = factor.subrows(first, targets.len());
        let part = &mut product[..targets.len() * count];
        let work = (depth * part.len()) as f64;
        lower_product(
            MatMut::from_column_major_slice_mut(part, targets.len(), count),
            Accum::Replace,
            rows,
            1.0,
            parallelism(work),
        );
        for (j, part) in part.chunks_exact(targets.len()).enumerate() {
            let own = &mut own[targets[j] * n_rows..][..n_rows];
            for (&target, value) in targets[j..].iter().zip(&part[j..]) {
                own[target] -= value;
            }
        }
        watch.spend(work).map_err(|_| Failure::Interrupted)?;
    }
    Ok(())
}

/// All threads of the pool of this process, where there is work for them.
fn parallelism(operations: f64) -> Par {
    if operations < SHARED {
        return Par::Seq;
    }
    Par::rayon(rayon::current_num_threads())
}

fn reserved(length: usize) -> Result<Vec<f64>, Failure> {
    let mut values = Vec::new();
    match values.try_reserve_exact(length) {
        Ok(()) => Ok(values),
        Err(_) => Err(Failure::Memory),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::ControlFlow;

    use faer::Spec;
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
    use faer::sparse::linalg::cholesky::supernodal::{
        factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
    };
    use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
    use mtb_operator::{Progress, unmonitored};
    use proptest::prelude::*;

    use super::*;
    use crate::tetra::ordering::{Graph, nested_dissection, postordered};

    /// Numbers in [-1, 1] without structure, the same on every run.
    fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
        move || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            2.0 * (seed as f64 / u64::MAX as f64) - 1.0
        }
    }

    /// Sum of positive definite matrices of elements that have these nodes, three unknowns each, in the order of
    /// elimination of a body.
    fn assembled(n_nodes: usize, elements: &[Vec<usize>], seed: u64) -> Lower {
        let graph = Graph::of_groups(n_nodes, elements.iter().map(Vec::as_slice));
        let order = postordered(&graph, &nested_dissection(&graph, &vec![true; n_nodes]));
        let mut place = vec![0; n_nodes];
        for (at, &node) in order.iter().enumerate() {
            place[node] = at;
        }
        let mut random = numbers(seed);
        let mut columns = vec![std::collections::BTreeMap::new(); 3 * n_nodes];
        for node in 0..3 * n_nodes {
            columns[node].insert(node, 0.1);
        }
        for element in elements {
            let places = element.iter().map(|&node| place[node]);
            let unknowns: Vec<usize> = places
                .flat_map(|place| (0..3).map(move |c| 3 * place + c))
                .collect();
            let size = unknowns.len();
            let root: Vec<f64> = (0..size * size).map(|_| random()).collect();
            for i in 0..size {
                for j in 0..size {
                    if unknowns[i] >= unknowns[j] {
                        let entry = (0..size).map(|k| root[i * size + k] * root[j * size + k]);
                        *columns[unknowns[j]].entry(unknowns[i]).or_insert(0.0) +=
                            entry.sum::<f64>();
                    }
                }
            }
        }
        let mut matrix = Lower {
            start: vec![0],
            row: Vec::new(),
            value: Vec::new(),
        };
        for column in columns {
            matrix.row.extend(column.keys());
            matrix.value.extend(column.values());
            matrix.start.push(matrix.row.len());
        }
        matrix
    }

    /// A block of bricks.
    fn bricks(nx: usize, ny: usize, nz: usize) -> Lower {
        let at = |i, j, k| i + (nx + 1) * (j + (ny + 1) * k);
        let mut elements = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corner = |c: usize| at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
                    elements.push((0..8).map(corner).collect());
                }
            }
        }
        assembled((nx + 1) * (ny + 1) * (nz + 1), &elements, 7)
    }

    fn ours(matrix: &Lower, watch: &mut Watch<'_>) -> Result<Vec<f64>, Failure> {
        let Ok(symbolic) = Symbolic::new(matrix, &unmonitored) else {
            panic!("too little memory")
        };
        factorise(&symbolic, matrix, watch)
    }

    /// The factor by faer's own loop.
    fn theirs(matrix: &Lower) -> Result<Vec<f64>, LltError> {
        let Ok(symbolic) = Symbolic::new(matrix, &unmonitored) else {
            panic!("too little memory")
        };
        let n = symbolic.structure.nrows();
        let mut values = vec![0.0; symbolic.structure.len_val()];
        let par = Par::rayon(rayon::current_num_threads());
        let spec = Spec::default();
        let request =
            factorize_supernodal_numeric_llt_scratch::<usize, f64>(&symbolic.structure, par, spec);
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &matrix.start, None, &matrix.row);
        factorize_supernodal_numeric_llt(
            &mut values,
            SparseColMatRef::new(pattern, matrix.value.as_slice()),
            LltRegularization::default(),
            &symbolic.structure,
            par,
            MemStack::new(&mut MemBuffer::new(request)),
            spec,
        )?;
        Ok(values)
    }

    /// Entries of a factor that count, each with its column.
    fn lower(matrix: &Lower, values: &[f64]) -> Vec<(usize, f64)> {
        let Ok(Symbolic { structure, .. }) = Symbolic::new(matrix, &unmonitored) else {
            panic!("too little memory")
        };
        let mut entries = Vec::new();
        for s in 0..structure.n_supernodes() {
            let (first, size) = (
                structure.supernode_begin()[s],
                structure.supernode_end()[s] - structure.supernode_begin()[s],
            );
            let range = structure.col_ptr_for_val()[s]..structure.col_ptr_for_val()[s + 1];
            let rows = range.len() / size;
            for (j, column) in values[range].chunks_exact(rows).enumerate() {
                entries.extend(column[j..].iter().map(|&value| (first + j, value)));
            }
        }
        entries
    }

    /// Distance of our factor from faer's, over the largest entry.
    fn difference(matrix: &Lower) -> f64 {
        let Ok(found) = ours(matrix, &mut Watch::new(&unmonitored)) else {
            panic!("our loop finds no factor")
        };
        let expected = theirs(matrix).expect("a factor");
        let expected = lower(matrix, &expected);
        let most = expected
            .iter()
            .fold(0.0, |most: f64, e| most.max(e.1.abs()));
        let found = lower(matrix, &found);
        assert_eq!(found.len(), expected.len());
        let pairs = found.iter().zip(&expected);
        pairs.fold(0.0, |worst: f64, (f, e)| {
            worst.max((f.1 - e.1).abs() / most)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn random_matrices_have_the_factor_that_faer_finds(
            elements in prop::collection::vec(prop::collection::vec(0_usize..60, 1..5), 1..120),
            seed in 1_u64..,
        ) {
            let elements: Vec<Vec<usize>> = elements
                .into_iter()
                .map(|mut element| {
                    element.sort_unstable();
                    element.dedup();
                    element
                })
                .collect();
            let mut matrix = assembled(60, &elements, seed);
            prop_assert!(difference(&matrix) < 1e-11);
            // one pivot spoilt: the same one is named
            let column = seed as usize % 180;
            matrix.value[matrix.start[column]] = -1.0;
            let Err(LltError::NonPositivePivot { index }) = theirs(&matrix) else {
                panic!("faer finds a factor")
            };
            let found = ours(&matrix, &mut Watch::new(&unmonitored));
            prop_assert!(matches!(found, Err(Failure::Pivot(unknown)) if unknown == index));
        }
    }

    #[test]
    fn a_mesh_has_the_factor_that_faer_finds_with_a_look_at_the_monitor_in_bounded_work() {
        let matrix = bricks(20, 20, 8);
        let Ok(symbolic) = Symbolic::new(&matrix, &unmonitored) else {
            panic!("too little memory")
        };
        let ends = symbolic.structure.supernode_end();
        let widths = ends.iter().zip(symbolic.structure.supernode_begin());
        let widest = widths.map(|(end, begin)| end - begin).max().unwrap_or(0);
        assert!(widest > 256, "{widest} columns: one panel holds them");
        assert!(difference(&matrix) < 1e-11);

        let looks = Cell::new(0_u32);
        let count = |_: Progress| {
            looks.set(looks.get() + 1);
            ControlFlow::Continue(())
        };
        assert!(ours(&matrix, &mut Watch::new(&count)).is_ok());
        let watched = f64::from(looks.get()) * 2.0 * WORK_UNWATCHED;
        let work = symbolic.flops();
        assert!(work > 2.0 * WORK_UNWATCHED, "{work:e} operations");
        assert!(
            watched >= work - 2.0 * WORK_UNWATCHED && looks.get() > 0,
            "{} looks in {work:e} operations",
            looks.get()
        );
        let all = looks.get();
        for last in 1..=all {
            let stop = |progress: Progress| {
                if progress.iteration as u32 == last {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            };
            let found = ours(&matrix, &mut Watch::new(&stop));
            assert!(matches!(found, Err(Failure::Interrupted)), "look {last}");
        }
    }
}
