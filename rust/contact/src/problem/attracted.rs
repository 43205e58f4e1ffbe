// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies under a pull that follows the gap.

use mtb_complementarity::linear::Status;
use mtb_operator::Monitor;

use super::heating::ROUNDS;
use super::{Attracted, FreeMotion, Friction, Heated, Heating, Loading, Outcome, Problem};
use crate::error::Error;
use crate::magnet::{Magnet, settle, snap_share};

/// Solves of a heated state after which the points that exchange heat only grow in number.
const FREE: usize = 20;

impl Problem {
    /// A loading with a pull (n) [Pa] on bodies besides.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn pulled(
        &self,
        loading: &Loading,
        bodies: &[Attracted],
        pull: &[f64],
    ) -> Result<Loading, Error> {
        let mut loading = loading.clone();
        for pulled in bodies {
            self.load(&mut loading, pulled.by(pull))?;
        }
        Ok(loading)
    }

    /// Work [J/Pa] on each motion (m) of a unit of pull on bodies at each point (n).
    pub(crate) fn works_of_pull(&self, bodies: &[Attracted]) -> Vec<Vec<f64>> {
        let area = &self.geometry().area;
        let work = |own: &FreeMotion| -> Vec<f64> {
            let is_pulled = own.is_pulled && bodies.iter().any(|b| b.body == own.body);
            let by = |(opening, area): (&f64, &f64)| if is_pulled { -opening * area } else { 0.0 };
            own.motion.opening.iter().zip(area).map(by).collect()
        };
        self.motions().iter().map(work).collect()
    }

    /// Lets the upper body slide as [`Problem::slide`] under a magnet besides the loading, whose pull is that at the
    /// gaps of the state.
    ///
    /// `from` is the pull (n) [Pa] from which the state is looked for; without one it is that at the gap of the
    /// loading. Of its [`Settled`](crate::magnet::Settled) the share is known where it is asked for.
    ///
    /// # Errors
    /// As [`Problem::slide`].
    #[allow(clippy::too_many_arguments, reason = "a slide, and a magnet")]
    pub fn slide_attracted(
        &self,
        loading: &Loading,
        magnet: &Magnet<'_>,
        from: Option<Vec<f64>>,
        direction: &[f64],
        friction: Friction<'_>,
        start: Option<Vec<bool>>,
        with_share: bool,
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let from = magnet.circuit.first_pull(magnet.factor, loading, from)?;
        let mut active = start;
        let mut solve = |pull: &[f64]| {
            let loading = self.pulled(loading, magnet.bodies, pull)?;
            let outcome = self.slide(&loading, direction, friction, active.take(), monitor)?;
            active = (outcome.solution.status == Status::Solved).then(|| outcome.in_contact());
            Ok(outcome)
        };
        let mut outcome = settle(magnet.circuit, magnet.factor, from, &mut solve)?;
        if with_share && outcome.solution.status == Status::Solved {
            let share = snap_share(magnet, &mut outcome, solve)?;
            if let Some(settled) = &mut outcome.settled {
                settled.share = Some(share);
            }
        }
        Ok(outcome)
    }

    /// Lets the upper body slide and heats both bodies as [`Problem::slide_heated`], likewise.
    ///
    /// # Errors
    /// As [`Problem::slide_heated`].
    #[allow(clippy::too_many_arguments, reason = "a heated slide, and a magnet")]
    pub fn slide_heated_attracted(
        &self,
        loading: &Loading,
        magnet: &Magnet<'_>,
        from: Option<Vec<f64>>,
        direction: &[f64],
        friction: &[f64],
        heating: &Heating<'_>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<Heated, Error> {
        let from = magnet.circuit.first_pull(magnet.factor, loading, from)?;
        let mut active = start;
        let mut solves = 0;
        settle(magnet.circuit, magnet.factor, from, |pull| {
            let loading = self.pulled(loading, magnet.bodies, pull)?;
            solves += 1;
            // where the points that exchange heat change with the pull to and fro, no pull settles
            let free = if solves <= FREE { ROUNDS } else { 0 };
            let heated = self.heated_in_rounds(
                &loading,
                direction,
                friction,
                heating,
                active.take(),
                free,
                monitor,
            )?;
            active = Some(if free > 0 {
                heated.outcome.in_contact()
            } else {
                heated.exchanging.clone()
            });
            Ok(heated)
        })
    }
}
