// SPDX-License-Identifier: MIT OR Apache-2.0
//! States of stick and slip under a magnet whose pull follows the gap, linearised.
//!
//! A change of the pull changes gaps, works and displacements along the tangents; the contact answers with a change of its
//! gaps, and the magnet to these. What comes back is found as for sliding states, by [`Pulling::returned`].

use std::sync::Arc;

use mtb_operator::unmonitored;

use super::{StickFound, StickGiven, StickSlip};
use crate::error::{Error, check};
use crate::magnet::{Face, Pulling};

/// A magnet on a contact whose points stick or slip, linearised about a state.
#[derive(Clone, Debug)]
pub struct StickPulling {
    pulling: Pulling,
    /// What a pull moves along both tangents.
    along: Option<Arc<Face>>,
}

impl StickPulling {
    pub(crate) fn new(pulling: Pulling, along: Option<Arc<Face>>) -> Self {
        Self { pulling, along }
    }

    /// What a pull (n) [Pa] changes in what is given.
    fn given(&self, pull: &[f64]) -> StickGiven {
        let [gap, work] = self.pulling.loads(pull);
        let mut given = StickGiven {
            gap,
            ..StickGiven::nothing(pull.len(), work.len())
        };
        given.work = work;
        if let Some(face) = &self.along {
            face.add(-1.0, pull, &mut given.placed);
            face.add(1.0, pull, &mut given.wanted);
        }
        given
    }

    /// The transposed map: weights (n) of a pull.
    fn weights(&self, given: &StickGiven) -> Vec<f64> {
        let mut pull = self.pulling.weights(&given.gap, &given.work);
        if let Some(face) = &self.along {
            face.add_weights(-1.0, &given.placed, &mut pull);
            face.add_weights(1.0, &given.wanted, &mut pull);
        }
        pull
    }
}

impl StickSlip {
    /// The same under a magnet whose pull follows the gap.
    #[must_use]
    pub(crate) fn with_magnet(mut self, pulling: Option<StickPulling>) -> Self {
        self.pulling = pulling;
        self
    }

    /// The magnet whose pull follows the gap, linearised.
    pub fn pulling(&self) -> Option<&Pulling> {
        self.pulling.as_ref().map(|own| &own.pulling)
    }

    /// What follows small changes of what is given, one answer for each.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite; [`Error::Singular`].
    pub fn forward(&self, changes: &[StickGiven]) -> Result<Vec<StickFound>, Error> {
        let mut answers = self.forward_held(changes)?;
        let Some(own) = &self.pulling else {
            return Ok(answers);
        };
        let slopes = own.pulling.slopes();
        let under = |pull: &[f64]| -> Result<StickFound, Error> {
            Ok(self.forward_held(&[own.given(pull)])?.remove(0))
        };
        for (change, answer) in changes.iter().zip(&mut answers) {
            let mut changed = slopes.times(&answer.gap)?;
            (changed.iter_mut().zip(&change.pull)).for_each(|(c, p)| *c += p);
            let pull = Pulling::returned(
                &changed,
                |pull| slopes.times(&under(pull)?.gap),
                &unmonitored,
            )?;
            let more = under(&pull)?;
            for (to, from) in [
                (&mut answer.traction, &more.traction),
                (&mut answer.gap, &more.gap),
                (&mut answer.motion, &more.motion),
                (&mut answer.slip, &more.slip),
                (&mut answer.rigid, &more.rigid),
            ] {
                to.iter_mut().zip(from).for_each(|(t, f)| *t += f);
            }
            answer.pull = pull;
        }
        Ok(answers)
    }

    /// The gradients, by all that is given, of sums of what is found with the weights `of`: one for each.
    ///
    /// # Errors
    /// As [`StickSlip::forward`].
    pub fn adjoint(&self, of: &[StickFound]) -> Result<Vec<StickGiven>, Error> {
        let mut gradients = self.adjoint_held(of)?;
        let Some(own) = &self.pulling else {
            return Ok(gradients);
        };
        let (n, m) = (self.points(), self.motions());
        let slopes = own.pulling.slopes();
        let behind = |pull: &[f64]| -> Result<StickGiven, Error> {
            let weights = StickFound {
                gap: slopes.transposed(pull)?,
                traction: vec![0.0; 3 * n],
                motion: vec![0.0; m],
                slip: vec![0.0; 2 * n],
                rigid: vec![0.0; 2 * n],
                pull: Vec::new(),
            };
            Ok(self.adjoint_held(&[weights])?.remove(0))
        };
        for (weights, given) in of.iter().zip(&mut gradients) {
            let mut asked = own.weights(given);
            if !weights.pull.is_empty() {
                check("pull", &weights.pull, n)?;
                (asked.iter_mut().zip(&weights.pull)).for_each(|(a, w)| *a += w);
            }
            let pull =
                Pulling::returned(&asked, |pull| Ok(own.weights(&behind(pull)?)), &unmonitored)?;
            let more = behind(&pull)?;
            for (to, from) in [
                (&mut given.gap, &more.gap),
                (&mut given.work, &more.work),
                (&mut given.wanted, &more.wanted),
                (&mut given.placed, &more.placed),
                (&mut given.friction, &more.friction),
            ] {
                to.iter_mut().zip(from).for_each(|(t, f)| *t += f);
            }
            given.pull = pull;
        }
        Ok(gradients)
    }
}
