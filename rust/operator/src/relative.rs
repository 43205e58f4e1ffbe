// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use crate::{Compliance, Component, Error, Map, Mirrored};

/// Two bodies in contact as one compliance: a traction on the lower body to the displacement of the lower
/// body relative to the upper one, `u_lower - u_upper` along the tangents and the sum of both indentations
/// along the normal.
///
/// The sum of the lower compliance and the [`Mirrored`] upper one; either body may be rigid. A layer between them adds
/// to the normal indentation of each point by its own pressure.
#[derive(Clone)]
pub struct Relative {
    lower: Option<Arc<dyn Compliance>>,
    upper: Option<Arc<dyn Compliance>>,
    points: usize,
    /// Flexibility of a layer at each point [m/Pa]; empty for none.
    layer: Arc<[f64]>,
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
            layer: Arc::new([]),
        })
    }

    /// The same bodies with a layer between them that gives way by `flexibility` (n) [m/Pa] times the pressure.
    ///
    /// # Errors
    /// [`Error::Layer`] unless there is a number of at least 0 for each point.
    pub fn with_layer(self, flexibility: Vec<f64>) -> Result<Self, Error> {
        let is_none = flexibility.is_empty();
        let wrong = flexibility
            .iter()
            .position(|l| !(*l >= 0.0 && l.is_finite()));
        if wrong.is_some() || !(is_none || flexibility.len() == self.points) {
            return Err(Error::Layer {
                found: flexibility.len(),
                points: self.points,
                value: wrong.map_or(0.0, |at| flexibility[at]),
            });
        }
        Ok(Self {
            layer: flexibility.into(),
            ..self
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
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            for ((u, p), layer) in displacement.iter_mut().zip(traction).zip(&*self.layer) {
                *u += scale * layer * p;
            }
        }
    }

    fn add_transposed(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        weights: &[f64],
        sums: &mut [f64],
    ) {
        if let Some(lower) = &self.lower {
            lower.add_transposed(observed, loaded, scale, weights, sums);
        }
        if let Some(upper) = &self.upper {
            Mirrored(&**upper).add_transposed(observed, loaded, scale, weights, sums);
        }
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            for ((sum, weight), layer) in sums.iter_mut().zip(weights).zip(&*self.layer) {
                *sum += scale * layer * weight;
            }
        }
    }

    fn prefers_products(&self) -> bool {
        let mut bodies = [&self.lower, &self.upper].into_iter().flatten();
        bodies.any(|c| c.prefers_products())
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let layer = self.layer.iter().sum::<f64>() / self.points as f64;
        let mut bodies = [&self.lower, &self.upper].into_iter().flatten();
        // under the same points bodies give way much alike: one stands for both, and a factor does not matter
        let alike = bodies.clone().count() as f64;
        bodies.find_map(|body| body.near_inverse((softer + layer) / alike))
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
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            let diagonal = matrix.iter_mut().step_by(self.points + 1);
            for (own, layer) in diagonal.zip(&*self.layer) {
                *own += scale * layer;
            }
        }
    }
}
