// SPDX-License-Identifier: MIT OR Apache-2.0
//! Roots of a few functions that cost a contact solve each and end where a profile ends.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector};

use crate::Error;

/// Steps towards a root, and halvings of one of them.
const MOST_STEPS: usize = 40;
const HALVINGS: usize = 8;
/// Halvings of an interval in which a residual changes its sign.
const MOST_HALVES: usize = 40;
/// Decrease of the residual that the derivatives at hand must give to be kept.
const ENOUGH: f64 = 0.5;

/// (n) of (n); a geometry error outside its range, to which steps are shortened.
pub(crate) type Residual<'a> = dyn FnMut(&DVector<f64>) -> Result<DVector<f64>, Error> + 'a;

/// A point, and the residual there.
type Reached = (DVector<f64>, DVector<f64>);

/// When a search ends and how far it goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Largest residual of a root.
    pub(crate) tolerance: f64,
    /// Largest change of an unknown in a step.
    pub(crate) longest: f64,
    /// Change of an unknown for differences.
    pub(crate) small: f64,
    /// Trials of the residual after which a search for a root of several functions is given up.
    pub(crate) trials: usize,
}

/// Newton's method with a line search; Broyden's updates, and differences where those gain little.
///
/// `x`: a start in range; `jacobian`: an estimate of the derivatives there, then at the root. The last call of the
/// residual is the root. `None`: no step makes the residual smaller, or the steps or trials are used up.
pub(crate) fn find_root(
    residual: &mut Residual<'_>,
    mut x: DVector<f64>,
    jacobian: &mut DMatrix<f64>,
    search: Search,
) -> Result<Option<DVector<f64>>, Error> {
    let left = Cell::new(search.trials);
    let residual: &mut Residual<'_> = &mut |x| {
        left.set(left.get().saturating_sub(1));
        residual(x)
    };
    let mut value = residual(&x)?;
    let mut is_fresh = false;
    for _ in 0..MOST_STEPS {
        if value.amax() < search.tolerance {
            return Ok(Some(x));
        }
        if left.get() == 0 {
            break;
        }
        let mut gain = f64::INFINITY;
        let longest = search.longest;
        if let Some((there, rest)) = shortened(residual, &x, &value, jacobian, longest, &left)? {
            let change = &there - &x;
            gain = rest.norm() / value.norm();
            let missed = &rest - &value - &*jacobian * &change;
            *jacobian += missed * change.transpose() / change.norm_squared();
            (x, value) = (there, rest);
            is_fresh = false;
        } else if is_fresh {
            break;
        }
        if gain > ENOUGH && value.amax() >= search.tolerance {
            *jacobian = differences(residual, &x, &value, search.small)?;
            is_fresh = true;
        }
    }
    Ok(None)
}

/// The point of a Newton step, and its residual, after as many halvings as make that smaller, and no more than there are
/// trials left.
fn shortened(
    residual: &mut Residual<'_>,
    x: &DVector<f64>,
    value: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    longest: f64,
    left: &Cell<usize>,
) -> Result<Option<Reached>, Error> {
    if !jacobian.iter().chain(value).all(|v| v.is_finite()) {
        return Ok(None);
    }
    let factors = jacobian.clone().svd(true, true);
    let least = f64::EPSILON * x.len() as f64 * factors.singular_values.amax();
    let Ok(mut change) = factors.solve(&-value, least) else {
        return Ok(None);
    };
    change *= (longest / change.amax().max(f64::MIN_POSITIVE)).min(1.0);
    for _ in 0..HALVINGS {
        if left.get() == 0 {
            break;
        }
        let there = x + &change;
        match residual(&there) {
            Ok(rest) if rest.norm() < value.norm() => return Ok(Some((there, rest))),
            Ok(_) | Err(Error::Geometry(_) | Error::CutOff { .. } | Error::Tangential { .. }) => {
                change *= 0.5;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

/// How a search by halves ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Halved {
    /// At a root, the last call of the residual.
    Root(DVector<f64>),
    /// At a jump over zero: the places on its two sides and their residuals, the lower one first.
    Jump([(f64, f64); 2]),
    /// No change of sign was found.
    Nothing,
}

/// A root of one function of one unknown between two places where its sign differs, also where it jumps.
pub(crate) fn halved(
    residual: &mut Residual<'_>,
    start: &DVector<f64>,
    search: Search,
) -> Result<Halved, Error> {
    let value = residual(start)?[0];
    // residuals fall with the unknown: a wheel that is higher carries less
    let mut step = search.small.copysign(value);
    let mut ends = [(start[0], value); 2];
    while ends[0].1 * ends[1].1 > 0.0 {
        if step.abs() > search.longest {
            return Ok(Halved::Nothing);
        }
        let there = ends[1].0 + step;
        match residual(&DVector::from_element(1, there)) {
            Ok(next) => ends = [ends[1], (there, next[0])],
            Err(Error::Geometry(_) | Error::CutOff { .. } | Error::Tangential { .. }) => {
                return Ok(Halved::Nothing);
            }
            Err(error) => return Err(error),
        }
        step *= 2.0;
    }
    for _ in 0..MOST_HALVES {
        let middle = DVector::from_element(1, 0.5 * (ends[0].0 + ends[1].0));
        let value = residual(&middle)?[0];
        if value.abs() < search.tolerance {
            return Ok(Halved::Root(middle));
        }
        ends[usize::from(value * ends[0].1 <= 0.0)] = (middle[0], value);
    }
    ends.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(Halved::Jump(ends))
}

/// A root of two functions of two unknowns, both continuous, whose mean falls with the first unknown: for each second
/// unknown the first one at which the mean is zero, and of these the one at which their difference changes its sign.
/// The last call of the residual is the root.
///
/// It needs no derivatives, and does where these change more quickly than a step tells, for some hundred trials.
pub(crate) fn nested(
    residual: &mut Residual<'_>,
    start: &DVector<f64>,
    search: Search,
) -> Result<Option<DVector<f64>>, Error> {
    let tolerance = 0.4 * search.tolerance;
    let first = Cell::new(start[0]);
    let mut last = DVector::zeros(2);
    // the difference at a second unknown, NaN where the mean has no zero
    let mut difference = |second: f64| -> Result<f64, Error> {
        let mut mean = |place: f64| {
            last = residual(&DVector::from_column_slice(&[place, second]))?;
            Ok(0.5 * (last[0] + last[1]))
        };
        let found = between(&mut mean, first.get(), search, tolerance)?;
        Ok(found.map_or(f64::NAN, |place| {
            first.set(place);
            last[0] - last[1]
        }))
    };
    let found = between(&mut difference, start[1], search, tolerance)?;
    Ok(found.map(|second| DVector::from_column_slice(&[first.get(), second])))
}

/// A root of a continuous function, at its last call; `None` where none is found within the longest step of a place, or
/// the function ends.
fn between(
    value: &mut dyn FnMut(f64) -> Result<f64, Error>,
    start: f64,
    search: Search,
    tolerance: f64,
) -> Result<Option<f64>, Error> {
    let mut at = |place: f64| match value(place) {
        Err(Error::Geometry(_) | Error::CutOff { .. } | Error::Tangential { .. }) => Ok(f64::NAN),
        done => done,
    };
    let mut ends = [(start, at(start)?); 2];
    if ends[0].1.abs() < tolerance {
        return Ok(Some(start));
    }
    if ends[0].1.is_nan() {
        return Ok(None);
    }
    let mut step = search.small;
    let mut alive = [true; 2];
    loop {
        if step > search.longest || alive == [false; 2] {
            return Ok(None);
        }
        let mut is_found = false;
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            if !alive[k] {
                continue;
            }
            let there = start + sign * step;
            let new = at(there)?;
            if new.abs() < tolerance {
                return Ok(Some(there));
            }
            if new.is_nan() {
                alive[k] = false;
                continue;
            }
            if new * ends[0].1 < 0.0 {
                ends[1] = (there, new);
                is_found = true;
                break;
            }
        }
        if is_found {
            break;
        }
        step *= 2.0;
    }
    // by chords, the end that stays halved [DowellJarratt1971]
    for _ in 0..MOST_HALVES {
        let [(a, at_a), (b, at_b)] = ends;
        let there = b - at_b * (b - a) / (at_b - at_a);
        let new = at(there)?;
        if new.abs() < tolerance {
            return Ok(Some(there));
        }
        if new.is_nan() {
            return Ok(None);
        }
        ends = if new * at_b < 0.0 {
            [(b, at_b), (there, new)]
        } else {
            [(a, 0.5 * at_a), (there, new)]
        };
    }
    Ok(None)
}

/// Derivatives (n, n) of the residual, backwards where it ends ahead.
pub(crate) fn differences(
    residual: &mut Residual<'_>,
    x: &DVector<f64>,
    value: &DVector<f64>,
    small: f64,
) -> Result<DMatrix<f64>, Error> {
    let n = x.len();
    let mut derivatives = DMatrix::zeros(n, n);
    for k in 0..n {
        let mut there = x.clone();
        there[k] += small;
        let column = match residual(&there) {
            Ok(ahead) => (ahead - value) / small,
            Err(Error::Geometry(_)) => {
                there[k] = x[k] - small;
                (value - residual(&there)?) / small
            }
            Err(error) => return Err(error),
        };
        derivatives.set_column(k, &column);
    }
    Ok(derivatives)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEARCH: Search = Search {
        tolerance: 1e-9,
        longest: 5.0,
        small: 1e-6,
        trials: usize::MAX,
    };

    #[test]
    fn a_root_that_does_not_exist_is_not_found() {
        let mut never = |x: &DVector<f64>| {
            Ok(DVector::from_vec(vec![
                x[0] * x[0] + x[1] * x[1] + 1.0,
                x[0] - x[1],
            ]))
        };
        let start = DVector::from_element(2, 1.0);
        let found = find_root(&mut never, start, &mut DMatrix::identity(2, 2), SEARCH);
        assert_eq!(found.unwrap(), None);
    }

    #[test]
    fn halves_tell_a_root_from_a_jump() {
        let search = Search {
            small: 1e-3,
            ..SEARCH
        };
        let of = |jump: f64| {
            move |x: &DVector<f64>| Ok(x.map(|x| 0.3 - x + if x < 0.3 { jump } else { -jump }))
        };
        for start in [0.0, 1.0] {
            let start = DVector::from_element(1, start);
            let Ok(Halved::Root(found)) = halved(&mut of(0.0), &start, search) else {
                panic!("no root");
            };
            assert!((found[0] - 0.3).abs() < 1e-8);
            let Ok(Halved::Jump([(_, low), (_, high)])) = halved(&mut of(0.1), &start, search)
            else {
                panic!("no jump");
            };
            assert!((low + 0.1).abs() < 1e-8 && (high - 0.1).abs() < 1e-8);
        }
        let mut never = |x: &DVector<f64>| Ok(x.map(|x| 1.0 + x * x));
        let found = halved(&mut never, &DVector::zeros(1), search);
        assert_eq!(found, Ok(Halved::Nothing));
    }

    #[test]
    fn nested_roots_need_no_derivatives() {
        // kinks steeper the nearer the root is, over which Newton's steps go to and fro
        let kinked = |x: f64| x + 0.6 * x.signum() * x.abs().powf(0.4);
        let mut calls = 0;
        let mut residual = |x: &DVector<f64>| {
            calls += 1;
            let (mean, other) = (
                -kinked(x[0] - 0.3),
                kinked(x[1] + 0.2 + 0.1 * (40.0 * x[0]).sin()),
            );
            Ok(DVector::from_column_slice(&[mean + other, mean - other]))
        };
        let search = Search {
            tolerance: 1e-9,
            longest: 2.0,
            small: 1e-3,
            trials: usize::MAX,
        };
        let start = DVector::zeros(2);
        let found = nested(&mut residual, &start, search).unwrap().unwrap();
        assert!(residual(&found).unwrap().amax() < 1e-9);
        let mut beside =
            |x: &DVector<f64>| Ok(DVector::from_column_slice(&[1.0 - 0.0 * x[0], 2.0]));
        assert_eq!(nested(&mut beside, &start, search).unwrap(), None);
        assert!(calls < 4000, "{calls}");
    }

    #[test]
    fn a_step_stays_in_the_range() {
        let mut bounded = |x: &DVector<f64>| {
            if x[0] > 1.0 {
                return Err(Error::Geometry(mtb_geometry::Error::ProfileEnds {
                    profile: "rail",
                    end: 1.0,
                }));
            }
            Ok(DVector::from_element(1, (10.0 * (x[0] - 0.9)).exp_m1()))
        };
        let mut slope = DMatrix::from_element(1, 1, 1e-3);
        let found = find_root(&mut bounded, DVector::zeros(1), &mut slope, SEARCH);
        assert!((found.unwrap().unwrap()[0] - 0.9).abs() < 1e-7);
    }

    #[test]
    fn an_interruption_is_not_a_missing_root() {
        let mut stopped = |_: &DVector<f64>| Err(Error::Stored("stopped"));
        let found = find_root(
            &mut stopped,
            DVector::zeros(1),
            &mut DMatrix::identity(1, 1),
            SEARCH,
        );
        assert_eq!(found, Err(Error::Stored("stopped")));
    }
}
