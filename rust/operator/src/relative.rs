// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use crate::{Compliance, Component, Error, Mirrored};

/// Two bodies in contact as one compliance: a traction on the lower body to the displacement of the lower
/// body relative to the upper one, `u_lower - u_upper` along the tangents and the sum of both indentations
/// along the normal.
///
/// The sum of the lower compliance and the [`Mirrored`] upper one; either body may be rigid.
#[derive(Clone)]
pub struct Relative {
    lower: Option<Arc<dyn Compliance>>,
    upper: Option<Arc<dyn Compliance>>,
    points: usize,
}

impl Relative {
    /// The two bodies; `None` for a rigid one.
    ///
    /// # Errors
    /// [`Error::Points`] if they have unlike numbers of points, [`Error::Rigid`] if both are rigid.
    pub fn new(
        lower: Option<Arc<dyn Compliance>>,
        upper: Option<Arc<dyn Compliance>>,
    ) -> Result<Self, Error> {
        let counts = [&lower, &upper].map(|body| body.as_ref().map(|c| c.points()));
        let points = match counts {
            [Some(lower), Some(upper)] if lower != upper => {
                return Err(Error::Points { lower, upper });
            }
            [Some(points), _] | [None, Some(points)] => points,
            [None, None] => return Err(Error::Rigid),
        };
        Ok(Self {
            lower,
            upper,
            points,
        })
    }

    /// The lower body; `None` if it is rigid.
    pub fn lower(&self) -> Option<&Arc<dyn Compliance>> {
        self.lower.as_ref()
    }

    /// The upper body; `None` if it is rigid.
    pub fn upper(&self) -> Option<&Arc<dyn Compliance>> {
        self.upper.as_ref()
    }
}

impl Compliance for Relative {
    fn points(&self) -> usize {
        self.points
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if let Some(lower) = &self.lower {
            lower.add_displacement(observed, loaded, scale, traction, displacement);
        }
        if let Some(upper) = &self.upper {
            Mirrored(&**upper).add_displacement(observed, loaded, scale, traction, displacement);
        }
    }

    fn prefers_products(&self) -> bool {
        let mut bodies = [&self.lower, &self.upper].into_iter().flatten();
        bodies.any(|c| c.prefers_products())
    }

    fn influence_memory(&self) -> f64 {
        let bodies = [&self.lower, &self.upper].into_iter().flatten();
        bodies.map(|c| c.influence_memory()).sum()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        if let Some(lower) = &self.lower {
            lower.add_influence(observed, loaded, scale, matrix);
        }
        if let Some(upper) = &self.upper {
            Mirrored(&**upper).add_influence(observed, loaded, scale, matrix);
        }
    }
}
