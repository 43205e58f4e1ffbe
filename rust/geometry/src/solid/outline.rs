// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::{HashMap, HashSet};

use mtb_words::Short;
use spade::handles::FixedVertexHandle;
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation,
};

use super::section::SectionMesh;
use crate::Error;
use crate::error::{finite, out_of_range, positive};

/// Growth of the steps along an outline with the distance from the contact.
const GROWTH: f64 = 0.25;
/// Largest step over the size of the section.
const LONGEST: f64 = 1.0 / 16.0;
/// Turn [rad] of an outline from which its corner is a node.
const KINK: f64 = 0.2;
/// Share of a row by which the origin may lie off the outline.
const OFF: f64 = 1e-3;
/// Least angle [deg] of the triangles.
const LEAST_ANGLE: f64 = 28.0;
/// Distance of two parts of an outline, over its size, at which they touch.
const TOUCHING: f64 = 1e-9;
const CROSSING: Error = Error::Outline("crosses or touches itself");
/// Most nodes of a section.
const MOST_NODES: usize = 200_000;

/// Outline of the cross-section of a prism, straight between its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Points (y, z) [m] of what is free, the running surface among it, from one end of the base to the other.
    pub free: Vec<[f64; 2]>,
    /// Points (y, z) [m] of the base between the last free one and the first; none for a straight one.
    pub base: Vec<[f64; 2]>,
}

/// A closed polygon, its length measured from the first free point.
struct Ring {
    places: Vec<[f64; 2]>,
    /// Arc [m] of each point, and last the whole length.
    arcs: Vec<f64>,
    /// Arc [m] where the base begins.
    free: f64,
}

impl Outline {
    /// Triangles within the outline, with the edges of `rows` of cells, each `dy` [m] along the outline, as its
    /// surface: `parts` edges for each row, the middle of all rows `ahead` [m] of the point `origin` (y, z) [m] of the
    /// outline.
    ///
    /// Rows are counted in the direction that has the material on its right.
    ///
    /// # Errors
    /// [`Error::ElementNotFinite`], [`Error::Length`], [`Error::Outline`] where it crosses itself or has no area, and
    /// [`Error::OutOfRange`] for an origin that is not on it and rows that leave what is free.
    pub fn section(
        &self,
        origin: [f64; 2],
        ahead: f64,
        rows: usize,
        dy: f64,
        parts: usize,
    ) -> Result<SectionMesh, Error> {
        let dy = positive("dy", dy)?;
        let ring = self.ring()?;
        let middle = ring.nearest(origin, dy)? + finite("ahead", ahead)?;
        let half = 0.5 * rows as f64 * dy;
        let [first, last] = [middle - half, middle + half];
        if first < -1e-9 * dy || last > ring.free + 1e-9 * dy {
            let accepted = format!(
                "the rows of cells must lie on what is free of the outline, which has {} m before the origin and \
                 {} m behind it",
                Short(middle),
                Short(ring.free - middle)
            );
            return Err(out_of_range(
                "half of the length of all rows",
                half,
                accepted,
            ));
        }
        let under = |s: f64| s > first + 1e-9 * dy && s < last - 1e-9 * dy;
        if let Some((_, turn)) = ring.kinks().find(|(s, _)| under(*s)) {
            let accepted = format!(
                "rows of cells go around no corner, {} rad at most",
                Short(KINK)
            );
            return Err(out_of_range(
                "turn of the outline below the rows of cells",
                turn,
                accepted,
            ));
        }
        // corners and middles of the edges in contact
        let fine = 2 * rows * parts;
        let step = dy / parts as f64;
        let contact: Vec<[f64; 2]> = (0..=fine)
            .map(|k| ring.at(first + 0.5 * k as f64 * step))
            .collect();
        let corners: Vec<[f64; 2]> = contact.iter().step_by(2).copied().collect();
        let size = |place: [f64; 2]| -> f64 {
            let apart = |p: &[f64; 2]| (p[0] - place[0]).hypot(p[1] - place[1]);
            let nearest = corners.iter().map(apart).fold(f64::INFINITY, f64::min);
            (step + GROWTH * nearest).min((LONGEST * ring.extent()).max(step))
        };
        // the rest of the way round, from the end of the contact to its beginning
        let whole = ring.arcs[ring.arcs.len() - 1];
        let mut stops = vec![last];
        stops.extend(
            (ring.kinks().map(|(s, _)| s))
                .chain([0.0, ring.free, whole])
                .map(|s| if s < last { s + whole } else { s }),
        );
        stops.push(first + whole);
        stops.sort_by(f64::total_cmp);
        stops.retain(|s| (last..=first + whole).contains(s));
        stops.dedup_by(|a, b| *a - *b < 1e-6 * step);
        let mut nodes = corners.clone();
        let mut is_base = vec![false; corners.len() - 1];
        for pair in stops.windows(2) {
            let within = ring.divided(pair[0], pair[1], &size);
            let middle = 0.5 * (pair[0] + pair[1]);
            let base = middle > ring.free && middle < whole;
            is_base.extend(vec![base; within.len() + 1]);
            nodes.extend(within);
            nodes.push(ring.at(pair[1]));
        }
        // the last one is the first
        nodes.pop();
        triangulated(&nodes, &contact, &is_base)
    }

    /// The polygon, with its material on the right.
    fn ring(&self) -> Result<Ring, Error> {
        let (mut free, mut base) = (self.free.clone(), self.base.clone());
        for (index, value) in free.iter().chain(&base).flatten().enumerate() {
            if !value.is_finite() {
                let name = "outline";
                return Err(Error::ElementNotFinite {
                    name,
                    index,
                    value: *value,
                });
            }
        }
        free.dedup();
        if free.len() < 2 {
            return Err(Error::Length {
                name: "outline",
                found: free.len(),
                accepted: "two different points at least are needed".into(),
            });
        }
        let ends = [free[0], free[free.len() - 1]];
        if ends[0] == ends[1] {
            return Err(Error::Outline(
                "ends at the point where it begins (its base closes it, from the last point to the first: leave out the \
                 repeated one)",
            ));
        }
        base.retain(|p| !ends.contains(p));
        base.dedup();
        let all: Vec<[f64; 2]> = free.iter().chain(&base).copied().collect();
        let twice: f64 = (0..all.len())
            .map(|k| {
                let (a, b) = (all[k], all[(k + 1) % all.len()]);
                a[0] * b[1] - a[1] * b[0]
            })
            .sum();
        if twice == 0.0 {
            return Err(Error::Outline("has no area"));
        }
        if twice > 0.0 {
            free.reverse();
            base.reverse();
        }
        let mut arcs = vec![0.0];
        let places: Vec<[f64; 2]> = free.iter().chain(&base).copied().collect();
        for k in 0..places.len() {
            let (a, b) = (places[k], places[(k + 1) % places.len()]);
            arcs.push(arcs[k] + (b[0] - a[0]).hypot(b[1] - a[1]));
        }
        let free = arcs[free.len() - 1];
        let ring = Ring { places, arcs, free };
        if ring.touches_itself() {
            return Err(CROSSING);
        }
        Ok(ring)
    }
}

impl Ring {
    /// Larger side of the box around it [m].
    fn extent(&self) -> f64 {
        let side = |c: usize| {
            let all = self.places.iter().map(|p| p[c]);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        side(0).max(side(1))
    }

    /// Whether a point of it lies on a part of it that is somewhere else along the way.
    fn touches_itself(&self) -> bool {
        let n = self.places.len();
        let near = TOUCHING * self.extent();
        let on = |k: usize, place: [f64; 2], arc: f64| {
            let (a, b) = (self.places[k], self.places[(k + 1) % n]);
            let (share, apart) = nearest_on([a, b], place);
            let way = (self.arcs[k] + share * (self.arcs[k + 1] - self.arcs[k]) - arc).abs();
            apart < near && way.min(self.arcs[n] - way) > 1e3 * near
        };
        (0..n).any(|i| (0..n).any(|k| on(k, self.places[i], self.arcs[i])))
    }

    /// The place at an arc [m], which may go round once more.
    fn at(&self, arc: f64) -> [f64; 2] {
        let n = self.places.len();
        let whole = self.arcs[n];
        let arc = if arc >= whole { arc - whole } else { arc };
        let k = self.arcs.partition_point(|s| *s <= arc).clamp(1, n) - 1;
        let share = (arc - self.arcs[k]) / (self.arcs[k + 1] - self.arcs[k]);
        let (a, b) = (self.places[k], self.places[(k + 1) % n]);
        [0, 1].map(|c| a[c] + share * (b[c] - a[c]))
    }

    /// Arc [m] of the free point nearest to a place, which is on the outline.
    fn nearest(&self, place: [f64; 2], dy: f64) -> Result<f64, Error> {
        let mut best = (f64::INFINITY, 0.0);
        for (k, pair) in self.places.windows(2).enumerate() {
            if self.arcs[k] >= self.free {
                break;
            }
            let (share, apart) = nearest_on([pair[0], pair[1]], place);
            if apart < best.0 {
                best = (
                    apart,
                    self.arcs[k] + share * (self.arcs[k + 1] - self.arcs[k]),
                );
            }
        }
        if best.0.is_nan() || best.0 > OFF * dy {
            let accepted = String::from("the origin must be a point of the outline that is free");
            return Err(out_of_range(
                "distance of the origin from the outline",
                best.0,
                accepted,
            ));
        }
        Ok(best.1)
    }

    /// Arcs [m] of its corners, and by how much [rad] it turns there.
    fn kinks(&self) -> impl Iterator<Item = (f64, f64)> {
        let n = self.places.len();
        let turns = (0..n).map(move |k| {
            let [before, own, after] = [n + k - 1, k, k + 1].map(|i| self.places[i % n]);
            let (a, b) = (
                [own[0] - before[0], own[1] - before[1]],
                [after[0] - own[0], after[1] - own[1]],
            );
            let turn = (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
            (self.arcs[k], turn.abs())
        });
        turns.filter(|(_, turn)| *turn > KINK)
    }

    /// Places between two arcs, without both, at steps of about the given `size` there.
    fn divided(&self, from: f64, to: f64, size: &dyn Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
        let samples = 400;
        let arc = |k: usize| from + (to - from) * k as f64 / samples as f64;
        let density: Vec<f64> = (0..=samples).map(|k| 1.0 / size(self.at(arc(k)))).collect();
        let mut sums = vec![0.0];
        for k in 0..samples {
            sums.push(sums[k] + 0.5 * (density[k] + density[k + 1]) * (arc(k + 1) - arc(k)));
        }
        let count = (sums[samples].ceil() as usize).max(1);
        (1..count)
            .map(|i| {
                let wanted = sums[samples] * i as f64 / count as f64;
                let k = sums.partition_point(|s| *s < wanted).clamp(1, samples) - 1;
                let share = (wanted - sums[k]) / (sums[k + 1] - sums[k]);
                self.at(arc(k) + share * (arc(k + 1) - arc(k)))
            })
            .collect()
    }
}

/// Share of the way between two ends at which a place is nearest to it, and its distance [m] there.
fn nearest_on([a, b]: [[f64; 2]; 2], place: [f64; 2]) -> (f64, f64) {
    let along = [0, 1].map(|c| b[c] - a[c]);
    let away = [0, 1].map(|c| place[c] - a[c]);
    let square = along[0].powi(2) + along[1].powi(2);
    let share = ((away[0] * along[0] + away[1] * along[1]) / square).clamp(0.0, 1.0);
    let apart = (away[0] - share * along[0]).hypot(away[1] - share * along[1]);
    (share, apart)
}

/// Triangles between `nodes` in order around the section; `contact`: corners and middles of the first edges;
/// `is_base`: which of the edges are the base.
fn triangulated(
    nodes: &[[f64; 2]],
    contact: &[[f64; 2]],
    is_base: &[bool],
) -> Result<SectionMesh, Error> {
    let mut net = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles: Vec<FixedVertexHandle> = Vec::with_capacity(nodes.len());
    for [y, z] in nodes {
        let handle = net.insert(Point2::new(*y, *z)).map_err(|_| CROSSING)?;
        // a place that is there already
        if handle.index() != handles.len() {
            return Err(CROSSING);
        }
        handles.push(handle);
    }
    let next = |k: usize| (k + 1) % handles.len();
    for k in 0..handles.len() {
        if !net.can_add_constraint(handles[k], handles[next(k)]) {
            return Err(CROSSING);
        }
        net.add_constraint(handles[k], handles[next(k)]);
    }
    let refined = net.refine(
        RefinementParameters::new()
            .exclude_outer_faces(true)
            .keep_constraint_edges()
            .with_angle_limit(AngleLimit::from_deg(LEAST_ANGLE))
            .with_max_additional_vertices(MOST_NODES),
    );
    let outside: HashSet<_> = refined.excluded_faces.into_iter().collect();
    let mut mesh = SectionMesh::default();
    let mut number: HashMap<usize, usize> = HashMap::new();
    let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
    let ordered = |a: usize, b: usize| if a < b { [a, b] } else { [b, a] };
    for k in 0..contact.len() / 2 {
        let [a, b] = [k, k + 1].map(|k| handles[k].index());
        middles.insert(ordered(a, b), mesh.nodes.len());
        mesh.nodes.push(contact[2 * k + 1]);
    }
    for face in net.inner_faces().filter(|f| !outside.contains(&f.fix())) {
        let vertices = face.vertices().map(|v| (v.fix().index(), v.position()));
        let corner = vertices.map(|(vertex, place)| {
            *number.entry(vertex).or_insert_with(|| {
                mesh.nodes.push([place.x, place.y]);
                mesh.nodes.len() - 1
            })
        });
        let side = [[0, 1], [1, 2], [2, 0]].map(|ends| {
            let [(a, p), (b, q)] = ends.map(|k| vertices[k]);
            *middles.entry(ordered(a, b)).or_insert_with(|| {
                mesh.nodes.push([0.5 * (p.x + q.x), 0.5 * (p.y + q.y)]);
                mesh.nodes.len() - 1
            })
        });
        let [a, b, c] = corner;
        let [d, e, f] = side;
        mesh.triangles.push([a, b, c, d, e, f]);
    }
    let edge = |k: usize| -> Result<[usize; 3], Error> {
        let [a, b] = [handles[k], handles[next(k)]].map(|h| h.index());
        let found = (number.get(&a), number.get(&b), middles.get(&ordered(a, b)));
        match found {
            (Some(a), Some(b), Some(middle)) => Ok([*a, *b, *middle]),
            _ => Err(CROSSING),
        }
    };
    for (k, base) in is_base.iter().enumerate() {
        if *base {
            mesh.base.push(edge(k)?);
        } else if k < contact.len() / 2 {
            mesh.surface.push(edge(k)?);
        }
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &SectionMesh) -> f64 {
        let corner = |n: usize| mesh.nodes[n];
        let twice = |t: &[usize; 6]| {
            let [a, b, c] = [t[0], t[1], t[2]].map(corner);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        mesh.triangles.iter().map(|t| 0.5 * twice(t)).sum()
    }

    fn square(reversed: bool) -> Outline {
        let mut free = vec![[-0.05, -0.1], [-0.05, 0.0], [0.05, 0.0], [0.05, -0.1]];
        if reversed {
            free.reverse();
        }
        Outline {
            free,
            base: Vec::new(),
        }
    }

    #[test]
    fn fills_a_square_whichever_way_it_goes() {
        for reversed in [false, true] {
            let mesh = square(reversed)
                .section([0.0, 0.0], 0.0, 6, 2e-3, 2)
                .unwrap();
            assert!((area(&mesh) - 0.01).abs() < 1e-12);
            assert_eq!(mesh.surface.len(), 12);
            let places: Vec<f64> = mesh.surface.iter().map(|e| mesh.nodes[e[0]][0]).collect();
            assert!((places[0] + 6e-3).abs() < 1e-12 && (places[11] - 5e-3).abs() < 1e-12);
            let base: f64 = mesh
                .base
                .iter()
                .map(|[a, b, _]| (mesh.nodes[*a][0] - mesh.nodes[*b][0]).abs())
                .sum();
            assert!((base - 0.1).abs() < 1e-12);
            assert!(
                mesh.base
                    .iter()
                    .flatten()
                    .all(|n| (mesh.nodes[*n][1] + 0.1).abs() < 1e-12)
            );
        }
    }

    #[test]
    fn refuses_what_is_no_outline() {
        let bow = Outline {
            free: vec![[0.0, 0.0], [0.1, 0.1], [0.0, 0.1], [0.1, -0.02]],
            base: Vec::new(),
        };
        assert!(matches!(
            bow.section([0.05, 0.05], 0.0, 2, 1e-3, 1),
            Err(Error::Outline(_))
        ));
        // two parts of which one hangs on the other by a point
        let pinched = [
            [-0.05, -0.1],
            [0.0, -0.05],
            [-0.05, 0.0],
            [0.05, 0.0],
            [0.0, -0.05],
            [0.05, -0.1],
        ];
        let closed = [
            [-0.05, -0.1],
            [-0.05, 0.0],
            [0.05, 0.0],
            [0.05, -0.1],
            [-0.05, -0.1],
        ];
        for (free, reason) in [(&pinched[..], "touches itself"), (&closed[..], "repeated")] {
            let outline = Outline {
                free: free.to_vec(),
                base: Vec::new(),
            };
            let refused = outline.section([0.0, 0.0], 0.0, 2, 1e-3, 1);
            assert!(matches!(refused, Err(Error::Outline(told)) if told.contains(reason)));
        }
        let line = Outline {
            free: vec![[0.0, 0.0], [1.0, 0.0]],
            base: Vec::new(),
        };
        assert!(matches!(
            line.section([0.5, 0.0], 0.0, 2, 1e-3, 1),
            Err(Error::Outline(_))
        ));
        let off = square(false).section([0.0, 0.01], 0.0, 2, 1e-3, 1);
        assert!(matches!(off, Err(Error::OutOfRange { .. })));
        let long = square(false).section([0.0, 0.0], 0.0, 200, 2e-3, 1);
        assert!(matches!(long, Err(Error::OutOfRange { .. })));
        let one = Outline {
            free: vec![[0.0, 0.0]; 3],
            base: Vec::new(),
        };
        assert!(matches!(
            one.section([0.0; 2], 0.0, 1, 1e-3, 1),
            Err(Error::Length { .. })
        ));
    }
}
