// SPDX-License-Identifier: MIT OR Apache-2.0
//! Slip of second order: that of the cells out of differences over their faces.

use mtb_complementarity::discs::{DependentRadius, Preconditioner};
use mtb_operator::{Grid, LinearOperator};

use super::given::neighbour;

/// Pressure over that of the next cell from which on a cell counts as in contact to its end. From 0.25 to 0.7 errors are
/// alike; the larger, the less they depend on where the edge lies within its cell.
const WHOLE: f64 = 0.5;

/// Pressure over that of the cell behind from which on a first cell is less tied, and from which on not at all: a face
/// whose cells carry alike does not slip by what they carry, and of rows of two cells it would be the only one.
const BLUNT: [f64; 2] = [1.0, 0.75];

/// Slip of second order in the cells along the rolling direction.
///
/// The difference of displacements over one cell is the slip halfway, at the face between two cells, where it is of second
/// order. Two changes to a scheme that takes it for that of the cell behind make the whole of second order:
///
/// * The slip of a cell is continued to its middle from its leading face and the one ahead, `(3 F(x + d/2) - F(x + 3d/2)) / 2`.
///   Where both stick, so does the cell; where it slips, its traction points along the slip of its own place.
/// * The leading face of the first cell of a row lies at the edge of contact or beyond. In place of a condition there, its
///   traction is to that of the cell behind it as their pressures are, `q = p/p' q'`: both fall with the root of the
///   distance to the edge, wherever it lies within the cell. Where a layer is softer than the cell is wide the traction
///   falls with the distance itself, and `q = (p/p')^(1 + s) q'`, with the share `s` of the layer in what a traction
///   slips at its own leading face.
///
/// Cells come into contact with no pressure, and everything is continuous in it. With `a` and `b`, from 0 to 1 as the
/// pressure ahead and behind grows from none to [`WHOLE`] of the cell's own, a cell is tied to the one behind it by
/// `t = (1 - a) b`, and its image is `(1 - t) (F + a a' (F - F') / 2) + t k (q - p/p' q')`, with `F'` and `a'` of the cell
/// ahead and a stiffness `k`. What a tied cell slips it slips with the one behind it.
pub(super) struct Faces {
    n: usize,
    /// Cells in contact, those behind first.
    rows: Vec<Row>,
    /// `k`, in the unit of the operator.
    stiffness: f64,
    layer: LayerShare,
}

/// How much of what a traction slips at its own leading face is that of a layer, from 0 to 1, and its derivatives by the
/// stiffness over itself, and by the layer [Pa/m].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LayerShare {
    pub(super) value: f64,
    pub(super) by_stiffness: f64,
    pub(super) by_layer: f64,
}

struct Row {
    cell: usize,
    /// The cells beside it; itself where they are not in contact.
    ahead: usize,
    behind: usize,
    /// `t`, `a a' / 2`, and `p/p'`.
    tie: Linear,
    extension: Linear,
    share: Linear,
    ratio: f64,
}

impl Row {
    /// Whether its cell is tied by more than half.
    fn is_tied(&self) -> bool {
        self.tie.value > 0.5
    }
}

/// A number and its derivatives by pressures.
#[derive(Clone, Default)]
struct Linear {
    value: f64,
    by: Vec<(usize, f64)>,
}

impl Linear {
    /// The quotient of pressures `p_i / p_k`.
    fn quotient(pressure: &[f64], i: usize, k: usize) -> Self {
        let value = pressure[i] / pressure[k];
        let by = vec![(i, 1.0 / pressure[k]), (k, -value / pressure[k])];
        Self { value, by }
    }

    /// From 0 to 1 as it goes from one number to another.
    fn between(&self, [none, all]: [f64; 2]) -> Self {
        let t = ((self.value - none) / (all - none)).clamp(0.0, 1.0);
        let slope = 6.0 * t * (1.0 - t) / (all - none);
        // pressures next to nothing have quotients and slopes beyond all numbers, where it is 0 or 1
        let slopes = self.by.iter().filter(|_| slope != 0.0);
        Self {
            value: t * t * (3.0 - 2.0 * t),
            by: slopes.map(|(k, v)| (*k, slope * v)).collect(),
        }
    }

    fn power(&self, exponent: f64) -> Self {
        let value = self.value.powf(exponent);
        let slope = exponent * self.value.powf(exponent - 1.0);
        let by = self.by.iter().map(|(k, v)| (*k, slope * v)).collect();
        Self { value, by }
    }

    fn less_than_one(&self) -> Self {
        Self {
            value: 1.0 - self.value,
            by: self.by.iter().map(|(k, v)| (*k, -v)).collect(),
        }
    }

    fn times(&self, other: &Self, factor: f64) -> Self {
        let own = self.by.iter().map(|(k, v)| (*k, factor * v * other.value));
        let others = other.by.iter().map(|(k, v)| (*k, factor * v * self.value));
        Self {
            value: factor * self.value * other.value,
            by: own.chain(others).filter(|(_, v)| *v != 0.0).collect(),
        }
    }

    fn change(&self, pressure: &[f64]) -> f64 {
        self.by.iter().map(|(k, v)| v * pressure[*k]).sum()
    }

    fn add_back(&self, weight: f64, pressure: &mut [f64]) {
        for (k, v) in &self.by {
            pressure[*k] += weight * v;
        }
    }
}

impl Faces {
    /// Of the cells under a pressure (n), for steps along x or y, whichever goes farther.
    pub(super) fn new(
        grid: &Grid,
        step: [f64; 2],
        pressure: &[f64],
        stiffness: f64,
        layer: LayerShare,
    ) -> Self {
        let [x, y] = step;
        let is_along_x = x.abs() >= y.abs();
        let is_backwards = (if is_along_x { x } else { y }) < 0.0;
        let beside = |cell: usize, by: isize| -> Option<usize> {
            let by = if is_backwards { -by } else { by };
            let d = if is_along_x { [by, 0] } else { [0, by] };
            neighbour(grid, cell, d).filter(|k| pressure[*k] > 0.0)
        };
        let whole = |i: Option<usize>, k: usize| {
            i.map_or_else(Linear::default, |i| {
                Linear::quotient(pressure, i, k).between([0.0, WHOLE])
            })
        };
        let touching = (0..grid.points()).filter(|k| pressure[*k] > 0.0);
        let mut rows: Vec<Row> = touching
            .map(|cell| {
                let (ahead, behind) = (beside(cell, 1), beside(cell, -1));
                let own = whole(ahead, cell);
                let next = ahead.map_or_else(Linear::default, |ahead| {
                    let farther = beside(cell, 2);
                    whole(farther, ahead)
                });
                let ratio = behind.map_or_else(Linear::default, |behind| {
                    Linear::quotient(pressure, cell, behind)
                });
                let is_edge = behind.map_or_else(Linear::default, |_| ratio.between(BLUNT));
                let share = if is_edge.value > 0.0 {
                    ratio.power(1.0 + layer.value)
                } else {
                    Linear::default()
                };
                Row {
                    cell,
                    ahead: ahead.unwrap_or(cell),
                    behind: behind.unwrap_or(cell),
                    tie: own.less_than_one().times(&is_edge, 1.0),
                    extension: own.times(&next, 0.5),
                    share,
                    ratio: ratio.value,
                }
            })
            .collect();
        if is_backwards {
            rows.reverse();
        }
        Self {
            n: grid.points(),
            rows,
            stiffness,
            layer,
        }
    }

    /// Takes images (2n) at faces to those of the cells, as far as they are not tied.
    pub(super) fn to_cells(&self, image: &mut [f64]) {
        for part in image.chunks_exact_mut(self.n) {
            for row in &self.rows {
                let more = row.extension.value * (part[row.cell] - part[row.ahead]);
                part[row.cell] = (1.0 - row.tie.value) * (part[row.cell] + more);
            }
        }
    }

    /// The transpose of [`Faces::to_cells`].
    pub(super) fn to_faces(&self, weights: &mut [f64]) {
        for part in weights.chunks_exact_mut(self.n) {
            for row in self.rows.iter().rev() {
                let weight = (1.0 - row.tie.value) * part[row.cell];
                let more = row.extension.value * weight;
                part[row.cell] = weight + more;
                part[row.ahead] -= more;
            }
        }
    }

    /// What ties have of a traction (2n).
    pub(super) fn add_ties(&self, traction: &[f64], image: &mut [f64]) {
        for c in [0, self.n] {
            for row in &self.rows {
                let apart = traction[c + row.cell] - row.share.value * traction[c + row.behind];
                image[c + row.cell] += row.tie.value * self.stiffness * apart;
            }
        }
    }

    /// Derivatives of images (2n) of a traction (2n) by the length of a step over itself, by the stiffness of the ties over
    /// itself, and by the layer.
    pub(super) fn by_constants(&self, traction: &[f64]) -> [Vec<f64>; 3] {
        let mut by_length = vec![0.0; traction.len()];
        self.add_ties(traction, &mut by_length);
        let mut by_stiffness = by_length.clone();
        let mut by_layer = vec![0.0; traction.len()];
        for row in self.rows.iter().filter(|row| row.tie.value > 0.0) {
            let by_share = -row.tie.value * self.stiffness * row.share.value * row.ratio.ln();
            for c in [0, self.n] {
                let by_share = by_share * traction[c + row.behind];
                by_stiffness[c + row.cell] += self.layer.by_stiffness * by_share;
                by_layer[c + row.cell] = self.layer.by_layer * by_share;
            }
        }
        [by_length, by_stiffness, by_layer]
    }

    /// The transpose of [`Faces::add_ties`].
    fn add_ties_back(&self, weights: &[f64], traction: &mut [f64]) {
        for c in [0, self.n] {
            for row in &self.rows {
                let weight = row.tie.value * self.stiffness * weights[c + row.cell];
                traction[c + row.cell] += weight;
                traction[c + row.behind] -= row.share.value * weight;
            }
        }
    }

    /// Derivatives of the image of a cell, at its component `c`, by its tie, its extension and its share.
    fn by_numbers(&self, row: &Row, c: usize, at: &AtFaces<'_>) -> [f64; 3] {
        let own = at.image[c + row.cell];
        let apart = own - at.image[c + row.ahead];
        let (q, behind) = (at.traction[c + row.cell], at.traction[c + row.behind]);
        let tied = self.stiffness * (q - row.share.value * behind);
        [
            tied - own - row.extension.value * apart,
            (1.0 - row.tie.value) * apart,
            -row.tie.value * self.stiffness * behind,
        ]
    }

    /// Adds what a change of the pressure (n) does to images (2n) of cells through its ties and extensions.
    pub(super) fn add_by_pressure(&self, at: &AtFaces<'_>, change: &[f64], image: &mut [f64]) {
        for row in &self.rows {
            let by = [&row.tie, &row.extension, &row.share].map(|number| number.change(change));
            for c in [0, self.n] {
                let slopes = self.by_numbers(row, c, at);
                image[c + row.cell] += slopes.iter().zip(by).map(|(s, b)| s * b).sum::<f64>();
            }
        }
    }

    /// The transpose of [`Faces::add_by_pressure`].
    pub(super) fn add_to_pressure(&self, at: &AtFaces<'_>, weights: &[f64], change: &mut [f64]) {
        for row in &self.rows {
            let mut of_numbers = [0.0; 3];
            for c in [0, self.n] {
                let slopes = self.by_numbers(row, c, at);
                for (of, slope) in of_numbers.iter_mut().zip(slopes) {
                    *of += weights[c + row.cell] * slope;
                }
            }
            for (number, weight) in [&row.tie, &row.extension, &row.share]
                .into_iter()
                .zip(of_numbers)
            {
                number.add_back(weight, change);
            }
        }
    }

    /// Whether a cell slips or sticks with the one behind it: takes values (n) of those.
    pub(super) fn follow<T: Copy>(&self, values: &mut [T]) {
        for row in self.rows.iter().filter(|row| row.is_tied()) {
            values[row.cell] = values[row.behind];
        }
    }

    /// Adds to values (n, or 2n) of cells those of the cells behind them that they are tied to.
    pub(super) fn lead(&self, values: &mut [f64]) {
        for part in values.chunks_exact_mut(self.n) {
            for row in self.rows.iter().filter(|row| row.tie.value > 0.0) {
                part[row.cell] += row.tie.value * part[row.behind];
            }
        }
    }

    /// The transpose of [`Faces::lead`].
    pub(super) fn lead_back(&self, weights: &mut [f64]) {
        for part in weights.chunks_exact_mut(self.n) {
            for row in self.rows.iter().rev().filter(|row| row.tie.value > 0.0) {
                part[row.behind] += row.tie.value * part[row.cell];
            }
        }
    }

    /// What a change of the pressure (n) adds to values (n, or 2n) before they are led, with those that were led.
    pub(super) fn lead_by_pressure(&self, led: &[f64], change: &[f64], values: &mut [f64]) {
        for (part, led) in values
            .chunks_exact_mut(self.n)
            .zip(led.chunks_exact(self.n))
        {
            for row in &self.rows {
                part[row.cell] += row.tie.change(change) * led[row.behind];
            }
        }
    }

    /// The transpose of [`Faces::lead_by_pressure`].
    pub(super) fn lead_to_pressure(&self, led: &[f64], weights: &[f64], change: &mut [f64]) {
        for (part, led) in weights.chunks_exact(self.n).zip(led.chunks_exact(self.n)) {
            for row in &self.rows {
                row.tie.add_back(part[row.cell] * led[row.behind], change);
            }
        }
    }
}

/// Where derivatives are taken: traction and image at faces, (2n).
pub(super) struct AtFaces<'a> {
    pub(super) traction: &'a [f64],
    pub(super) image: &'a [f64],
}

/// Bounds that follow the slip of the cells, where tied cells slip like those behind them.
pub(super) struct LedRadius<'a> {
    pub(super) faces: &'a Faces,
    pub(super) law: &'a dyn DependentRadius,
}

impl LedRadius<'_> {
    fn led(&self, values: &[f64]) -> Vec<f64> {
        let mut led = values.to_vec();
        self.faces.lead(&mut led);
        led
    }
}

impl DependentRadius for LedRadius<'_> {
    fn radius(&self, magnitude: &[f64], radius: &mut [f64]) {
        self.law.radius(&self.led(magnitude), radius);
    }

    fn derivative(&self, magnitude: &[f64], change: &[f64], derivative: &mut [f64]) {
        (self.law).derivative(&self.led(magnitude), &self.led(change), derivative);
    }

    fn derivative_transposed(&self, magnitude: &[f64], weight: &[f64], derivative: &mut [f64]) {
        (self.law).derivative_transposed(&self.led(magnitude), weight, derivative);
        self.faces.lead_back(derivative);
    }
}

/// An operator of slips at faces as one of those of cells.
pub(super) struct OnCells<'a> {
    pub(super) faces: &'a Faces,
    pub(super) operator: &'a dyn LinearOperator,
}

impl LinearOperator for OnCells<'_> {
    fn dim(&self) -> usize {
        self.operator.dim()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.operator.apply(x, y);
        self.faces.to_cells(y);
        self.faces.add_ties(x, y);
    }
}

/// The transpose of [`OnCells`], of the transpose of its operator.
pub(super) struct OnCellsBack<'a> {
    pub(super) faces: &'a Faces,
    pub(super) operator: &'a dyn LinearOperator,
}

impl LinearOperator for OnCellsBack<'_> {
    fn dim(&self) -> usize {
        self.operator.dim()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let mut at_faces = x.to_vec();
        self.faces.to_faces(&mut at_faces);
        self.operator.apply(&at_faces, y);
        self.faces.add_ties_back(x, y);
    }
}

/// A rough inverse of [`OnCells`], by one of its operator: cells count as tied or not, and at faces of those that are there
/// is no slip.
pub(super) struct OnCellsInverse<'a> {
    pub(super) faces: &'a Faces,
    pub(super) inverse: &'a dyn Preconditioner,
}

impl Preconditioner for OnCellsInverse<'_> {
    fn dim(&self) -> usize {
        self.inverse.dim()
    }

    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]) {
        let Faces {
            n, rows, stiffness, ..
        } = self.faces;
        let mut slip = y.to_vec();
        for part in slip.chunks_exact_mut(*n) {
            for row in rows.iter().filter(|row| row.is_tied()) {
                part[row.cell] = 0.0;
            }
            for row in rows.iter().rev().filter(|row| !row.is_tied()) {
                let more = row.extension.value;
                part[row.cell] = (part[row.cell] + more * part[row.ahead]) / (1.0 + more);
            }
        }
        self.inverse.invert(curvature, &slip, x);
        for c in [0, *n] {
            for row in rows.iter().filter(|row| row.is_tied()) {
                let alone = y[c + row.cell] / (row.tie.value * stiffness);
                x[c + row.cell] = row.share.value * x[c + row.behind] + alone;
            }
        }
    }
}

/// The transpose of [`OnCellsInverse`], by the transpose of its inverse.
pub(super) struct OnCellsInverseBack<'a> {
    pub(super) faces: &'a Faces,
    pub(super) inverse: &'a dyn Preconditioner,
}

impl Preconditioner for OnCellsInverseBack<'_> {
    fn dim(&self) -> usize {
        self.inverse.dim()
    }

    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]) {
        let Faces {
            n, rows, stiffness, ..
        } = self.faces;
        let mut weights = y.to_vec();
        let mut alone = vec![0.0; y.len()];
        for (c, part) in [0, *n].into_iter().zip(weights.chunks_exact_mut(*n)) {
            for row in rows.iter().rev().filter(|row| row.is_tied()) {
                let weight = std::mem::take(&mut part[row.cell]);
                part[row.behind] += row.share.value * weight;
                alone[c + row.cell] = weight / (row.tie.value * stiffness);
            }
        }
        self.inverse.invert(curvature, &weights, x);
        for (c, part) in [0, *n].into_iter().zip(x.chunks_exact_mut(*n)) {
            for row in rows.iter().filter(|row| !row.is_tied()) {
                let more = row.extension.value;
                part[row.cell] /= 1.0 + more;
                // itself where there is no extension
                part[row.ahead] += more * part[row.cell];
            }
            for row in rows.iter().filter(|row| row.is_tied()) {
                part[row.cell] = alone[c + row.cell];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid {
        nx: 6,
        ny: 4,
        dx: 1.0,
        dy: 1.0,
    };

    const HALF: LayerShare = LayerShare {
        value: 0.5,
        by_stiffness: 0.0,
        by_layer: 0.0,
    };

    struct Dense(Vec<f64>);

    impl LinearOperator for Dense {
        fn dim(&self) -> usize {
            2 * GRID.points()
        }

        fn apply(&self, x: &[f64], y: &mut [f64]) {
            for (y, row) in y.iter_mut().zip(self.0.chunks_exact(x.len())) {
                *y = row.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        }
    }

    fn transposed(a: &Dense) -> Dense {
        let n = LinearOperator::dim(a);
        Dense((0..n * n).map(|k| a.0[k % n * n + k / n]).collect())
    }

    fn noise(count: usize, seed: usize) -> Vec<f64> {
        (0..count)
            .map(|k| (12.9898 * (k + 97 * seed) as f64).sin() + 0.1)
            .collect()
    }

    /// Rows of five, two, one and three cells with a gap.
    fn pressure() -> Vec<f64> {
        let touches = "011111 001100 010000 110111";
        let touches = touches.bytes().filter(|b| *b != b' ');
        let pressure = touches.zip(noise(24, 3)).map(|(b, v)| match b {
            b'1' => (3.0 * v).exp(),
            _ => 0.0,
        });
        pressure.collect()
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn transposes_are_transposes() {
        let n = 2 * GRID.points();
        let forth = Dense(noise(n * n, 1));
        let back = transposed(&forth);
        for step in [[1.0, 0.0], [-1.0, 0.1], [0.0, 1.0], [0.0, -1.0]] {
            let faces = Faces::new(&GRID, step, &pressure(), 2.5, HALF);
            let (x, w) = (noise(n, 5), noise(n, 6));
            let (mut y, mut z) = (vec![0.0; n], vec![0.0; n]);
            let (faces, operator) = (&faces, &forth as &dyn LinearOperator);
            OnCells { faces, operator }.apply(&x, &mut y);
            let operator = &back as &dyn LinearOperator;
            OnCellsBack { faces, operator }.apply(&w, &mut z);
            assert!((dot(&w, &y) - dot(&z, &x)).abs() < 1e-11);
            let inverse = &forth as &dyn Preconditioner;
            OnCellsInverse { faces, inverse }.invert(&[], &x, &mut y);
            let inverse = &back as &dyn Preconditioner;
            OnCellsInverseBack { faces, inverse }.invert(&[], &w, &mut z);
            assert!((dot(&w, &y) - dot(&z, &x)).abs() < 1e-11);
            let (mut led, mut back) = (x.clone(), w.clone());
            faces.lead(&mut led);
            faces.lead_back(&mut back);
            assert!((dot(&w, &led) - dot(&back, &x)).abs() < 1e-11);
            let change = noise(GRID.points(), 7);
            let (mut image, mut by) = (vec![0.0; n], vec![0.0; GRID.points()]);
            let (traction, led) = (&x, &led);
            let at = AtFaces {
                traction,
                image: &w,
            };
            faces.add_by_pressure(&at, &change, &mut image);
            faces.add_to_pressure(&at, &w, &mut by);
            faces.lead_by_pressure(led, &change, &mut image);
            faces.lead_to_pressure(led, &w, &mut by);
            assert!((dot(&w, &image) - dot(&by, &change)).abs() < 1e-11);
        }
    }

    #[test]
    fn derivatives_by_the_pressure_are_differences() {
        let n = 2 * GRID.points();
        let (forth, x) = (Dense(noise(n * n, 1)), noise(n, 5));
        let change = noise(GRID.points(), 7);
        let h = 1e-6;
        let moved = |by: f64| {
            let pressure: Vec<f64> = (pressure().iter().zip(&change))
                .map(|(p, d)| if *p > 0.0 { p + by * d } else { 0.0 })
                .collect();
            let faces = Faces::new(&GRID, [-1.0, 0.0], &pressure, 2.5, HALF);
            let (mut y, mut led) = (vec![0.0; n], x.clone());
            let (faces, operator) = (&faces, &forth as &dyn LinearOperator);
            OnCells { faces, operator }.apply(&x, &mut y);
            faces.lead(&mut led);
            (y, led)
        };
        let faces = Faces::new(&GRID, [-1.0, 0.0], &pressure(), 2.5, HALF);
        assert!((faces.rows.iter()).any(|row| row.tie.value > 0.0 && row.tie.value < 1.0));
        let mut at_faces = vec![0.0; n];
        forth.apply(&x, &mut at_faces);
        let (mut by, mut by_led) = (vec![0.0; n], vec![0.0; n]);
        let (traction, image) = (&x[..], &at_faces[..]);
        faces.add_by_pressure(&AtFaces { traction, image }, &change, &mut by);
        let (_, led) = moved(0.0);
        faces.lead_by_pressure(&led, &change, &mut by_led);
        faces.lead(&mut by_led);
        let (above, below) = (moved(h), moved(-h));
        for k in 0..n {
            assert!((by[k] - (above.0[k] - below.0[k]) / (2.0 * h)).abs() < 1e-6);
            assert!((by_led[k] - (above.1[k] - below.1[k]) / (2.0 * h)).abs() < 1e-6);
        }
    }

    #[test]
    fn slip_is_that_of_the_middles_and_ties_grow_from_nothing() {
        for step in [1.0, -1.0] {
            let at = |k: usize, ahead: f64| 2.0 + 0.3 * ((k % GRID.nx) as f64 + ahead * step);
            let of = |pressure: &[f64]| Faces::new(&GRID, [step, 0.0], pressure, 1.0, HALF);
            // all alike, but where rows end
            let touches = pressure();
            let is_inside = |k: usize| !k.is_multiple_of(GRID.nx) && k % GRID.nx < GRID.nx - 1;
            let even: Vec<f64> = (0..touches.len())
                .map(|k| match touches[k] {
                    p if p <= 0.0 => 0.0,
                    _ if is_inside(k) && touches[k - 1] > 0.0 && touches[k + 1] > 0.0 => 1.0,
                    _ => 0.55,
                })
                .collect();
            let faces = of(&even);
            let mut slip: Vec<f64> = (0..48).map(|k| at(k % 24, 0.5)).collect();
            faces.to_cells(&mut slip);
            let rows: Vec<&Row> = (faces.rows.iter())
                .filter(|row| row.extension.value > 0.0)
                .collect();
            for row in &rows {
                assert!((slip[row.cell] - at(row.cell, 0.0)).abs() < 1e-12);
            }
            // five cells have three between the first two and the end, three cells one; rows of one cell none
            assert_eq!(rows.len(), 3 + 1);
            // rows of two cells that carry alike have none
            let tied = faces.rows.iter().filter(|row| row.tie.value > 0.0);
            assert_eq!(tied.count(), 2);
            // one more cell in contact, with next to no pressure
            for cell in [0, 6, 20] {
                let mut more = even.clone();
                more[cell] = 1e-9;
                let (x, mut few, mut many) = (noise(48, 2), vec![0.0; 48], vec![0.0; 48]);
                let mut x = x;
                (x[cell], x[24 + cell]) = (0.0, 0.0);
                for (faces, y) in [(&faces, &mut few), (&of(&more), &mut many)] {
                    let mut image = noise(48, 3);
                    faces.to_cells(&mut image);
                    faces.add_ties(&x, &mut image);
                    (image[cell], image[24 + cell]) = (0.0, 0.0);
                    *y = image;
                }
                for (a, b) in few.iter().zip(&many) {
                    assert!((a - b).abs() < 1e-7);
                }
            }
        }
    }
}
