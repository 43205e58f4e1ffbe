// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two poles on one body: the one may be lifted or carry next to nothing beside the other, its tilt free.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::sliding::{RigidMotion, SlidingContact, SlidingMatrix, SlidingSolution};
use mtb_contact::stepping::{Influence, SlidingStepper};
use mtb_operator::{Compliance, Component, Relative, unmonitored};
use proptest::prelude::*;

/// Points of a pole along it, and across it.
const LONG: usize = 8;
const WIDE: usize = 2;
const N: usize = 2 * LONG * WIDE;

/// A foundation that both poles share, whose tangential tractions tilt the gap along them.
struct Ground {
    coupling: f64,
}

/// Whether a point belongs to the first pole; its place from the middle of its pole.
fn place(i: usize) -> (bool, f64, f64) {
    let k = i % (LONG * WIDE);
    let along = (k % LONG) as f64 - 0.5 * (LONG - 1) as f64;
    (i < LONG * WIDE, along, (k / LONG) as f64)
}

impl Ground {
    fn entry(&self, i: usize, j: usize, loaded: Component) -> f64 {
        let ((a, xi, yi), (b, xj, yj)) = (place(i), place(j));
        let apart = if a == b { 0.0 } else { 4.0 };
        let r = (xi - xj).hypot((yi - yj).abs() + apart) + 0.3;
        match loaded {
            Component::Normal => 1.0 / r,
            Component::X => self.coupling * (xi - xj) / (r * r),
            Component::Y => 0.0,
        }
    }
}

impl Compliance for Ground {
    fn points(&self) -> usize {
        N
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        assert_eq!(observed, Component::Normal, "only the gap is asked for");
        for i in 0..N {
            for j in 0..N {
                displacement[i] += scale * traction[j] * self.entry(i, j, loaded);
            }
        }
    }
}

/// The tilt of each pole along itself, with an arm to its face for friction.
fn tilts(arm: f64, work: [f64; 2]) -> Vec<RigidMotion> {
    [true, false]
        .into_iter()
        .zip(work)
        .map(|(first, work)| {
            let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
                let own = |i| Some(place(i)).filter(|(own, ..)| *own == first);
                (0..N)
                    .map(|i| own(i).map_or(0.0, |(_, x, _)| f(x)))
                    .collect()
            };
            RigidMotion {
                tangential_x: of(&|_| arm),
                tangential_y: vec![0.0; N],
                opening: of(&|x| x),
                work,
            }
        })
        .collect()
}

/// The conditions of contact, each relative to its own parts.
fn check(
    ground: &Ground,
    contact: &SlidingContact<'_>,
    found: &SlidingSolution,
) -> Result<(), TestCaseError> {
    prop_assert_eq!(found.status, Status::Solved);
    prop_assert!(found.residual < 1e-9, "residual {}", found.residual);
    let p = &found.pressure;
    let mut scale = contact.gap.iter().fold(1.0_f64, |m, g| m.max(g.abs()));
    let mut gap = contact.gap.to_vec();
    for i in 0..N {
        for j in 0..N {
            let friction = contact.friction[j] * contact.direction[j];
            gap[i] += p[j]
                * (ground.entry(i, j, Component::Normal)
                    + friction * ground.entry(i, j, Component::X));
        }
        for (motion, c) in contact.motions.iter().zip(&found.motion) {
            gap[i] += c * motion.opening[i];
            scale = scale.max((c * motion.opening[i]).abs());
        }
    }
    for i in 0..N {
        prop_assert!(
            p[i] >= 0.0 && gap[i] > -1e-9 * scale,
            "{i}: {} {}",
            p[i],
            gap[i]
        );
        prop_assert!(
            p[i] == 0.0 || gap[i] < 1e-9 * scale,
            "{i}: {} {}",
            p[i],
            gap[i]
        );
    }
    for motion in contact.motions {
        let works = (0..N).map(|i| {
            let slid = contact.friction[i] * contact.direction[i] * motion.tangential_x[i];
            p[i] * contact.area[i] * (motion.opening[i] + slid)
        });
        let unit = contact.area[0] * motion.opening[0].abs().max(motion.opening[N - 1].abs());
        let least = 1e-5 * unit * p.iter().copied().fold(0.0, f64::max);
        let (sum, size) = works.fold((motion.work, motion.work.abs()), |(sum, size), w| {
            (sum + w, size + w.abs())
        });
        prop_assert!(
            sum.abs() <= 1e-9 * size.max(least),
            "balance {sum} of {size}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(25))]
    #[test]
    fn a_pole_that_lifts_is_solved_from_any_start(
        coupling in 0.0..0.2_f64,
        friction in prop_oneof![Just(0.0), 0.0..0.4_f64],
        crown in -0.01..0.02_f64,
        small in prop_oneof![Just(0.0), (-9.0..-3.0_f64).prop_map(|e| 10.0_f64.powf(e))],
        walk in prop::collection::vec((-0.3..1.0_f64, -0.1..0.1_f64, any::<bool>()), 3..12),
    ) {
        let ground = Ground { coupling };
        let mut stepper =
            SlidingStepper::new(Arc::new(Influence::of(&ground, &unmonitored).unwrap()));
        let direction = [vec![1.0; N], vec![0.0; N]].concat();
        let matrix = SlidingMatrix::new(&ground, &direction, true, &unmonitored).unwrap();
        for (lift, twist, is_loaded) in walk {
            let gap: Vec<f64> = (0..N)
                .map(|i| match place(i) {
                    (true, x, y) => lift + crown * x * x + twist * x + 0.05 * y,
                    (false, x, _) => -1.0 + crown * x * x,
                })
                .collect();
            // a pull that turns the first pole one way; where it is lifted, it turns until it touches
            let motions = tilts(0.4, [0.0, if is_loaded { small } else { 0.0 }]);
            let contact = SlidingContact {
                gap: &gap,
                area: &[1.0; N],
                friction: &[friction; N],
                direction: &direction,
                motions: &motions,
                diagonal: None,
                interface: None,
            };
            let (step, _) = stepper.solve(&contact, &unmonitored).unwrap();
            let cold = matrix.solve(&contact, None, &unmonitored).unwrap();
            check(&ground, &contact, &step)?;
            check(&ground, &contact, &cold)?;
            if friction == 0.0 {
                // then the pressure is unique
                let most = cold.pressure.iter().copied().fold(0.0, f64::max);
                for (a, b) in step.pressure.iter().zip(&cold.pressure) {
                    prop_assert!((a - b).abs() <= 1e-9 * most, "{a} {b}");
                }
            }
        }
    }
}

/// The same state by products as by matrices, friction and both tilts included.
#[test]
fn products_give_the_state_of_the_matrices() {
    let ground: Arc<dyn Compliance> = Arc::new(Ground { coupling: 0.3 });
    let pair = Arc::new(Relative::new(Some(ground.clone()), None).unwrap());
    let direction: Vec<f64> = (0..2 * N).map(|k| if k < N { 1.0 } else { 0.0 }).collect();
    let gap: Vec<f64> = (0..N).map(|i| 1.5 * place(i).1.powi(2)).collect();
    let motions: Vec<RigidMotion> = [|_: f64| 1.0, |x: f64| x]
        .into_iter()
        .zip([-20.0, 3.0])
        .map(|(opening, work)| RigidMotion {
            tangential_x: vec![0.0; N],
            tangential_y: vec![0.0; N],
            opening: (0..N).map(|i| opening(place(i).1)).collect(),
            work,
        })
        .collect();
    let area: Vec<f64> = (0..N).map(|i| 1.0 + 0.1 * (i % 3) as f64).collect();
    let softer: Vec<f64> = (0..N).map(|i| 0.3 * ((i % 4) as f64 - 1.0)).collect();
    for (friction, diagonal) in [(0.0, None), (0.4, None), (0.4, Some(&*softer))] {
        let contact = SlidingContact {
            gap: &gap,
            area: &area,
            friction: &[friction; N],
            direction: &direction,
            motions: &motions,
            diagonal,
            interface: None,
        };
        let dense = SlidingMatrix::new(&*pair, &direction, true, &unmonitored).unwrap();
        let products = SlidingMatrix::by_products(pair.clone(), &direction, true).unwrap();
        assert!(dense.is_coupled() && products.is_coupled());
        let expected = dense.solve(&contact, None, &unmonitored).unwrap();
        let found = products.solve(&contact, None, &unmonitored).unwrap();
        assert_eq!(expected.status, Status::Solved);
        assert_eq!(found.status, Status::Solved);
        let open = expected.pressure.iter().filter(|p| **p == 0.0).count();
        assert!((1..N).contains(&open), "{open} of {N} points are open");
        let largest = expected.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
        for (a, b) in found.pressure.iter().zip(&expected.pressure) {
            assert!((a - b).abs() < 1e-7 * largest, "{a} {b}");
        }
        for (a, b) in found.motion.iter().zip(&expected.motion) {
            assert!((a - b).abs() < 1e-7 * b.abs(), "{a} {b}");
        }
        let factor = products
            .wedging_factor(&area, &[friction; N], &motions, diagonal, &unmonitored)
            .unwrap();
        assert!(factor.is_nan());
    }
}
