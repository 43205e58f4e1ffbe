// SPDX-License-Identifier: MIT OR Apache-2.0
//! Passes over the points that may be in contact: each reads and writes its fields once, on all threads, and sums in
//! eight interleaved parts, which keeps the sums fast and their rounding small.

use std::array::from_fn;
use std::mem::take;
use std::ops::Range;

use mtb_operator::wide;

const PARTS: usize = 8;

/// Points that are taken or left out together.
const STRETCH: usize = 64;

/// Points that a thread works on at once, a multiple of [`STRETCH`]. The sums do not depend on the number of
/// threads.
const PIECE: usize = 1 << 14;

/// Points from which a second thread pays.
const PARALLEL_FROM: usize = 1 << 16;

/// Stretches of points that hold a set.
pub(super) struct Spans(Vec<Range<usize>>);

impl Spans {
    pub(super) fn whole(n: usize) -> Self {
        let firsts = (0..n).step_by(PIECE);
        Self(firsts.map(|first| first..n.min(first + PIECE)).collect())
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
                Some(last) if last.end == from && last.len() < PIECE => last.end = to,
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
    pub(super) fn dot(&self, a: &[f64], b: &[f64], set: &[bool]) -> f64 {
        let [dot] = self.sum([], [a, b], set, |[], [a, b], _| ([], [a * b]));
        dot
    }

    /// `a . b` over the points of a set.
    pub(super) fn dot_in(&self, a: &[f64], b: &[f64], set: &[bool]) -> f64 {
        let [dot] = self.sum([], [a, b], set, |[], [a, b], is_in| {
            ([], [if is_in { a * b } else { 0.0 }])
        });
        dot
    }

    /// Hands each point to `work`, with its entries of the fields and whether it is in the set, writes what that
    /// returns first and adds up what it returns then.
    pub(super) fn sum<const W: usize, const R: usize, const K: usize>(
        &self,
        written: [&mut [f64]; W],
        read: [&[f64]; R],
        set: &[bool],
        work: impl Fn([f64; W], [f64; R], bool) -> ([f64; W], [f64; K]) + Sync,
    ) -> [f64; K] {
        let add = |a: [f64; K], b: [f64; K]| from_fn(|k| a[k] + b[k]);
        self.fold(written, read, set, work, [0.0; K], add)
    }

    /// [`Spans::sum`] with another way to put two results together, and a result that changes none.
    pub(super) fn fold<const W: usize, const R: usize, const K: usize>(
        &self,
        written: [&mut [f64]; W],
        read: [&[f64]; R],
        set: &[bool],
        work: impl Fn([f64; W], [f64; R], bool) -> ([f64; W], [f64; K]) + Sync,
        neutral: [f64; K],
        join: impl Fn([f64; K], [f64; K]) -> [f64; K] + Sync,
    ) -> [f64; K] {
        let points: usize = self.iter().map(|span| span.len()).sum();
        let pass = Pass {
            work: &work,
            neutral,
            join: &join,
            is_parallel: points >= PARALLEL_FROM && rayon::current_num_threads() > 1,
        };
        pass.over(&self.0, 0, written, read, set)
    }
}

struct Pass<'a, F, J, const K: usize> {
    work: &'a F,
    neutral: [f64; K],
    join: &'a J,
    is_parallel: bool,
}

impl<F, J, const K: usize> Pass<'_, F, J, K>
where
    J: Fn([f64; K], [f64; K]) -> [f64; K] + Sync,
{
    /// Goes over spans of the fields, of which the first entry is that of the point number `first`.
    fn over<const W: usize, const R: usize>(
        &self,
        spans: &[Range<usize>],
        first: usize,
        mut written: [&mut [f64]; W],
        read: [&[f64]; R],
        set: &[bool],
    ) -> [f64; K]
    where
        F: Fn([f64; W], [f64; R], bool) -> ([f64; W], [f64; K]) + Sync,
    {
        let (Some(start), Some(end)) = (spans.first(), spans.last()) else {
            return self.neutral;
        };
        if spans.len() == 1 || end.end - start.start <= PIECE {
            let mut result = self.neutral;
            for span in spans {
                let span = span.start - first..span.end - first;
                let written = written.each_mut().map(|w| &mut w[span.clone()]);
                let read = read.map(|r| &r[span.clone()]);
                result = (self.join)(result, self.piece(written, read, &set[span]));
            }
            return result;
        }
        let (before, after) = spans.split_at(spans.len() / 2);
        let middle = after[0].start;
        let mut written_after = from_fn(|_| Default::default());
        let written_before = from_fn(|k| {
            let (before, after) = take(&mut written[k]).split_at_mut(middle - first);
            written_after[k] = after;
            before
        });
        let read_before = read.map(|r| &r[..middle - first]);
        let read_after = read.map(|r| &r[middle - first..]);
        let (set_before, set_after) = set.split_at(middle - first);
        let lower = || self.over(before, first, written_before, read_before, set_before);
        let upper = || self.over(after, middle, written_after, read_after, set_after);
        let (a, b) = if self.is_parallel {
            rayon::join(lower, upper)
        } else {
            (lower(), upper())
        };
        (self.join)(a, b)
    }

    fn piece<const W: usize, const R: usize>(
        &self,
        written: [&mut [f64]; W],
        read: [&[f64]; R],
        set: &[bool],
    ) -> [f64; K]
    where
        F: Fn([f64; W], [f64; R], bool) -> ([f64; W], [f64; K]) + Sync,
    {
        wide(
            #[inline(always)]
            || self.piece_plainly(written, read, set),
        )
    }

    #[expect(
        clippy::inline_always,
        reason = "what is not inlined keeps its narrow instructions"
    )]
    #[inline(always)]
    fn piece_plainly<const W: usize, const R: usize>(
        &self,
        mut written: [&mut [f64]; W],
        read: [&[f64]; R],
        set: &[bool],
    ) -> [f64; K]
    where
        F: Fn([f64; W], [f64; R], bool) -> ([f64; W], [f64; K]) + Sync,
    {
        // one loop that the compiler makes wide, and one that adds up what it left
        let mut terms = [[0.0; STRETCH]; K];
        let mut parts: [[f64; PARTS]; K] = from_fn(|k| [self.neutral[k]; PARTS]);
        let mut rest = self.neutral;
        for (number, set) in set.chunks(STRETCH).enumerate() {
            let here = number * STRETCH..number * STRETCH + set.len();
            let written = written.each_mut().map(|w| &mut w[here.clone()]);
            let read = read.map(|r| &r[here.clone()]);
            for i in 0..set.len() {
                let old = from_fn(|k| written[k][i]);
                let (new, results) = (self.work)(old, read.map(|r| r[i]), set[i]);
                for k in 0..W {
                    written[k][i] = new[k];
                }
                for k in 0..K {
                    terms[k][i] = results[k];
                }
            }
            // a bound of the inner loop would cost more than wide instructions gain
            let whole = set.len() / PARTS * PARTS;
            for first in (0..whole).step_by(PARTS) {
                let mut next = parts;
                for part in 0..PARTS {
                    let own = from_fn(|k| terms[k][first + part]);
                    let joined = (self.join)(from_fn(|k| parts[k][part]), own);
                    for k in 0..K {
                        next[k][part] = joined[k];
                    }
                }
                parts = next;
            }
            for i in whole..set.len() {
                rest = (self.join)(rest, from_fn(|k| terms[k][i]));
            }
        }
        let part = |part: usize| from_fn(|k| parts[k][part]);
        (0..PARTS).map(part).fold(rest, self.join)
    }
}

/// Writes the gap `g - shift` on the contact set to `r`, zero elsewhere; returns the largest of what is wrong (gaps
/// in contact, penetrations outside, gaps at the cap of the pressure), the sum of the squares of the displacements
/// `g - offset` under pressure, and the number of points there.
pub(super) fn judge(
    g: &[f64],
    shift: &[f64],
    offset: &[f64],
    (p, cap): (&[f64], f64),
    contact: &[bool],
    r: &mut [f64],
) -> [f64; 3] {
    let one = |_: [f64; 1], [g, shift, offset, p]: [f64; 4], contact: bool| {
        let gap = g - shift;
        let wrong = if contact {
            gap
        } else if p < cap {
            gap.min(0.0)
        } else {
            gap.max(0.0)
        };
        let is_loaded = p > 0.0;
        let displacement = if is_loaded { g - offset } else { 0.0 };
        let r = if contact { gap } else { 0.0 };
        let count = f64::from(u8::from(is_loaded));
        ([r], [wrong.abs(), displacement * displacement, count])
    };
    let join = |a: [f64; 3], b: [f64; 3]| {
        let worst = if b[0] > a[0] { b[0] } else { a[0] };
        [worst, a[1] + b[1], a[2] + b[2]]
    };
    let whole = Spans::whole(g.len());
    whole.fold([r], [g, shift, offset, p], contact, one, [0.0; 3], join)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_instructions_give_what_any_processor_gives() {
        let field = |n: usize, seed: f64| -> Vec<f64> {
            (0..n).map(|k| (seed + 1.3 * k as f64).sin()).collect()
        };
        let work = |[y]: [f64; 1], [a, b]: [f64; 2], is_in: bool| {
            let next = y - 0.7 * a;
            let longest = if next < 0.0 { y / a } else { f64::INFINITY };
            ([if is_in { next } else { 0.0 }], [a * b, longest])
        };
        let join = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], if b[1] < a[1] { b[1] } else { a[1] }];
        let pass = Pass {
            work: &work,
            neutral: [0.0, f64::INFINITY],
            join: &join,
            is_parallel: false,
        };
        for n in [1, 7, 8, 100, 1000] {
            let (a, b) = (field(n, 0.0), field(n, 5.0));
            let set: Vec<bool> = a.iter().map(|a| *a > -0.3).collect();
            let (mut widely, mut plainly) = (field(n, 2.0), field(n, 2.0));
            let by_wide = pass.piece([&mut widely], [&a, &b], &set);
            let by_any = pass.piece_plainly([&mut plainly], [&a, &b], &set);
            assert_eq!((by_wide, widely), (by_any, plainly));
        }
    }
}
