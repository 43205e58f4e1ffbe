// SPDX-License-Identifier: MIT OR Apache-2.0
//! Dense matrices of contacts that are their own image in mirrors: in blocks by parity, an even one and an odd one for
//! each mirror, so that a product passes a half or a quarter of the numbers.

use std::ops::{Add, Mul, Sub};

use faer::Mat;
use mtb_operator::Monitor;
use mtb_operator::dense::{Lu, Real};
use mtb_operator::krylov::dot;

use super::inverse::Places;
use super::matrix::threads;
use crate::columns::add_columns;
use crate::error::Error;

/// Largest part of the extent of all points by which the image of a point may miss one.
const MISSED: f64 = 1e-7;

/// Largest part of a product by which it may miss that of the image.
pub(super) const UNEQUAL: f64 = 1e-9;

/// The same where blocks stand for the matrix itself: far below the residual that is asked for.
const ROUNDING: f64 = 1e-13;

/// A mirror under which all points are images of each other.
#[derive(Clone, Debug)]
pub(super) struct Mirror {
    /// The image of each point (n).
    image: Vec<usize>,
    /// What it does to the component along each axis.
    signs: [i32; 3],
}

impl Mirror {
    /// Mirrors across x and across y in the middle of `points` (3n) [m], in whose images there are points.
    pub(super) fn of(points: &[f64]) -> Vec<Self> {
        let n = points.len() / 3;
        let coordinate = |axis: usize| &points[axis * n..(axis + 1) * n];
        let ends = |axis: usize| {
            let of = coordinate(axis).iter();
            of.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| {
                [a.min(*x), b.max(*x)]
            })
        };
        let near = MISSED * (0..3).map(ends).fold(0.0, |m, [a, b]| f64::max(m, b - a));
        // in the order of x, so that few points are looked at for each
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| points[i].total_cmp(&points[j]));
        let find = |place: [f64; 3]| {
            let from = order.partition_point(|&i| points[i] < place[0] - near);
            let within = order[from..]
                .iter()
                .take_while(|&&i| points[i] <= place[0] + near);
            let mut there = within.filter(|&&i| {
                (1..3).all(|axis| (points[axis * n + i] - place[axis]).abs() <= near)
            });
            there.next().copied()
        };
        [[-1, 1, 1], [1, -1, 1]]
            .into_iter()
            .enumerate()
            .filter_map(|(across, signs)| {
                let [first, last] = ends(across);
                let image: Option<Vec<usize>> = (0..n)
                    .map(|i| {
                        let mut place = [0, 1, 2].map(|axis| points[axis * n + i]);
                        place[across] = first + last - place[across];
                        find(place)
                    })
                    .collect();
                image.map(|image| Self { image, signs })
            })
            .collect()
    }

    /// A field of three components (3n) in the mirror.
    fn seen(&self, field: &[f64]) -> Vec<f64> {
        let n = self.image.len();
        let from = |c: usize| {
            self.image
                .iter()
                .map(move |&i| f64::from(self.signs[c]) * field[c * n + i])
        };
        (0..3).flat_map(from).collect()
    }

    /// Whether a matrix (3n, 3n) makes of what is seen in the mirror what is seen in it, tried on one field, but
    /// for an `unequal` part of its product.
    pub(super) fn is_of(&self, unequal: f64, product: impl Fn(&[f64]) -> Vec<f64>) -> bool {
        self.is_of_both(self, unequal, product)
    }

    /// The same of a matrix from fields at these points to fields at those of `other`.
    fn is_of_both(&self, other: &Self, unequal: f64, product: impl Fn(&[f64]) -> Vec<f64>) -> bool {
        let field: Vec<f64> = (0..3 * self.image.len())
            .map(|i| (12.9898 * (i + 1) as f64).sin())
            .collect();
        let (own, seen) = (other.seen(&product(&field)), product(&self.seen(&field)));
        let size = own.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let pairs = own.iter().zip(&seen);
        pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) <= unequal * size
    }

    /// Those of `mirrors` in whose images a set of points (n) is completed, such that products with what belongs to its
    /// points become cheapest.
    pub(super) fn completing(mirrors: &[Self], set: &mut [bool]) -> Vec<Self> {
        let mut best = (set.to_vec(), Vec::new());
        let cost = |set: &[bool], mirrors: usize| {
            let count = set.iter().filter(|is_in| **is_in).count() as f64;
            count * count / f64::powi(2.0, mirrors as i32)
        };
        for choice in 1_usize..1 << mirrors.len() {
            let chosen = mirrors
                .iter()
                .enumerate()
                .filter(|(k, _)| choice >> k & 1 == 1);
            let chosen: Vec<Self> = chosen.map(|(_, mirror)| mirror.clone()).collect();
            let mut all = set.to_vec();
            for mirror in &chosen {
                let seen: Vec<bool> = mirror.image.iter().map(|&i| all[i]).collect();
                all.iter_mut()
                    .zip(seen)
                    .for_each(|(all, seen)| *all |= seen);
            }
            if cost(&all, chosen.len()) < cost(&best.0, best.1.len()) {
                best = (all, chosen);
            }
        }
        set.copy_from_slice(&best.0);
        best.1
    }

    /// The same among some `points` only, which are their own images.
    fn among(&self, points: &[usize]) -> Self {
        let mut place = vec![0; self.image.len()];
        for (k, &i) in points.iter().enumerate() {
            place[i] = k;
        }
        Self {
            image: points.iter().map(|&i| place[self.image[i]]).collect(),
            signs: self.signs,
        }
    }
}

/// Images of a point, itself included, in two mirrors.
const IMAGES: usize = 4;

/// Three components at points and their images in mirrors, from which fields of each parity are made: a sum of the values
/// there, each with a sign.
#[derive(Clone, Debug, Default)]
struct Orbits(Vec<Orbit>);

/// One component at a point and its images.
#[derive(Clone, Copy, Debug)]
struct Orbit {
    /// Where it is: those in the first mirror, then those of both in the second one. What lies on a mirror is there twice.
    places: [u32; IMAGES],
    /// What the mirrors do to it, times what makes fields orthonormal; zero where there are fewer images.
    shares: [f64; IMAGES],
}

impl Orbit {
    /// Whether it has a field of this parity: what turns round in a mirror vanishes on it.
    fn has(&self, parity: usize) -> bool {
        let there = (0..IMAGES).filter(|&k| self.places[k] == self.places[0]);
        there.map(|k| sign(parity, k) * self.shares[k]).sum::<f64>() != 0.0
    }
}

/// Sign of an image in a field of a parity, whose bits say in which mirrors it is odd.
fn sign(parity: usize, image: usize) -> f64 {
    if (parity & image).count_ones().is_multiple_of(2) {
        1.0
    } else {
        -1.0
    }
}

/// Sums of the values at four images, with the signs of each parity; and the same backwards.
fn butterfly<T: Copy + Add<Output = T> + Sub<Output = T>>(
    [a, b, c, d]: [T; IMAGES],
) -> [T; IMAGES] {
    let [even, odd] = [[a + b, c + d], [a - b, c - d]];
    [
        even[0] + even[1],
        odd[0] + odd[1],
        even[0] - even[1],
        odd[0] - odd[1],
    ]
}

impl Orbits {
    /// Of three components at the points of `mirrors`; component c of point i is the entry `place(c, i)`.
    fn new(mirrors: &[Mirror], points: usize, place: impl Fn(usize, usize) -> usize) -> Self {
        let mut orbits = Vec::new();
        for c in 0..3 {
            for point in 0..points {
                let mut images = vec![(point, 1)];
                for mirror in mirrors {
                    let seen: Vec<(usize, i32)> = (images.iter())
                        .map(|(i, v)| (mirror.image[*i], v * mirror.signs[c]))
                        .collect();
                    images.extend(seen);
                }
                if images.iter().any(|(i, _)| *i < point) {
                    continue;
                }
                let times = images.iter().filter(|(i, _)| *i == point).count();
                let size = ((images.len() * times) as f64).sqrt().recip();
                let at = |k: usize| images.get(k).copied().unwrap_or((point, 0));
                orbits.push(Orbit {
                    places: std::array::from_fn(|k| place(c, at(k).0) as u32),
                    shares: std::array::from_fn(|k| size * f64::from(at(k).1)),
                });
            }
        }
        Self(orbits)
    }

    /// With those of other points after its own.
    fn with(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Which of them have a field of a parity.
    fn of(&self, parity: usize) -> Vec<u32> {
        let all = self.0.iter().enumerate();
        let those = all.filter(|(_, orbit)| orbit.has(parity));
        those.map(|(k, _)| k as u32).collect()
    }

    /// Their fields of a parity.
    fn basis(&self, parity: usize) -> Basis {
        let field = |orbit: &Orbit| {
            std::array::from_fn(|k| (orbit.places[k], sign(parity, k) * orbit.shares[k]))
        };
        let those = self.0.iter().filter(|orbit| orbit.has(parity));
        Basis(those.map(field).collect())
    }

    /// What the field of each parity has of a given one.
    fn folded(&self, given: &[f64]) -> Vec<[f64; IMAGES]> {
        let of = |orbit: &Orbit| {
            butterfly([0, 1, 2, 3].map(|k| orbit.shares[k] * given[orbit.places[k] as usize]))
        };
        self.0.iter().map(of).collect()
    }

    /// Adds the fields of each parity, each so many times.
    fn unfold<T: Real + Add<Output = T> + Sub<Output = T> + Mul<Output = T>>(
        &self,
        shares: &[[T; IMAGES]],
        sum: &mut [T],
        of: impl Fn(f64) -> T,
    ) {
        for (orbit, shares) in self.0.iter().zip(shares) {
            let values = butterfly(*shares);
            for k in 0..IMAGES {
                let sum = &mut sum[orbit.places[k] as usize];
                *sum += of(orbit.shares[k]) * values[k];
            }
        }
    }
}

/// Orthonormal fields of one parity: of each, the places of its entries and these.
#[derive(Clone, Debug)]
struct Basis(Vec<[(u32, f64); IMAGES]>);

impl Basis {
    fn len(&self) -> usize {
        self.0.len()
    }

    /// The block of a matrix between these fields, by the numbers of its columns, and those `found`, by its rows.
    fn block(&self, found: &Self, matrix: &Mat<f64>) -> Mat<f64> {
        let mut block = Mat::zeros(found.len(), self.len());
        let mut sum = vec![0.0; matrix.nrows()];
        for (j, field) in self.0.iter().enumerate() {
            sum.fill(0.0);
            let columns: Vec<_> = field
                .iter()
                .map(|(i, share)| (matrix.col_as_slice(*i as usize), *share))
                .collect();
            add_columns(&columns, &mut sum);
            for (entry, v) in block.col_as_slice_mut(j).iter_mut().zip(found.folded(&sum)) {
                *entry = v;
            }
        }
        block
    }

    /// What each field has of a given one.
    fn folded<'a>(&'a self, given: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.0.iter().map(|field| {
            let [a, b, c, d] = field.map(|(i, share)| share * given[i as usize]);
            (a + b) + (c + d)
        })
    }
}

/// The inverse (3k, 3k) of what a compliance (3n, 3n) that is its own image is between the `base` points, by parities.
///
/// # Errors
/// [`Error::Interrupted`].
pub(super) fn inverse(
    compliance: &Mat<f64>,
    base: &[usize],
    mirrors: &[Mirror],
    monitor: Monitor<'_>,
) -> Result<Mat<f64>, Error> {
    let (n, k) = (compliance.nrows() / 3, base.len());
    let inner: Vec<Mirror> = mirrors.iter().map(|mirror| mirror.among(base)).collect();
    let mut inverse = Mat::zeros(3 * k, 3 * k);
    let fields = Orbits::new(&inner, k, |c, i| c * n + base[i]);
    let places = Orbits::new(&inner, k, |c, i| c * k + i);
    for parity in 0..1 << mirrors.len() {
        let (fields, places) = (fields.basis(parity), places.basis(parity));
        let block = fields.block(&fields, compliance);
        let par = threads(block.nrows() * block.ncols());
        let unit: Mat<f64> = Mat::identity(block.nrows(), block.ncols());
        let solved = Lu::new(block, par, monitor)?.solve(unit.as_ref(), par, monitor)?;
        let mut column = vec![0.0; 3 * k];
        for (j, field) in places.0.iter().enumerate() {
            column.fill(0.0);
            for (rows, v) in places.0.iter().zip(solved.col_as_slice(j)) {
                for (i, share) in rows {
                    column[*i as usize] += share * v;
                }
            }
            for (i, share) in field.iter().filter(|(_, share)| *share != 0.0) {
                let sum = inverse.col_as_slice_mut(*i as usize);
                add_columns(&[(column.as_slice(), *share)], sum);
            }
        }
    }
    Ok(inverse)
}

/// A matrix in blocks: what goes from displacements of base points to what is known of them and of other points.
#[derive(Debug)]
pub(super) struct Blocks<T> {
    given: Orbits,
    found: Orbits,
    parities: Vec<Parity<T>>,
    /// Rows (m) that belong to no point, each of all columns.
    single: Vec<(usize, Vec<f64>)>,
}

#[derive(Debug)]
struct Parity<T> {
    /// Which of the orbits have fields of it: its columns and rows.
    given: Vec<u32>,
    found: Vec<u32>,
    block: Mat<T>,
}

impl Blocks<f64> {
    /// Of a compliance (3n, 3n); `None` where it is not its own image in the `mirrors` but for the rounding of products.
    pub(super) fn of(compliance: &Mat<f64>, mirrors: &[Mirror]) -> Option<Self> {
        let all: Vec<usize> = (0..compliance.nrows() / 3).collect();
        let places = Places {
            base: &all,
            outside: &[],
            motions: 0,
        };
        Self::new(compliance, &places, mirrors, ROUNDING)
    }

    /// Of the columns of base points of a `response`, whose entries `places` tell; `None` where it is not its own image in
    /// the mirrors, but for an `unequal` part of a product.
    pub(super) fn new(
        response: &Mat<f64>,
        places: &Places<'_>,
        mirrors: &[Mirror],
        unequal: f64,
    ) -> Option<Self> {
        let Places {
            base,
            outside,
            motions,
        } = places;
        let (k, o) = (base.len(), outside.len());
        let among = |points: &[usize]| -> Vec<Mirror> {
            mirrors.iter().map(|mirror| mirror.among(points)).collect()
        };
        let (inner, outer) = (among(base), among(outside));
        let product = |given: &[f64]| {
            let mut sum = vec![0.0; response.nrows()];
            let columns: Vec<_> = given
                .iter()
                .enumerate()
                .map(|(j, v)| (response.col_as_slice(j), *v))
                .collect();
            add_columns(&columns, &mut sum);
            sum
        };
        let is_own_image = inner.iter().zip(&outer).all(|(inner, outer)| {
            inner.is_of(unequal, |given| product(given)[..3 * k].to_vec())
                && inner.is_of_both(outer, unequal, |given| {
                    product(given).split_off(3 * k + motions)
                })
        });
        if !is_own_image {
            return None;
        }
        let given = Orbits::new(&inner, k, |c, i| c * k + i);
        let beyond = Orbits::new(&outer, o, |c, i| 3 * k + motions + c * o + i);
        let found = given.clone().with(beyond);
        let parities = (0..1 << mirrors.len())
            .map(|parity| Parity {
                given: given.of(parity),
                found: found.of(parity),
                block: given.basis(parity).block(&found.basis(parity), response),
            })
            .collect();
        let single = (3 * k..3 * k + motions)
            .map(|row| {
                (
                    row,
                    (0..3 * k).map(|column| response[(row, column)]).collect(),
                )
            })
            .collect();
        Some(Self {
            given,
            found,
            parities,
            single,
        })
    }

    /// The same in single precision.
    pub(super) fn rough(&self) -> Blocks<f32> {
        let parities = self.parities.iter().map(
            |Parity {
                 given,
                 found,
                 block,
             }| Parity {
                given: given.clone(),
                found: found.clone(),
                block: Mat::from_fn(block.nrows(), block.ncols(), |i, j| block[(i, j)] as f32),
            },
        );
        Blocks {
            given: self.given.clone(),
            found: self.found.clone(),
            parities: parities.collect(),
            single: self.single.clone(),
        }
    }

    /// Adds the answer to displacements of the base points (3k) to `sum`.
    pub(super) fn add(&self, given: &[f64], sum: &mut [f64]) {
        self.add_as(given, sum, |v| v);
    }
}

impl Blocks<f32> {
    /// Adds the answer to displacements of the base points (3k) to `sum`.
    pub(super) fn add(&self, given: &[f64], sum: &mut [f32]) {
        self.add_as(given, sum, |v| v as f32);
    }
}

impl<T: Real + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Blocks<T> {
    fn add_as(&self, given: &[f64], sum: &mut [T], of: impl Fn(f64) -> T) {
        let folded = self.given.folded(given);
        let mut answers = vec![[of(0.0); IMAGES]; self.found.0.len()];
        let (mut columns, mut answer) = (Vec::new(), Vec::new());
        for (k, parity) in self.parities.iter().enumerate() {
            let Parity {
                given,
                found,
                block,
            } = parity;
            columns.clear();
            for (j, orbit) in given.iter().enumerate() {
                let v = folded[*orbit as usize][k];
                if v != 0.0 {
                    columns.push((block.col_as_slice(j), of(v)));
                }
            }
            answer.clear();
            answer.resize(block.nrows(), of(0.0));
            add_columns(&columns, &mut answer);
            for (orbit, answer) in found.iter().zip(&answer) {
                answers[*orbit as usize][k] = *answer;
            }
        }
        self.found.unfold(&answers, sum, &of);
        for (row, shares) in &self.single {
            sum[*row] += of(dot(shares, given));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Grid points (3n) about a place, of which those of one corner may be missing.
    fn grid(nx: usize, ny: usize, is_whole: bool) -> Vec<f64> {
        let last = nx * ny - usize::from(!is_whole);
        let mut points: Vec<f64> = (0..last).map(|i| 0.3 + 0.1 * (i % nx) as f64).collect();
        points.extend((0..last).map(|i| 0.2 * (i / nx) as f64 - 0.7));
        points.extend((0..last).map(|i| ((i % nx) as f64 - 0.5 * (nx as f64 - 1.0)).powi(2)));
        points
    }

    fn product(matrix: &Mat<f64>, given: &[f64]) -> Vec<f64> {
        let row = |i| {
            given
                .iter()
                .enumerate()
                .map(|(j, v)| matrix[(i, j)] * v)
                .sum()
        };
        (0..matrix.nrows()).map(row).collect()
    }

    proptest! {
        #[test]
        fn products_by_blocks_are_those_of_the_matrix(
            nx in 1..6_usize,
            ny in 1..6_usize,
            motions in 0..3_usize,
            numbers in prop::collection::vec(-1.0..1.0_f64, 200..400),
            in_base in prop::collection::vec(any::<bool>(), 40),
            is_own_image in any::<bool>(),
        ) {
            let points = grid(nx, ny, true);
            let n = nx * ny;
            let mirrors = Mirror::of(&points);
            prop_assert_eq!(mirrors.len(), 2);
            let mut set = in_base[..n].to_vec();
            set[0] = true;
            let chosen = Mirror::completing(&mirrors, &mut set);
            let base: Vec<usize> = (0..n).filter(|&i| set[i]).collect();
            let outside: Vec<usize> = (0..n).filter(|&i| !set[i]).collect();
            let (k, o) = (base.len(), outside.len());
            for mirror in &chosen {
                prop_assert!(base.iter().all(|&i| set[mirror.image[i]]));
            }
            // random, then the mean over all images
            let at = |i: usize, j: usize| numbers[(31 * i + 17 * j + i * j) % numbers.len()];
            let mut response = Mat::from_fn(3 * (k + o) + motions, 3 * k + motions, at);
            let places = Places { base: &base, outside: &outside, motions };
            if is_own_image {
                for mirror in &chosen {
                    let (inner, outer) = (mirror.among(&base), mirror.among(&outside));
                    let columns: Vec<Vec<f64>> = (0..3 * k)
                        .map(|j| {
                            let mut unit = vec![0.0; 3 * k];
                            unit[j] = 1.0;
                            let mut given = inner.seen(&unit);
                            given.resize(3 * k + motions, 0.0);
                            let found = product(&response, &given);
                            let mut seen = inner.seen(&found[..3 * k]);
                            seen.extend(&found[3 * k..3 * k + motions]);
                            seen.extend(outer.seen(&found[3 * k + motions..]));
                            seen
                        })
                        .collect();
                    for (j, column) in columns.iter().enumerate() {
                        for (i, v) in column.iter().enumerate() {
                            if !(3 * k..3 * k + motions).contains(&i) {
                                response[(i, j)] = 0.5 * (response[(i, j)] + v);
                            }
                        }
                    }
                }
            }
            prop_assume!(!chosen.is_empty());
            let Some(blocks) = Blocks::new(&response, &places, &chosen, UNEQUAL) else {
                prop_assert!(!is_own_image);
                return Ok(());
            };
            let given: Vec<f64> = (0..3 * k).map(|i| numbers[(7 * i) % numbers.len()]).collect();
            let mut whole = given.clone();
            whole.resize(3 * k + motions, 0.0);
            let exact = product(&response, &whole);
            let (mut sum, mut rough) = (vec![1.0; exact.len()], vec![1.0_f32; exact.len()]);
            blocks.add(&given, &mut sum);
            blocks.rough().add(&given, &mut rough);
            for ((exact, sum), rough) in exact.iter().zip(sum).zip(rough) {
                prop_assert!((1.0 + exact - sum).abs() < 1e-12 * (3 * k) as f64);
                prop_assert!((1.0 + exact - f64::from(rough)).abs() < 1e-5 * (3 * k) as f64);
            }
        }
    }

    #[test]
    fn points_without_images_have_no_mirrors() {
        assert!(Mirror::of(&grid(4, 3, false)).is_empty());
        let mut points = grid(4, 3, true);
        // one point a little aside along y: the mirror across x still has an image of it, that across y has none
        points[12 + 1] += 1e-4;
        points[12 + 2] += 1e-4;
        let left = Mirror::of(&points);
        assert_eq!(left.len(), 1);
        assert_eq!(left[0].signs, [-1, 1, 1]);
    }

    #[test]
    fn a_set_that_its_images_make_much_larger_stays_as_it_is() {
        let mirrors = Mirror::of(&grid(8, 2, true));
        // the left half: the mirror across y costs nothing, that across x would double it
        let mut set: Vec<bool> = (0..16).map(|i| i % 8 < 4).collect();
        let before = set.clone();
        let chosen = Mirror::completing(&mirrors, &mut set);
        assert_eq!(set, before);
        assert_eq!(chosen.len(), 1);
        assert_eq!(chosen[0].signs, [1, -1, 1]);
    }
}
