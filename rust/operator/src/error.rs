use thiserror::Error;

/// What the constructors of this crate refuse.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A grid without points, or with a spacing that is not a positive number.
    #[error(
        "grid of {nx} x {ny} points with spacing {dx:e} x {dy:e} m: counts must be at least 1, spacings positive and finite"
    )]
    Grid {
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// Spacing along x [m].
        dx: f64,
        /// Spacing along y [m].
        dy: f64,
    },
    /// More points than dense matrices of them would fit into the memory.
    #[error(
        "{points} contact points need {gigabytes:.1} GB as dense matrices, the limit is {limit:.0} GB: take fewer, larger cells"
    )]
    DenseMemory {
        /// Points asked for.
        points: usize,
        /// Memory [GB] that their matrices need.
        gigabytes: f64,
        /// Memory [GB] that is granted.
        limit: f64,
    },
}

/// Memory [GB] that dense matrices may take.
const DENSE_LIMIT: f64 = 8.0;

/// Refuses what would not fit into the memory, before any of it is asked for.
///
/// # Errors
/// [`Error::DenseMemory`] if `matrices` dense square matrices over `points` take more than 8 GB.
pub fn check_dense(points: usize, matrices: usize) -> Result<(), Error> {
    let gigabytes = 8e-9 * matrices as f64 * (points as f64).powi(2);
    if gigabytes <= DENSE_LIMIT {
        return Ok(());
    }
    Err(Error::DenseMemory {
        points,
        gigabytes,
        limit: DENSE_LIMIT,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_memory_does_not_hold_is_refused() {
        assert!(check_dense(10_000, 4).is_ok());
        assert_eq!(check_dense(0, 4), Ok(()));
        let error = check_dense(40_000, 4).expect_err("51 GB");
        assert!(
            error
                .to_string()
                .contains("40000 contact points need 51.2 GB")
        );
        assert!(check_dense(usize::MAX, 1).is_err());
    }
}
