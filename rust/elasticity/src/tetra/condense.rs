// SPDX-License-Identifier: MIT OR Apache-2.0
use std::cell::OnceCell;
use std::time::Instant;

use faer::Mat;
use mtb_operator::dense::WORK_UNWATCHED;
use mtb_operator::{Monitor, check_memory, ready_products};
use rayon::prelude::*;

use super::balance::{ReactionRows, WRENCH, lever};
use super::body::TetraBody;
use super::condensed::{Balance, CondensedBody, Flexibility};
use super::factor::{Products, Reached, SparseColumn, Symbolic};
use super::factorised::{Factored, Limits, poll};
use super::mesh::TetraMesh;
use super::mirror::{Mirror, PointImages};
use super::relief::{Freed, Relief};
use super::rigid::RigidMode;
use super::sampling::{Sampling, SurfacePoint, face_shape};
use super::support::{Source, Unknowns};
use crate::Error;

/// For one contact point the nodes under it, each with `sum_q w phi N e_c` in row `c` [m2].
pub(super) type PointTrace = Vec<(usize, [[f64; 3]; 3])>;

/// A contact point, a node under it, and `w phi N e_c` at one place, as in [`PointTrace`].
type TraceEntry = (usize, usize, [[f64; 3]; 3]);

/// How contact points and nodes see each other.
pub(super) struct Trace {
    points: Vec<PointTrace>,
    weights: Vec<f64>,
}

impl Trace {
    /// Area of a contact point [m2].
    pub(super) fn weight(&self, point: usize) -> f64 {
        self.weights[point]
    }

    pub(super) fn new(mesh: &TetraMesh, sampling: &Sampling) -> Result<Self, Error> {
        let count: usize = (0..sampling.quadrature().len())
            .map(|q| sampling.basis(q).len() * mesh.order().nodes_per_face())
            .sum();
        // the entries, what sorts them, and their sums
        let bytes = (3 * count * size_of::<TraceEntry>()) as f64;
        check_memory(sampling.n_points(), bytes, f64::INFINITY)?;
        let mut entries: Vec<TraceEntry> = Vec::with_capacity(count);
        for (q, point) in sampling.quadrature().iter().enumerate() {
            if point.face >= mesh.n_faces() {
                return Err(Error::NotOnBoundary(point.face));
            }
            let shape = face_shape(point.barycentric, mesh.order());
            for &(i, phi) in sampling.basis(q) {
                for (&node, n) in mesh.face(point.face).iter().zip(shape) {
                    let factor = point.weight * phi * n;
                    entries.push((i, node, point.frame.map(|e| e.map(|e| factor * e))));
                }
            }
        }
        // stable: equal inputs sum in the same order
        entries.sort_by_key(|&(i, node, _)| (i, node));
        let mut points: Vec<PointTrace> = vec![Vec::new(); sampling.n_points()];
        for (i, node, part) in entries {
            match points[i].last_mut() {
                Some((last, sum)) if *last == node => {
                    for c in 0..3 {
                        for k in 0..3 {
                            sum[c][k] += part[c][k];
                        }
                    }
                }
                _ => points[i].push((node, part)),
            }
        }
        let weights = sampling.weights();
        let most = weights.iter().copied().fold(0.0, f64::max);
        if let Some(i) = weights.iter().position(|&w| w.is_nan() || w <= 1e-9 * most) {
            return Err(Error::NoArea(i));
        }
        Ok(Trace { points, weights })
    }

    /// Weighted mean displacement of the contact points, `3 n`, under that of the nodes, `3 N`.
    pub(super) fn observe(&self, displacement: &[f64]) -> Vec<f64> {
        let (n, n_nodes) = (self.points.len(), displacement.len() / 3);
        let mut observed = vec![0.0; 3 * n];
        for (i, point) in self.points.iter().enumerate() {
            for (node, part) in point {
                for c in 0..3 {
                    for k in 0..3 {
                        observed[c * n + i] += part[c][k] * displacement[k * n_nodes + node];
                    }
                }
            }
            (0..3).for_each(|c| observed[c * n + i] /= self.weights[i]);
        }
        observed
    }

    /// Loads on the unknowns by a unit traction of point `i` in direction `c`.
    pub(super) fn column(&self, i: usize, c: usize, source: &[[Source; 3]]) -> SparseColumn {
        let entries = self.points[i].iter().flat_map(|(node, part)| {
            (0..3).filter_map(move |k| match source[*node][k] {
                Source::Unknown(unknown) => Some((unknown, part[c][k])),
                _ => None,
            })
        });
        entries.collect()
    }
}

/// Products of the right-hand sides of [`TetraBody::other_columns`] after forward substitution.
struct Responses {
    /// With each contact point, `3 n` for each.
    contact: Vec<Vec<f64>>,
    each_other: Mat<f64>,
}

impl Responses {
    fn new(
        trace: &Trace,
        factored: &Factored,
        images: Option<&PointImages>,
        groups: &[&[usize]],
        reached: &[Reached],
        others: &Reached,
    ) -> Self {
        let n = trace.points.len();
        let each_other = factored.factor.product(others, others).each_other;
        let mut contact = vec![vec![0.0; 3 * n]; each_other.ncols()];
        for (points, group) in groups.iter().zip(reached) {
            // the points are the second ones, whose images are told
            let products = factored.factor.product(others, group);
            for (k, &i) in points.iter().enumerate() {
                for c in 0..3 {
                    for (column, contact) in contact.iter_mut().enumerate() {
                        contact[c * n + i] = products.each_other[(column, 3 * k + c)];
                        if let (Some(images), Some(product)) = (images, &products.with_images) {
                            let (image, signs) = images.of(i);
                            contact[c * n + image] = signs[c] * product[(column, 3 * k + c)];
                        }
                    }
                }
            }
        }
        Responses {
            contact,
            each_other,
        }
    }

    /// Work of the inertia of each motion on the displacement by one of the right-hand sides, after `cases` of which
    /// the spread loads come.
    fn mean(&self, relief: &Relief, cases: usize, load: usize) -> Vec<f64> {
        let work = |wrench: &[f64; WRENCH]| {
            let parts = wrench.iter().enumerate();
            parts
                .map(|(k, w)| w * self.each_other[(load, cases + k)])
                .sum()
        };
        relief.wrenches().iter().map(work).collect()
    }

    /// What frees the others of the pins.
    fn freed(&self, relief: &Relief, cases: usize, trace: &Trace, modes: &[Vec<f64>]) -> Freed {
        let wrenches = relief.wrenches();
        let over = |field: &Vec<f64>| -> Vec<f64> {
            let weights = trace.weights.iter().cycle();
            field.iter().zip(weights).map(|(u, w)| u * w).collect()
        };
        let on_inertia = wrenches.iter().map(|wrench| {
            let mut sum = vec![0.0; 3 * trace.points.len()];
            for (w, response) in wrench.iter().zip(&self.contact[cases..]) {
                sum.iter_mut().zip(response).for_each(|(s, r)| *s += w * r);
            }
            sum
        });
        let between = wrenches.iter().flat_map(|wrench| {
            let mut sum = vec![0.0; wrenches.len()];
            for (k, w) in wrench.iter().enumerate() {
                let mean = self.mean(relief, cases, cases + k);
                sum.iter_mut().zip(mean).for_each(|(s, m)| *s += w * m);
            }
            sum
        });
        Freed {
            on_motions: modes.iter().map(over).collect(),
            on_inertia: on_inertia.collect(),
            between: between.collect(),
        }
    }
}

/// Row of a matrix of so many columns.
fn row(matrix: &[f64], at: usize, columns: usize) -> &[f64] {
    &matrix[at * columns..(at + 1) * columns]
}

/// Contact points whose columns go through the factor together, three columns each.
const GROUP: usize = 32;

/// Groups that go through the factor in one round, at most.
const ROUND: usize = 8;

/// Contact points in the order in which their columns go through the factor, by groups.
struct Groups {
    order: Vec<usize>,
    /// Rows of the columns of each group.
    heights: Vec<usize>,
}

impl Groups {
    /// Of all points, or of one of each two that are `images` of each other.
    fn new(
        trace: &Trace,
        unknowns: &Unknowns,
        symbolic: &Symbolic,
        images: Option<&PointImages>,
    ) -> Self {
        let mut order = elimination_order(trace, unknowns);
        order.retain(|&i| images.is_none_or(|images| images.leads(i)));
        let height = |points: &[usize]| {
            let columns = points.iter().map(|&i| trace.column(i, 2, &unknowns.source));
            let reached: Vec<usize> = columns.flatten().map(|(unknown, _)| unknown).collect();
            symbolic.rows_reached(&reached)
        };
        let heights = order.chunks(GROUP).map(height).collect();
        Groups { order, heights }
    }

    /// Memory [bytes] of the substituted columns, and of the products while groups go through the factor.
    fn memory(&self, symbolic: &Symbolic) -> f64 {
        let groups = self.order.chunks(GROUP).zip(&self.heights);
        let entries: usize = groups.map(|(points, rows)| 3 * points.len() * rows).sum();
        let at_once = rayon::current_num_threads().min(ROUND);
        8.0 * (entries + at_once * 3 * GROUP * symbolic.longest()) as f64
    }
}

/// Components of the blocks of a flexibility.
const BLOCKS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Pieces of `operations` each that the workers take between two looks at the monitor: one for each of them at
/// the least, `most` at most.
fn round(operations: f64, most: usize) -> usize {
    let workers = rayon::current_num_threads();
    let few = WORK_UNWATCHED * workers as f64 / operations.max(1.0);
    (few as usize).clamp(workers.min(most), most)
}

impl TetraBody {
    /// The body condensed onto the contact points of a sampling of its surface.
    ///
    /// The monitor is asked between its stages, every few elements of the assembly, supernodes of the numeric
    /// factorisation and groups of contact points. Nested dissection, and each of the two stages of the
    /// symbolic factorisation, are one piece.
    ///
    /// # Errors
    /// [`Error::NotOnBoundary`], [`Error::NoArea`]; [`Error::Loose`] if neither supports nor contact
    /// hold the body; [`Error::Singular`], [`Error::TooLarge`]; [`Error::Interrupted`].
    pub fn condense(
        &self,
        sampling: &Sampling,
        limits: Limits,
        monitor: Monitor<'_>,
    ) -> Result<CondensedBody, Error> {
        let trace = Trace::new(self.mesh(), sampling)?;
        let modes = self.held_by_contact(sampling)?;
        let n = sampling.n_points();
        // the blocks, and their copy in the compliance that is made of them
        let kept = 2.0 * Flexibility::memory(n);
        check_memory(n, kept, limits.bytes)?;
        ready_products()?;
        // known with the structure of the factor, and needed again with its numbers
        let ready = OnceCell::new();
        let grouped = |mirror: Option<&Mirror>, unknowns: &Unknowns, symbolic: &Symbolic| {
            ready.get_or_init(|| {
                let images = mirror.and_then(|mirror| PointImages::new(mirror, &trace.points));
                let groups = Groups::new(&trace, unknowns, symbolic, images.as_ref());
                (images, groups)
            })
        };
        let fits =
            |mirror: Option<&Mirror>, unknowns: &Unknowns, symbolic: &Symbolic, to_come: f64| {
                let factor = 8.0 * symbolic.entries() as f64;
                let (_, groups) = grouped(mirror, unknowns, symbolic);
                let needed = groups.memory(symbolic)
                    + self.memory_of_others(unknowns, n)
                    + Flexibility::memory(n);
                let needed = needed.max(kept);
                if to_come > 0.0 {
                    check_memory(n, to_come.max(factor + needed), limits.bytes)?;
                } else {
                    check_memory(n, needed, limits.bytes - factor)?;
                }
                Ok(())
            };
        let factored = self.factored(limits, &fits, monitor)?;
        let mut cost = factored.cost;

        let clock = Instant::now();
        let (images, Groups { order, heights }) = grouped(
            factored.mirror.as_ref(),
            &factored.unknowns,
            &factored.factor.symbolic,
        );
        let images = images.as_ref();
        let groups: Vec<&[usize]> = order.chunks(GROUP).collect();
        let rows = self.reaction_rows(&factored.unknowns);
        let (reached, others) = self.substituted(&trace, &factored, &groups, &rows, monitor)?;
        cost.forward_flops = reached.iter().map(|r| r.flops).sum();
        cost.forward_s = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let mut flexibility = vec![0.0; BLOCKS.len() * n * n];
        let held: usize = reached.iter().map(Reached::bytes).sum();
        cost.peak_bytes = 8 * (cost.factor_entries + 6 * n * n) + held;
        let pairs: Vec<(usize, usize)> = (0..groups.len())
            .flat_map(|i| (i..groups.len()).map(move |j| (i, j)))
            .collect();
        let longest = heights.iter().copied().max().unwrap_or(0);
        let dearest = 2.0 * (9 * GROUP * GROUP * longest) as f64;
        for (k, round) in pairs.chunks(round(dearest, 8 * ROUND)).enumerate() {
            let products: Vec<Products> = round
                .par_iter()
                .map(|&(i, j)| factored.factor.product(&reached[i], &reached[j]))
                .collect();
            for (&(i, j), product) in round.iter().zip(&products) {
                cost.product_flops += product.flops;
                let points = [groups[i], groups[j]];
                store(&mut flexibility, n, points, images, product);
            }
            poll(monitor, 4 + k)?;
        }
        let responses = Responses::new(&trace, &factored, images, &groups, &reached, &others);
        let balance = self.balance(&trace, &factored, &rows, &responses);
        cost.product_s = clock.elapsed().as_secs_f64();

        let relief = Relief::new(self, &modes);
        let (_, mode_field) = relief.fields(self);
        let case_work = self.case_work(&mode_field);
        let cases = self.cases();
        let mode_displacement: Vec<Vec<f64>> =
            mode_field.iter().map(|u| trace.observe(u)).collect();
        let freed = responses.freed(&relief, cases.len(), &trace, &mode_displacement);
        freed.free(&mut flexibility, n, &BLOCKS);
        let scaled = |response: &Vec<f64>| -> Vec<f64> {
            let weights = trace.weights.iter().cycle();
            response.iter().zip(weights).map(|(r, w)| r / w).collect()
        };
        let displaced = Relief::of_displaced(self);
        let (displaced_force, displaced_field) = displaced.fields(self);
        let case_displacement = (0..cases.len()).map(|case| {
            let mut response = responses.contact[case].clone();
            if cases[case].guided {
                let mean = responses.mean(&relief, cases.len(), case);
                freed.free_response(&mut response, row(&case_work, case, modes.len()), &mean);
                return scaled(&response);
            }
            let given = self.prescribed(&factored, case);
            let held = trace.observe(&given);
            let weights = trace.weights.iter().cycle();
            for ((entry, held), weight) in response.iter_mut().zip(held).zip(weights) {
                *entry += weight * held;
            }
            let mut response = scaled(&response);
            let mean = responses.mean(&displaced, cases.len(), case);
            for ((mean, force), field) in mean.iter().zip(&displaced_force).zip(&displaced_field) {
                let mean = mean + force.iter().zip(&given).map(|(f, u)| f * u).sum::<f64>();
                let moved = trace.observe(field);
                response
                    .iter_mut()
                    .zip(moved)
                    .for_each(|(u, m)| *u -= mean * m);
            }
            response
        });
        let case_displacement = case_displacement.collect();
        let spread_work = relief.spread_work(self.centre());
        let spread_displacement = (0..WRENCH).map(|load| {
            let mean = responses.mean(&relief, cases.len(), cases.len() + load);
            let mut response = responses.contact[cases.len() + load].clone();
            freed.free_response(&mut response, row(&spread_work, load, modes.len()), &mean);
            scaled(&response)
        });
        let spread_displacement = spread_displacement.collect();
        Ok(CondensedBody {
            mode_displacement,
            spread_displacement,
            centre: self.centre(),
            balance,
            flexibility: Flexibility::new(trace.weights, flexibility)?,
            modes,
            cases,
            case_displacement,
            case_work,
            cost,
        })
    }

    /// The columns of groups of contact points after forward substitution, and those of
    /// [`TetraBody::other_columns`], which go through the factor beside them.
    fn substituted(
        &self,
        trace: &Trace,
        factored: &Factored,
        groups: &[&[usize]],
        rows: &ReactionRows,
        monitor: Monitor<'_>,
    ) -> Result<(Vec<Reached>, Reached), Error> {
        let mut reached: Vec<Reached> = Vec::with_capacity(groups.len() + 1);
        let dearest = 2.0 * (3 * GROUP * factored.cost.factor_entries) as f64;
        // the last of them is not of contact points
        let all: Vec<Option<&[usize]>> = groups.iter().copied().map(Some).chain([None]).collect();
        for (k, round) in all.chunks(round(dearest, ROUND)).enumerate() {
            let columns: Vec<Vec<SparseColumn>> = round
                .iter()
                .map(|group| {
                    let Some(points) = group else {
                        return self.other_columns(factored, rows);
                    };
                    let pairs = points.iter().flat_map(|&i| (0..3).map(move |c| (i, c)));
                    pairs
                        .map(|(i, c)| trace.column(i, c, &factored.unknowns.source))
                        .collect()
                })
                .collect();
            reached.extend(factored.factor.forward_all(&columns));
            poll(monitor, 4 + k)?;
        }
        let others = reached.pop().expect("the last one is there always");
        Ok((reached, others))
    }

    /// Memory [bytes] of [`TetraBody::other_columns`] with their substitution and their products with `n` contact
    /// points, at most: each entry with its row, and the column without its zeros left out.
    fn memory_of_others(&self, unknowns: &Unknowns, n: usize) -> f64 {
        let columns = self.claims.cases.len() + WRENCH * (1 + self.supports().len());
        let entry = size_of::<(usize, f64)>() + 2 * size_of::<f64>();
        (columns * (entry * unknowns.n + 2 * 3 * n * size_of::<f64>())) as f64
    }

    /// Right-hand sides beside those of the contact points: a unit of each case, the spread loads, and
    /// the rows of the reactions.
    fn other_columns(&self, factored: &Factored, rows: &ReactionRows) -> Vec<SparseColumn> {
        let n_nodes = self.mesh().nodes().len();
        let spread = (0..WRENCH).map(|k| {
            let mut wrench = [0.0; WRENCH];
            wrench[k] = 1.0;
            let force = self.spread_force(wrench);
            let mut load = vec![0.0; factored.unknowns.n];
            for (node, sources) in factored.unknowns.source.iter().enumerate() {
                for (c, source) in sources.iter().enumerate() {
                    if let Source::Unknown(i) = source {
                        load[*i] += force[c * n_nodes + node];
                    }
                }
            }
            load
        });
        let sparse = |load: Vec<f64>| {
            let nonzero = load.into_iter().enumerate().filter(|(_, l)| *l != 0.0);
            nonzero.collect()
        };
        let loads = factored.case_load.iter().cloned().chain(spread);
        loads.map(sparse).chain(rows.columns()).collect()
    }

    /// The free rigid motions about the centre of the contact, all of which contact can hold.
    fn held_by_contact(&self, sampling: &Sampling) -> Result<Vec<RigidMode>, Error> {
        if self.free.is_empty() {
            return Ok(Vec::new());
        }
        let place = |q: &SurfacePoint| {
            let mut x = [0.0; 3];
            for (&node, l) in self.mesh().face(q.face).iter().zip(q.barycentric) {
                (0..3).for_each(|c| x[c] += l * self.mesh().nodes()[node][c]);
            }
            x
        };
        let points = sampling.quadrature();
        let area: f64 = points.iter().map(|q| q.weight).sum();
        let mut centre = [0.0; 3];
        for q in points {
            let x = place(q);
            (0..3).for_each(|c| centre[c] += q.weight * x[c] / area);
        }
        let unheld = self
            .free
            .unheld(points.iter().map(|q| (place(q), q.frame[2])));
        if !unheld.is_empty() {
            let names: Vec<String> = unheld.modes(centre).iter().map(RigidMode::name).collect();
            return Err(Error::Loose(names.join(", ")));
        }
        Ok(self.modes(centre))
    }

    /// Displacement of the nodes, `3 N`, that a unit of a case prescribes.
    fn prescribed(&self, factored: &Factored, case: usize) -> Vec<f64> {
        let n_nodes = self.mesh().nodes().len();
        let mut u = vec![0.0; 3 * n_nodes];
        for (node, sources) in factored.unknowns.source.iter().enumerate() {
            for c in 0..3 {
                if sources[c] == Source::Prescribed(case) {
                    u[c * n_nodes + node] = 1.0;
                }
            }
        }
        u
    }

    /// Resultants of the tractions, and the reactions of the supports to all loads.
    fn balance(
        &self,
        trace: &Trace,
        factored: &Factored,
        rows: &ReactionRows,
        responses: &Responses,
    ) -> Balance {
        let (n, n_nodes) = (trace.points.len(), self.mesh().nodes().len());
        let (n_supports, n_cases) = (self.supports().len(), factored.case_load.len());
        let first = n_cases + WRENCH;
        let mut contact = vec![0.0; WRENCH * 3 * n];
        let mut reaction = responses.contact[first..].concat();
        for (i, point) in trace.points.iter().enumerate() {
            for (node, part) in point {
                for component in 0..3 {
                    let lever = lever(self.mesh().nodes()[*node], component);
                    let holder = self.holder(*node, component);
                    for c in 0..3 {
                        for (k, lever) in lever.iter().enumerate() {
                            let load = part[c][component] * lever;
                            contact[(k * 3 + c) * n + i] += load;
                            // what loads a held node goes straight into its support
                            if let Some(s) = holder {
                                reaction[((s * WRENCH + k) * 3 + c) * n + i] -= load;
                            }
                        }
                    }
                }
            }
        }
        let mut case_reaction = Vec::with_capacity(n_supports * WRENCH * n_cases);
        let mut spread_reaction = Vec::with_capacity(n_supports * WRENCH * WRENCH);
        for s in 0..n_supports {
            for k in 0..WRENCH {
                let row = first + s * WRENCH + k;
                case_reaction.extend(
                    (0..n_cases)
                        .map(|case| responses.each_other[(row, case)] + rows.case[s][case][k]),
                );
                spread_reaction
                    .extend((0..WRENCH).map(|load| responses.each_other[(row, n_cases + load)]));
            }
        }
        for load in 0..WRENCH {
            let mut wrench = [0.0; WRENCH];
            wrench[load] = 1.0;
            let force = self.spread_force(wrench);
            for (node, &x) in self.mesh().nodes().iter().enumerate() {
                for component in 0..3 {
                    if let Some(s) = self.holder(node, component) {
                        for (k, lever) in lever(x, component).iter().enumerate() {
                            spread_reaction[(s * WRENCH + k) * WRENCH + load] -=
                                lever * force[component * n_nodes + node];
                        }
                    }
                }
            }
        }
        Balance {
            contact,
            reaction,
            case_reaction,
            spread_reaction,
        }
    }

    /// Work of a unit force on each guide on each mode; prescribed displacements do none.
    pub(super) fn case_work(&self, modes: &[Vec<f64>]) -> Vec<f64> {
        let n = self.mesh().nodes().len();
        self.cases()
            .iter()
            .flat_map(|case| {
                let node = self.supports()[case.support].nodes.first();
                modes.iter().map(move |mode| match node {
                    Some(node) if case.guided => mode[case.component * n + node],
                    _ => 0.0,
                })
            })
            .collect()
    }

    /// Forces on the nodes [N], `3 N`, of tractions [Pa] at the contact points of a sampling, `3 n`.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotOnBoundary`].
    pub fn contact_force(&self, sampling: &Sampling, traction: &[f64]) -> Result<Vec<f64>, Error> {
        let expected = 3 * sampling.n_points();
        if traction.len() != expected {
            return Err(Error::Shape {
                name: "traction",
                found: traction.len(),
                expected,
            });
        }
        // one sum over the face: a trace, which sorts what each point sees of each node, costs far more
        let (mesh, n) = (self.mesh(), sampling.n_points());
        let n_nodes = mesh.nodes().len();
        let mut force = vec![0.0; 3 * n_nodes];
        for (q, point) in sampling.quadrature().iter().enumerate() {
            if point.face >= mesh.n_faces() {
                return Err(Error::NotOnBoundary(point.face));
            }
            let mut local = [0.0; 3];
            for &(i, phi) in sampling.basis(q) {
                for (c, t) in local.iter_mut().enumerate() {
                    *t += phi * traction[c * n + i];
                }
            }
            let global = [0, 1, 2].map(|k| {
                let parts = point.frame.iter().zip(local);
                point.weight * parts.map(|(e, t)| e[k] * t).sum::<f64>()
            });
            let shape = face_shape(point.barycentric, mesh.order());
            for (&node, share) in mesh.face(point.face).iter().zip(shape) {
                for (k, f) in global.iter().enumerate() {
                    force[k * n_nodes + node] += share * f;
                }
            }
        }
        Ok(force)
    }

    /// Mean displacement of the contact points of a sampling, `3 n`, under that of the nodes, `3 N`.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotOnBoundary`], [`Error::NoArea`].
    pub fn observe(&self, sampling: &Sampling, displacement: &[f64]) -> Result<Vec<f64>, Error> {
        let expected = 3 * self.mesh().nodes().len();
        if displacement.len() != expected {
            return Err(Error::Shape {
                name: "displacement",
                found: displacement.len(),
                expected,
            });
        }
        Ok(Trace::new(self.mesh(), sampling)?.observe(displacement))
    }
}

/// Contact points sorted by where they enter the elimination tree: neighbours share their path to
/// the root.
fn elimination_order(trace: &Trace, unknowns: &Unknowns) -> Vec<usize> {
    let first = |point: &PointTrace| {
        point
            .iter()
            .flat_map(|(node, _)| unknowns.source[*node])
            .filter_map(|s| match s {
                Source::Unknown(i) => Some(i),
                _ => None,
            })
            .min()
            .unwrap_or(0)
    };
    let mut order: Vec<(usize, usize)> = trace
        .points
        .iter()
        .enumerate()
        .map(|(i, point)| (first(point), i))
        .collect();
    order.sort_unstable();
    order.into_iter().map(|(_, i)| i).collect()
}

/// Puts the products of two groups of points into the six blocks, and with them those of their images.
fn store(
    flexibility: &mut [f64],
    n: usize,
    [rows, columns]: [&[usize]; 2],
    images: Option<&PointImages>,
    products: &Products,
) {
    for (block, (c, d)) in flexibility.chunks_exact_mut(n * n).zip(BLOCKS) {
        for (a, &i) in rows.iter().enumerate() {
            for (b, &j) in columns.iter().enumerate() {
                let mut put = |i: usize, j: usize, product: &Mat<f64>, signs: [f64; 2]| {
                    block[i * n + j] = signs[0] * product[(3 * a + c, 3 * b + d)];
                    block[j * n + i] = signs[1] * product[(3 * a + d, 3 * b + c)];
                };
                put(i, j, &products.each_other, [1.0; 2]);
                if let (Some(images), Some(with_images)) = (images, &products.with_images) {
                    let ((seen_i, of_i), (seen_j, of_j)) = (images.of(i), images.of(j));
                    let both = [of_i[c] * of_j[d], of_i[d] * of_j[c]];
                    put(seen_i, seen_j, &products.each_other, both);
                    put(i, seen_j, with_images, [of_j[d], of_j[c]]);
                    put(seen_i, j, with_images, [of_i[c], of_i[d]]);
                }
            }
        }
    }
}
