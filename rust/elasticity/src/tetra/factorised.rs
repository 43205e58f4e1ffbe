// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use mtb_operator::{Monitor, Progress, available_memory, ready_products};

use super::assembly::{self, assemble};
use super::body::TetraBody;
use super::factor::{Factor, Failure, Symbolic};
use super::layers;
use super::mirror::{Halves, Mirror};
use super::numeric;
use super::ordering::{Graph, operations, postordered};
use super::support::{Source, Unknowns};
use crate::Error;

/// Largest factorisation that is started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Memory of the factor [bytes].
    pub bytes: f64,
    /// Operations.
    pub flops: f64,
}

impl Default for Limits {
    /// 8 GB and 20 TFlop: some ten minutes of two cores.
    fn default() -> Self {
        Limits {
            bytes: 8e9,
            flops: 2e13,
        }
    }
}

/// What a condensation cost: counts, and wall times [s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Unknown displacements.
    pub unknowns: usize,
    /// Entries of the Cholesky factor, 8 bytes each.
    pub factor_entries: usize,
    /// Operations of the factorisation.
    pub factor_flops: f64,
    /// Operations of the forward substitutions.
    pub forward_flops: f64,
    /// Operations of the products that form the flexibility.
    pub product_flops: f64,
    /// Largest memory held at once by factor, substituted columns and flexibility [bytes].
    pub peak_bytes: usize,
    /// Ordering.
    pub ordering_s: f64,
    /// Assembly.
    pub assembly_s: f64,
    /// Symbolic factorisation.
    pub symbolic_s: f64,
    /// Numeric factorisation.
    pub numeric_s: f64,
    /// Forward substitutions.
    pub forward_s: f64,
    /// Products.
    pub product_s: f64,
}

/// The factorised stiffness of a body.
pub(super) struct Factored {
    /// In which the body does not change: the factor is then that of its half.
    pub(super) mirror: Option<Mirror>,
    /// Those of the whole body.
    pub(super) unknowns: Unknowns,
    pub(super) factor: Factor,
    /// Loads on the unknowns by a unit of each case.
    pub(super) case_load: Vec<Vec<f64>>,
    pub(super) cost: Cost,
}

/// In which order the nodes are eliminated.
struct Elimination {
    /// In which the body does not change: of its half alone then.
    mirror: Option<Mirror>,
    /// What holds the motions that the supports leave.
    pins: Vec<(usize, usize)>,
    /// Nodes, those on the plane of the mirror last.
    order: Vec<usize>,
    /// Nodes before those on the plane.
    off_plane: usize,
}

/// Refuses what is to be made of a factor, from its structure and the memory [bytes] that its numbers are still
/// to take: asked before they are made.
pub(super) type Fits<'a> =
    &'a dyn Fn(Option<&Mirror>, &Unknowns, &Symbolic, f64) -> Result<(), Error>;

/// Smallest ratio of squared pivots of a body that is held: below, some part of it is loose.
const LOOSE_PIVOT: f64 = 1e-14;

impl TetraBody {
    /// Whether the body on its supports is its own mirror image, of which one half is factorised.
    pub fn has_mirror(&self) -> bool {
        !self.mirrors().is_empty()
    }

    /// Mirrors in which the body on its supports does not change.
    fn mirrors(&self) -> Vec<Mirror> {
        let claim = &self.claims.claim;
        Mirror::all(&self.mesh, &|node, image| claim[node] == claim[image])
    }

    /// The factorised stiffness, made on the first call, if what is to be made of it `fits`.
    pub(super) fn factored(
        &self,
        limits: Limits,
        fits: Fits<'_>,
        monitor: Monitor<'_>,
    ) -> Result<Arc<Factored>, Error> {
        let mut slot = self.factored.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(factored) = &*slot {
            let (unknowns, symbolic) = (&factored.unknowns, &factored.factor.symbolic);
            fits(factored.mirror.as_ref(), unknowns, symbolic, 0.0)?;
            return Ok(factored.clone());
        }
        let factored = Arc::new(self.factorise(limits, fits, monitor)?);
        *slot = Some(factored.clone());
        Ok(factored)
    }

    /// The elimination with the fewest operations: of the whole, or of a half of it.
    fn elimination(&self, graph: &Graph, monitor: Monitor<'_>) -> Result<Elimination, Error> {
        let (mesh, claims) = (&self.mesh, &self.claims);
        let active = claims.active();
        let mut best: Option<(f64, Elimination)> = None;
        let mirrors = self.mirrors();
        let is_choice = !mirrors.is_empty();
        for mirror in mirrors.into_iter().map(Some).chain([None]) {
            // on the plane pins are their own image
            let on_plane = |node: usize| mirror.as_ref().is_none_or(|m| m.is_on_plane(node));
            let pins = self.free.pins(mesh, claims, on_plane);
            if pins.len() < self.free.len() && mirror.is_some() {
                continue;
            }
            let before = |node: usize| mirror.as_ref().is_none_or(|m| m.is_before(node));
            let inner: Vec<bool> = (0..active.len())
                .map(|node| active[node] && before(node))
                .collect();
            let dissected = layers::elimination(graph, &inner, mesh.nodes());
            poll(monitor, 0)?;
            let mut order = postordered(graph, &dissected);
            poll(monitor, 0)?;
            let off_plane = order.len();
            if let Some(mirror) = &mirror {
                order.extend(mirror.on_plane().filter(|&node| active[node]));
            }
            let operations = if is_choice {
                operations(graph, &order)
            } else {
                0.0
            };
            if best.as_ref().is_none_or(|(least, _)| operations < *least) {
                let found = Elimination {
                    mirror,
                    pins,
                    order,
                    off_plane,
                };
                best = Some((operations, found));
            }
        }
        Ok(best.expect("the whole, if nothing else").1)
    }

    fn factorise(
        &self,
        limits: Limits,
        fits: Fits<'_>,
        monitor: Monitor<'_>,
    ) -> Result<Factored, Error> {
        let mut cost = Cost::default();
        let clock = Instant::now();
        let per_tet = self.mesh.order().nodes_per_tet();
        let graph = Graph::of_groups(
            self.mesh.nodes().len(),
            self.mesh.cells().chunks_exact(per_tet),
        );
        poll(monitor, 0)?;
        let Elimination {
            mirror,
            pins,
            order,
            off_plane,
        } = self.elimination(&graph, monitor)?;
        let off_plane = self.claims.number(&order[..off_plane], &pins);
        let off_plane = off_plane.n - off_plane.n_guided;
        // those that are factorised: of the whole, or of the half before the mirror
        let solved = self.claims.number(&order, &pins);
        let unknowns = match &mirror {
            None => solved.clone(),
            Some(mirror) => {
                let behind = order.iter().filter(|&&node| mirror.is_before(node));
                let images: Vec<usize> = behind.map(|&node| mirror.image(node)).collect();
                self.claims.number(&[&order[..], &images].concat(), &pins)
            }
        };
        let halves = mirror
            .as_ref()
            .map(|mirror| Halves::new(mirror, &unknowns, &solved, off_plane));
        let tets: Vec<usize> = (0..self.mesh.n_tets())
            .filter(|&tet| {
                let cell = self.mesh.cell(tet);
                let mirror = mirror.as_ref();
                mirror.is_none_or(|m| !cell.iter().any(|&node| m.is_behind(node)))
            })
            .collect();
        cost.ordering_s = clock.elapsed().as_secs_f64();
        poll(monitor, 0)?;

        if available_memory().is_some_and(|free| assembly::memory(&graph, &solved) > free) {
            return Err(Error::OutOfMemory {
                unknowns: unknowns.n,
            });
        }
        let clock = Instant::now();
        let stiffness = assembly::pattern(&graph, &order, &solved);
        cost.assembly_s = clock.elapsed().as_secs_f64();
        poll(monitor, 1)?;

        let clock = Instant::now();
        let node_of = |unknown: usize| {
            let at = |s: &[Source; 3]| s.contains(&Source::Unknown(unknown));
            solved.source.iter().position(at).unwrap_or(0)
        };
        let describe = |failure: Failure| match failure {
            Failure::Pivot(unknown) => Error::Singular {
                node: node_of(unknown),
            },
            Failure::Interrupted => Error::Interrupted,
            Failure::Memory => Error::OutOfMemory {
                unknowns: unknowns.n,
            },
        };
        let symbolic = Symbolic::new(&stiffness, halves, monitor).map_err(describe)?;
        let (entries, flops) = (symbolic.entries(), symbolic.flops());
        cost.symbolic_s = clock.elapsed().as_secs_f64();
        ready_products()?;
        let bytes = numeric::memory(&symbolic);
        let available = available_memory().unwrap_or(f64::INFINITY);
        if bytes > limits.bytes.min(available) || flops > limits.flops {
            return Err(Error::TooLarge {
                unknowns: unknowns.n,
                gigabytes: 1e-9 * bytes,
                teraflop: 1e-12 * flops,
                gigabytes_limit: 1e-9 * limits.bytes,
                teraflop_limit: 1e-12 * limits.flops,
                available: 1e-9 * available.max(0.0),
            });
        }
        fits(mirror.as_ref(), &unknowns, &symbolic, bytes)?;
        poll(monitor, 2)?;

        let clock = Instant::now();
        let assemble = || {
            assemble(
                &self.mesh,
                self.material,
                &tets,
                &solved,
                stiffness,
                monitor,
            )
        };
        let (stiffness, values) = with_zeros(entries, assemble, monitor)?;
        let values = values.map_err(describe)?;
        let mut case_load = assembly::pulls(&self.mesh, self.material, &unknowns, monitor)?;
        for (load, case) in case_load.iter_mut().zip(&unknowns.cases) {
            if let Some(unknown) = case.unknown {
                *load = vec![0.0; unknowns.n];
                load[unknown] = 1.0;
            }
        }
        cost.assembly_s += clock.elapsed().as_secs_f64();
        poll(monitor, 2)?;

        let clock = Instant::now();
        let factor = symbolic
            .numeric(&stiffness, values, monitor)
            .map_err(describe)?;
        let (ratio, unknown) = factor.pivot_ratio();
        if ratio < LOOSE_PIVOT {
            return Err(describe(Failure::Pivot(unknown)));
        }
        cost.numeric_s = clock.elapsed().as_secs_f64();
        cost.unknowns = unknowns.n;
        cost.factor_entries = entries;
        cost.factor_flops = flops;
        poll(monitor, 3)?;
        Ok(Factored {
            mirror,
            unknowns,
            factor,
            case_load,
            cost,
        })
    }
}

/// What `make` makes, and beside it, on another thread, as many zeros as `length`.
///
/// The system takes about as long to give memory as a body is assembled, and longer if two threads ask for it.
fn with_zeros<T>(
    length: usize,
    make: impl FnOnce() -> Result<T, Error>,
    monitor: Monitor<'_>,
) -> Result<(T, Result<Vec<f64>, Failure>), Error> {
    let mut zeros = match numeric::reserved(length) {
        Ok(zeros) => zeros,
        Err(failure) => return Ok((make()?, Err(failure))),
    };
    if rayon::current_num_threads() == 1 {
        let made = make()?;
        while zeros.len() < length {
            zeros.resize(length.min(zeros.len() + AT_ONCE), 0.0);
            poll(monitor, 2)?;
        }
        return Ok((made, Ok(zeros)));
    }
    let (is_stopped, is_done) = (AtomicBool::new(false), AtomicBool::new(false));
    let made = rayon::in_place_scope(|scope| {
        scope.spawn(|_| {
            while zeros.len() < length && !is_stopped.load(Ordering::Relaxed) {
                zeros.resize(length.min(zeros.len() + AT_ONCE), 0.0);
            }
            is_done.store(true, Ordering::Release);
        });
        let mut made = make();
        let mut waited = 0;
        while made.is_ok() && !is_done.load(Ordering::Acquire) {
            // a thread of the pool itself may be the one that has to do it
            if rayon::yield_now() != Some(rayon::Yield::Executed) {
                sleep(Duration::from_millis(1));
            }
            waited += 1;
            if waited % 100 == 0
                && let Err(error) = poll(monitor, 2)
            {
                made = Err(error);
            }
        }
        is_stopped.store(true, Ordering::Relaxed);
        made
    })?;
    Ok((made, Ok(zeros)))
}

/// Zeros that are made between two looks at the monitor.
const AT_ONCE: usize = 1 << 22;

/// Reports a stage to the monitor.
pub(super) fn poll(monitor: Monitor<'_>, iteration: usize) -> Result<(), Error> {
    let progress = Progress {
        iteration,
        residual: f64::NAN,
    };
    match monitor(progress) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
