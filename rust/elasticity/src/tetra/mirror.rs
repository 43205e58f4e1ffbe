// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that are their own mirror image, of which one half is factorised.
//!
//! Any load is the sum of an even and an odd one, and so are the displacements. In the even one the nodes on the
//! plane of the mirror move along the plane only, in the odd one only across it. Behind the plane both are the same
//! elimination of the same half; on the plane they are apart. So one factor of the half serves both, if the
//! unknowns of the plane come last and what couples even and odd ones is left out before they are eliminated.

use std::collections::{HashMap, HashSet};

use super::condense::PointTrace;
use super::factor::SparseColumn;
use super::mesh::TetraMesh;
use super::support::{Source, Unknowns};

/// How far from its place a mirror image may lie, as a share of the size of the body.
const NEAR: f64 = 1e-11;

/// By how much loads of mirror images may differ, as a share of the largest.
const ALIKE: f64 = 1e-9;

/// Share of its partner below which a folded load is rounding.
const ROUNDING: f64 = 1e-10;

/// A mirror in which a body on its supports does not change.
pub(super) struct Mirror {
    /// The axis across it.
    axis: usize,
    /// Image of each node; those on the plane are their own.
    image: Vec<usize>,
    /// Whether each node lies behind the plane.
    is_behind: Vec<bool>,
}

impl Mirror {
    /// Those mirrors across an axis that no tetrahedron crosses, and in which nodes are `alike`.
    pub(super) fn all(mesh: &TetraMesh, alike: &dyn Fn(usize, usize) -> bool) -> Vec<Self> {
        (0..3)
            .filter_map(|axis| Self::across(mesh, alike, axis))
            .collect()
    }

    fn across(mesh: &TetraMesh, alike: &dyn Fn(usize, usize) -> bool, axis: usize) -> Option<Self> {
        let nodes = mesh.nodes();
        let along = nodes.iter().map(|x| x[axis]);
        let [least, most] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| {
            [a.min(x), b.max(x)]
        });
        let middle = 0.5 * (least + most);
        let places = Places::new(nodes, NEAR * mesh.size());
        let mut image = Vec::with_capacity(nodes.len());
        for (node, &x) in nodes.iter().enumerate() {
            let mut seen = x;
            seen[axis] = 2.0 * middle - x[axis];
            let other = places.find(seen)?;
            if !alike(node, other) {
                return None;
            }
            image.push(other);
        }
        if (0..nodes.len()).any(|node| image[image[node]] != node) {
            return None;
        }
        let is_behind: Vec<bool> = (0..nodes.len())
            .map(|node| image[node] != node && nodes[node][axis] > middle)
            .collect();
        let corners = |tet: usize, map: &dyn Fn(usize) -> usize| {
            let mut corners: [usize; 4] = std::array::from_fn(|k| map(mesh.cell(tet)[k]));
            corners.sort_unstable();
            corners
        };
        let cells: HashSet<[usize; 4]> = (0..mesh.n_tets())
            .map(|tet| corners(tet, &|node| node))
            .collect();
        let mirror = Self {
            axis,
            image,
            is_behind,
        };
        let is_whole = (0..mesh.n_tets()).all(|tet| {
            let sides = mesh.cell(tet).iter().map(|&node| mirror.side(node));
            let (mut before, mut behind) = (false, false);
            for side in sides {
                before |= side == Side::Before;
                behind |= side == Side::Behind;
            }
            !(before && behind) && cells.contains(&corners(tet, &|node| mirror.image[node]))
        });
        is_whole.then_some(mirror)
    }

    pub(super) fn image(&self, node: usize) -> usize {
        self.image[node]
    }

    /// The sign that a component of a vector takes.
    pub(super) fn sign(&self, component: usize) -> f64 {
        if component == self.axis { -1.0 } else { 1.0 }
    }

    pub(super) fn is_on_plane(&self, node: usize) -> bool {
        self.image[node] == node
    }

    pub(super) fn is_before(&self, node: usize) -> bool {
        self.side(node) == Side::Before
    }

    pub(super) fn is_behind(&self, node: usize) -> bool {
        self.is_behind[node]
    }

    pub(super) fn on_plane(&self) -> impl Iterator<Item = usize> {
        (0..self.image.len()).filter(|&node| self.is_on_plane(node))
    }

    pub(super) fn side(&self, node: usize) -> Side {
        if self.is_on_plane(node) {
            Side::OnPlane
        } else if self.is_behind[node] {
            Side::Behind
        } else {
            Side::Before
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Before,
    OnPlane,
    Behind,
}

/// Nodes by their places.
struct Places<'a> {
    nodes: &'a [[f64; 3]],
    reach: f64,
    by_cell: HashMap<[i64; 3], Vec<usize>>,
}

/// Side of a cell over the reach.
const CELL: f64 = 1e4;

impl<'a> Places<'a> {
    fn new(nodes: &'a [[f64; 3]], reach: f64) -> Self {
        let mut by_cell: HashMap<[i64; 3], Vec<usize>> = HashMap::with_capacity(nodes.len());
        for (node, x) in nodes.iter().enumerate() {
            let cell = x.map(|x| (x / (CELL * reach)).floor() as i64);
            by_cell.entry(cell).or_default().push(node);
        }
        Self {
            nodes,
            reach,
            by_cell,
        }
    }

    /// The node at a place.
    fn find(&self, place: [f64; 3]) -> Option<usize> {
        // a place at the border of a cell is looked for on both sides
        let [low, high] = [-self.reach, self.reach]
            .map(|by| place.map(|x| ((x + by) / (CELL * self.reach)).floor() as i64));
        let cells = (0..8).map(|corner: usize| {
            std::array::from_fn(|c| {
                if corner >> c & 1 == 0 {
                    low[c]
                } else {
                    high[c]
                }
            })
        });
        let mut found = None;
        let mut last = None;
        for cell in cells {
            if last == Some(cell) {
                continue;
            }
            last = Some(cell);
            let nodes = self.by_cell.get(&cell).into_iter().flatten();
            for &node in nodes {
                let is_there = (0..3).all(|c| (self.nodes[node][c] - place[c]).abs() <= self.reach);
                if is_there {
                    // two nodes at one place are told apart by nothing
                    if found.is_some_and(|other| other != node) {
                        return None;
                    }
                    found = Some(node);
                }
            }
        }
        found
    }
}

/// Where an unknown of the whole body is found in its half.
#[derive(Clone, Copy)]
struct Place {
    /// Number in the half.
    number: usize,
    side: Side,
    /// The sign that the mirror gives it.
    sign: f64,
}

/// The unknowns of a body in those of its half, the ones on the plane last.
pub(super) struct Halves {
    place: Vec<Place>,
    /// Unknowns of the half.
    n: usize,
    /// The first one on the plane.
    plane: usize,
    /// Of those on the plane, which ones are odd: across the mirror.
    is_odd: Vec<bool>,
    /// Those on the plane, the even and the odd ones.
    on_plane: [Vec<usize>; 2],
}

/// A right-hand side of the half, and its shares in the even and in the odd load of the whole.
pub(super) struct Folded {
    pub(super) column: SparseColumn,
    pub(super) shares: [f64; 2],
}

impl Halves {
    /// The unknowns of the `whole` in those of the `half`, of which as many as `plane` lie off the plane.
    pub(super) fn new(mirror: &Mirror, whole: &Unknowns, half: &Unknowns, plane: usize) -> Self {
        let nowhere = Place {
            number: usize::MAX,
            side: Side::OnPlane,
            sign: 1.0,
        };
        let mut place = vec![nowhere; whole.n];
        let mut is_odd = vec![false; half.n - plane];
        for (node, sources) in whole.source.iter().enumerate() {
            let side = mirror.side(node);
            let own = if side == Side::Behind {
                mirror.image(node)
            } else {
                node
            };
            for (component, source) in sources.iter().enumerate() {
                let (Source::Unknown(unknown), Source::Unknown(number)) =
                    (*source, half.source[own][component])
                else {
                    continue;
                };
                let sign = mirror.sign(component);
                // guided ones belong to many nodes, and are their own image
                let side = if number >= plane { Side::OnPlane } else { side };
                if side == Side::OnPlane {
                    is_odd[number - plane] = sign < 0.0;
                }
                place[unknown] = Place { number, side, sign };
            }
        }
        let on_plane = [false, true].map(|odd| {
            let numbers = plane..half.n;
            numbers.filter(|k| is_odd[k - plane] == odd).collect()
        });
        Self {
            place,
            n: half.n,
            plane,
            is_odd,
            on_plane,
        }
    }

    /// Unknowns of the whole.
    pub(super) fn len(&self) -> usize {
        self.place.len()
    }

    /// The even (0) or odd (1) unknowns of the half on the plane.
    pub(super) fn on_plane(&self, parity: usize) -> &[usize] {
        &self.on_plane[parity]
    }

    /// Unknowns of the half.
    pub(super) fn n(&self) -> usize {
        self.n
    }

    /// The first unknown of the half that lies on the plane.
    pub(super) fn plane(&self) -> usize {
        self.plane
    }

    /// Whether an unknown on the plane is odd.
    pub(super) fn is_odd(&self, number: usize) -> bool {
        self.is_odd[number - self.plane]
    }

    /// The number in the half of an unknown of the whole.
    pub(super) fn number(&self, unknown: usize) -> usize {
        self.place[unknown].number
    }

    /// Right-hand sides of the half for one of the whole: one if it loads one side of the plane, else an even and an
    /// odd one, or one of them.
    pub(super) fn fold(&self, column: &SparseColumn) -> Vec<Folded> {
        let (mut before, mut behind) = (false, false);
        for &(unknown, _) in column {
            before |= self.place[unknown].side == Side::Before;
            behind |= self.place[unknown].side == Side::Behind;
        }
        if before && behind {
            return self.fold_both(column);
        }
        let turn = if behind { -1.0 } else { 1.0 };
        let entries = column.iter().map(|&(unknown, value)| {
            let place = self.place[unknown];
            let value = match place.side {
                Side::Behind => place.sign * value,
                Side::OnPlane if place.sign < 0.0 => turn * value,
                Side::Before | Side::OnPlane => value,
            };
            (place.number, value)
        });
        vec![Folded {
            column: entries.collect(),
            shares: [1.0, turn],
        }]
    }

    /// The even and the odd right-hand side of the half for one of the whole, without those that are empty.
    pub(super) fn fold_both(&self, column: &SparseColumn) -> Vec<Folded> {
        let mut folded = [vec![0.0; self.n], vec![0.0; self.n]];
        for &(unknown, value) in column {
            let Place { number, side, sign } = self.place[unknown];
            match side {
                Side::Before => folded.iter_mut().for_each(|f| f[number] += value),
                Side::Behind => {
                    folded[0][number] += sign * value;
                    folded[1][number] -= sign * value;
                }
                Side::OnPlane => folded[usize::from(sign < 0.0)][number] += value,
            }
        }
        let largest = |f: &Vec<f64>| f.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let [even, odd] = [largest(&folded[0]), largest(&folded[1])];
        let least = ROUNDING * even.max(odd);
        let shares = [[1.0, 0.0], [0.0, 1.0]];
        let kept = folded.into_iter().zip(shares).zip([even, odd]);
        kept.filter(|(_, size)| *size > least)
            .map(|((values, shares), _)| Folded {
                column: values
                    .into_iter()
                    .enumerate()
                    .filter(|(_, v)| *v != 0.0)
                    .collect(),
                shares,
            })
            .collect()
    }

    /// Adds to the unknowns of the whole what an even or odd (`shares`) solution of the half makes of them.
    pub(super) fn unfold(&self, half: &[f64], shares: [f64; 2], whole: &mut [f64]) {
        let is_odd = shares[1] != 0.0;
        for (x, place) in whole.iter_mut().zip(&self.place) {
            let value = 0.5 * half[place.number];
            match place.side {
                Side::Before => *x += value,
                Side::Behind if is_odd => *x -= place.sign * value,
                Side::Behind => *x += place.sign * value,
                Side::OnPlane if (place.sign < 0.0) == is_odd => *x += value,
                Side::OnPlane => {}
            }
        }
    }
}

/// Contact points whose loads are mirror images of each other.
pub(super) struct PointImages {
    /// For each point its image, and the sign of each component of a traction on it: the mirror makes of a unit
    /// traction so many units on the image.
    of: Vec<(usize, [f64; 3])>,
}

impl PointImages {
    /// Images of points that the nodes see as in a [`Trace`](super::condense::Trace); `None` if one has none.
    pub(super) fn new(mirror: &Mirror, points: &[PointTrace]) -> Option<Self> {
        let mut by_nodes: HashMap<Vec<usize>, Vec<usize>> = HashMap::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            let nodes = point.iter().map(|&(node, _)| node).collect();
            by_nodes.entry(nodes).or_default().push(i);
        }
        let image = |point: &PointTrace| {
            let seen = point.iter().map(|&(node, part)| {
                let turned = part.map(|e| std::array::from_fn(|k| mirror.sign(k) * e[k]));
                (mirror.image(node), turned)
            });
            let mut seen: PointTrace = seen.collect();
            seen.sort_by_key(|&(node, _)| node);
            let nodes: Vec<usize> = seen.iter().map(|&(node, _)| node).collect();
            let candidates = by_nodes.get(&nodes)?;
            candidates
                .iter()
                .find_map(|&j| Some((j, signs(&seen, &points[j])?)))
        };
        let of = points.iter().map(image).collect::<Option<Vec<_>>>()?;
        let is_inverse = (0..of.len()).all(|i| of[of[i].0] == (i, of[i].1));
        is_inverse.then_some(Self { of })
    }

    /// Whether a point is computed for its image as well.
    pub(super) fn leads(&self, point: usize) -> bool {
        point <= self.of[point].0
    }

    /// Image of a point, and the signs of its components.
    pub(super) fn of(&self, point: usize) -> (usize, [f64; 3]) {
        self.of[point]
    }
}

/// The signs with which the components of a point are those of another one, if they are.
fn signs(seen: &PointTrace, point: &PointTrace) -> Option<[f64; 3]> {
    let sizes = point.iter().flat_map(|(_, part)| part.as_flattened());
    let most = sizes.fold(0.0_f64, |most, v| most.max(v.abs()));
    let agrees = |c: usize, sign: f64| {
        seen.iter().zip(point).all(|((_, a), (_, b))| {
            (0..3).all(|k| (a[c][k] - sign * b[c][k]).abs() <= ALIKE * most)
        })
    };
    let mut found = [1.0; 3];
    for (c, sign) in found.iter_mut().enumerate() {
        *sign = [1.0, -1.0].into_iter().find(|&sign| agrees(c, sign))?;
    }
    Some(found)
}
