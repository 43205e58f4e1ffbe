// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums over the points that may be in contact, in eight interleaved parts, which keeps them fast and their
//! rounding small.

use std::ops::Range;

const PARTS: usize = 8;

/// Points that are taken or left out together.
const STRETCH: usize = 64;

/// Stretches of points that hold a set.
pub(super) struct Spans(Vec<Range<usize>>);

impl Spans {
    pub(super) fn whole(n: usize) -> Self {
        Self(std::iter::once(0..n).collect())
    }

    /// The stretches that hold `set`.
    pub(super) fn of(set: &[bool]) -> Self {
        let mut spans: Vec<Range<usize>> = Vec::new();
        for (k, stretch) in set.chunks(STRETCH).enumerate() {
            if !stretch.contains(&true) {
                continue;
            }
            let (from, to) = (k * STRETCH, k * STRETCH + stretch.len());
            match spans.last_mut() {
                Some(last) if last.end == from => last.end = to,
                _ => spans.push(from..to),
            }
        }
        Self(spans)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Range<usize>> {
        self.0.iter().cloned()
    }

    /// Number of points in `set`.
    pub(super) fn count(&self, set: &[bool]) -> usize {
        self.iter()
            .map(|span| set[span].iter().filter(|c| **c).count())
            .sum()
    }

    /// `a . b`
    pub(super) fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        self.iter()
            .map(|span| dot(&a[span.clone()], &b[span]))
            .sum()
    }

    /// `a . b` over the points of a set.
    pub(super) fn dot_in(&self, a: &[f64], b: &[f64], set: &[bool]) -> f64 {
        self.iter()
            .map(|span| dot_in(&a[span.clone()], &b[span.clone()], &set[span]))
            .sum()
    }

    /// Sums of `p n`, `|p n|` and `p n^2`.
    pub(super) fn first_moments(&self, p: &[f64], n: &[f64]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for span in self.iter() {
            let part = first_moments(&p[span.clone()], &n[span]);
            for (sum, part) in sums.iter_mut().zip(part) {
                *sum += part;
            }
        }
        sums
    }
}

/// `a . b`
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    let mut parts = [0.0; PARTS];
    for (a, b) in a.iter().zip(b) {
        for k in 0..PARTS {
            parts[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    parts.iter().sum::<f64>() + rest
}

/// `a . b` over the points of a set.
fn dot_in(a: &[f64], b: &[f64], set: &[bool]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    let (set, set_rest) = set.as_chunks::<PARTS>();
    let mut parts = [0.0; PARTS];
    for ((a, b), set) in a.iter().zip(b).zip(set) {
        for k in 0..PARTS {
            parts[k] += if set[k] { a[k] * b[k] } else { 0.0 };
        }
    }
    let rest: f64 = a_rest
        .iter()
        .zip(b_rest)
        .zip(set_rest)
        .map(|((a, b), c)| if *c { a * b } else { 0.0 })
        .sum();
    parts.iter().sum::<f64>() + rest
}

/// Writes the gap `g - shift` on the contact set to `r`, zero elsewhere; returns the largest of what is wrong (gaps
/// in contact, penetrations outside) and the sum of the squares of the displacements `g - offset` in contact.
pub(super) fn judge(
    g: &[f64],
    shift: &[f64],
    offset: &[f64],
    contact: &[bool],
    r: &mut [f64],
) -> (f64, f64) {
    let one = |g: f64, shift: f64, offset: f64, contact: bool, r: &mut f64| -> (f64, f64) {
        let gap = g - shift;
        *r = if contact { gap } else { 0.0 };
        let wrong = if contact { gap } else { gap.min(0.0) };
        let displacement = if contact { g - offset } else { 0.0 };
        (wrong.abs(), displacement * displacement)
    };
    let ((g, g_rest), (shift, shift_rest)) = (g.as_chunks::<PARTS>(), shift.as_chunks::<PARTS>());
    let (offset, offset_rest) = offset.as_chunks::<PARTS>();
    let (contact, contact_rest) = contact.as_chunks::<PARTS>();
    let (r, r_rest) = r.as_chunks_mut::<PARTS>();
    let mut parts = [[0.0; PARTS]; 2];
    for (i, r) in r.iter_mut().enumerate() {
        let (g, shift, offset, contact) = (&g[i], &shift[i], &offset[i], &contact[i]);
        for k in 0..PARTS {
            let (wrong, size) = one(g[k], shift[k], offset[k], contact[k], &mut r[k]);
            parts[0][k] = if wrong > parts[0][k] {
                wrong
            } else {
                parts[0][k]
            };
            parts[1][k] += size;
        }
    }
    let mut wrong = parts[0].iter().copied().fold(0.0, f64::max);
    let mut size: f64 = parts[1].iter().sum();
    for (i, r) in r_rest.iter_mut().enumerate() {
        let more = one(g_rest[i], shift_rest[i], offset_rest[i], contact_rest[i], r);
        wrong = wrong.max(more.0);
        size += more.1;
    }
    (wrong, size)
}

/// Sums of `p n`, `|p n|` and `p n^2`.
fn first_moments(p: &[f64], n: &[f64]) -> [f64; 3] {
    let ((p, p_rest), (n, n_rest)) = (p.as_chunks::<PARTS>(), n.as_chunks::<PARTS>());
    let mut parts = [[0.0; PARTS]; 3];
    for (p, n) in p.iter().zip(n) {
        for k in 0..PARTS {
            let part = p[k] * n[k];
            parts[0][k] += part;
            parts[1][k] += part.abs();
            parts[2][k] += part * n[k];
        }
    }
    let mut sums = parts.map(|part| part.iter().sum::<f64>());
    for (p, n) in p_rest.iter().zip(n_rest) {
        let part = p * n;
        sums[0] += part;
        sums[1] += part.abs();
        sums[2] += part * n;
    }
    sums
}
