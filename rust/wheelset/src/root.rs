// SPDX-License-Identifier: MIT OR Apache-2.0
//! Roots of a few functions that cost a contact solve each and end where a profile ends.

use nalgebra::{DMatrix, DVector};

use crate::Error;

/// Steps towards a root, and halvings of one of them.
const MOST_STEPS: usize = 40;
const HALVINGS: usize = 8;
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
}

/// Newton's method with a line search; Broyden's updates, and differences where those gain little.
///
/// `x`: a start in range; `jacobian`: an estimate of the derivatives there. The last call of the residual is
/// the root. `None`: no step makes the residual smaller, or the steps are used up.
pub(crate) fn find_root(
    residual: &mut Residual<'_>,
    mut x: DVector<f64>,
    mut jacobian: DMatrix<f64>,
    search: Search,
) -> Result<Option<DVector<f64>>, Error> {
    let mut value = residual(&x)?;
    let mut is_fresh = false;
    for _ in 0..MOST_STEPS {
        if value.amax() < search.tolerance {
            return Ok(Some(x));
        }
        let mut gain = f64::INFINITY;
        if let Some((there, left)) = shortened(residual, &x, &value, &jacobian, search.longest)? {
            let change = &there - &x;
            gain = left.norm() / value.norm();
            let missed = &left - &value - &jacobian * &change;
            jacobian += missed * change.transpose() / change.norm_squared();
            (x, value) = (there, left);
            is_fresh = false;
        } else if is_fresh {
            break;
        }
        if gain > ENOUGH && value.amax() >= search.tolerance {
            jacobian = differences(residual, &x, &value, search.small)?;
            is_fresh = true;
        }
    }
    Ok(None)
}

/// The point of a Newton step, and its residual, after as many halvings as make that smaller.
fn shortened(
    residual: &mut Residual<'_>,
    x: &DVector<f64>,
    value: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    longest: f64,
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
        let there = x + &change;
        match residual(&there) {
            Ok(left) if left.norm() < value.norm() => return Ok(Some((there, left))),
            Ok(_) | Err(Error::Geometry(_)) => change *= 0.5,
            Err(error) => return Err(error),
        }
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
        let found = find_root(&mut never, start, DMatrix::identity(2, 2), SEARCH);
        assert_eq!(found.unwrap(), None);
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
        let slope = DMatrix::from_element(1, 1, 1e-3);
        let found = find_root(&mut bounded, DVector::zeros(1), slope, SEARCH);
        assert!((found.unwrap().unwrap()[0] - 0.9).abs() < 1e-7);
    }

    #[test]
    fn an_interruption_is_not_a_missing_root() {
        let mut stopped = |_: &DVector<f64>| Err(Error::Stored("stopped"));
        let found = find_root(
            &mut stopped,
            DVector::zeros(1),
            DMatrix::identity(1, 1),
            SEARCH,
        );
        assert_eq!(found, Err(Error::Stored("stopped")));
    }
}
