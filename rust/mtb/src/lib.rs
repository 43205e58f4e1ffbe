// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frictional elastic contact, from bodies to pressures.
//!
//! This crate gathers what a program needs to press elastic bodies together and let them slide, stick, slip
//! or roll. SI units everywhere; z points up, from the lower body to the upper one; forces and tractions act on
//! the lower body; a gap is positive where it is open, a pressure where it pushes apart.
//!
//! # 1. Bodies
//!
//! A contact asks one thing of a body: how its contact points give way to tractions. That is the trait
//! [`Compliance`]. Half-spaces ([`elasticity::half_space`]) and finite elements ([`elasticity::tetra`]) have
//! it, and so has whatever you write yourself: the example `own_compliance` presses a ball on a lining of
//! springs. Shapes come from [`geometry`]: [`Profile`]s of rails and wheels, the [`PoleShoe`] of a track brake,
//! gaps between arbitrary surfaces, and solids filled with tetrahedra ([`geometry::solid`]).
//!
//! # 2. Contact
//!
//! Two bodies that stand on each other are a [`Contact`]. It is pressed by [`Load`]s, several at once: a force,
//! moments, an approach, a pull at the surface as magnets exert it. Two balls of steel, 0.1 m in radius each, under 200 N, against
//! Hertz:
//!
//! ```
//! use mtb::{Grid, Load, STEEL, descent, half_spaces, unmonitored};
//!
//! let (radius, force) = (0.1 / 2.0, 200.0);
//! let grid = Grid::new(40, 40, 0.05e-3, 0.05e-3)?;
//! let gap = |x: f64, y: f64| (x * x + y * y) / (2.0 * radius);
//! let balls = half_spaces(Some(STEEL), Some(STEEL), grid, gap, vec![descent(1600)])?;
//! let state = balls.press(&[Load::Force(force)], &unmonitored)?;
//!
//! let modulus = STEEL.shear_modulus / (1.0 - STEEL.poisson_ratio); // E* of two alike
//! let by_hertz = (6.0 * force * modulus.powi(2) / (radius.powi(2) * 31.006)).cbrt(); // pi^3
//! assert!((state.peak_pressure() / by_hertz - 1.0).abs() < 0.02);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! Loads add up. The same ball over a plane that it may tilt on, under a force beside its middle:
//!
//! ```
//! use mtb::{Grid, Load, STEEL, descent, half_spaces, tilts, unmonitored};
//!
//! let grid = Grid::new(30, 30, 0.5e-3, 0.5e-3)?;
//! let [about_x, about_y] = tilts(grid);
//! let motions = vec![descent(grid.points()), about_x, about_y];
//! let contact = half_spaces(Some(STEEL), None, grid, |x, y| (x * x + y * y) / 2.0, motions)?;
//! let loads = [Load::Force(600.0), Load::Moments([0.0, -0.3])];
//! let state = contact.press(&loads, &unmonitored)?;
//! assert!((state.outcome.force[2] + 600.0).abs() < 1e-6);
//! assert!((state.outcome.moment[1] + 0.3).abs() < 1e-6);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! A body takes an approach only if it is held along z; one that is free along z takes forces and pulls. Bodies that
//! never touch are an error, and so is a contact of half-spaces that runs over the edge of its grid.
//!
//! Elastic bodies of finite elements stand in ready scenes: [`BlockOnPlane`] and [`PoleShoeOnRail`], whose rail may
//! be elastic as well ([`Rail`]). They are meshed, held ([`Held`]), and condensed onto their contact points once;
//! each load then costs its solve alone. [`BodyOnPlane`] takes a mesh of your own and the nodes that hold it
//! ([`Support`]). A bar that is clamped on top and pressed down by 1 um:
//!
//! ```
//! use mtb::geometry::solid::{Filling, block};
//! use mtb::{BodyOnPlane, Hold, Load, Material, Support, unmonitored};
//!
//! let (x, y) = ([-0.02, -0.01, 0.0, 0.01, 0.02], [-0.01, 0.0, 0.01]);
//! let mesh = block(&x, &y, 0.02, Filling::default())?;
//! let top = (0..mesh.nodes.len()).filter(|i| mesh.nodes[*i][2] > 0.02 - 1e-9);
//! let bar = BodyOnPlane {
//!     supports: vec![Support {
//!         name: "glued".to_owned(),
//!         nodes: top.collect(),
//!         hold: [Hold::Prescribed; 3],
//!     }],
//!     mesh,
//!     material: Material { shear_modulus: 1e9, poisson_ratio: 0.0 },
//!     face: [0.04, 0.02],
//!     spacing: [0.01; 2],
//!     lower: None,
//! };
//! let state = bar.stand(&unmonitored)?.press(&[Load::Approach(1e-6)], &unmonitored)?;
//! let by_hooke = 2e9 * 1e-6 / 0.02 * 0.04 * 0.02; // E d / h over the face
//! assert!((-state.outcome.force[2] / by_hooke - 1.0).abs() < 1e-3);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! This crate does not estimate the error of a result; the package for Python does. Here, solve with narrower cells
//! as well, and compare.
//!
//! # 3. Friction
//!
//! [`Contact::slide`] finds the pressure under which the upper body slides: friction changes it where it tilts
//! or bends a body. [`Friction`] is a field, or follows the pressure. A block that is pushed by friction at its
//! foot leans forward, so its front carries more:
//!
//! ```
//! use mtb::{BlockOnPlane, Body, Friction, Held, Load, STEEL, unmonitored};
//!
//! let block = BlockOnPlane {
//!     size: [0.06, 0.04, 0.03],
//!     spacing: [0.01; 2],
//!     held: Held::DrivenTop,
//!     upper: STEEL,
//!     lower: None,
//! };
//! let contact = block.stand(&unmonitored)?;
//! let n = contact.points();
//! let pull = vec![1e6; n];
//! let load = Load::Pull(&pull, Body::Upper);
//! let state = contact.slide(&[load], [1.0, 0.0], Friction::Field(&vec![0.2; n]), &unmonitored)?;
//!
//! let [fx, _, fz] = state.outcome.force;
//! assert!((-fz / (1e6 * 0.06 * 0.04) - 1.0).abs() < 1e-9);
//! assert!((fx / (-0.2 * fz) - 1.0).abs() < 1e-9);
//! // points run along x first
//! assert!(state.pressure[n / 2 + 3] > state.pressure[n / 2 - 3]);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! Points that stick and points that slip are found by
//! [`Problem::stick_or_slip`](contact::problem::Problem::stick_or_slip), here under a ball that is pushed along x:
//!
//! ```
//! use mtb::contact::coupled::PointState;
//! use mtb::{Grid, Load, STEEL, descent, half_spaces, unmonitored};
//!
//! let grid = Grid::new(16, 16, 0.1e-3, 0.1e-3)?;
//! let gap = |x: f64, y: f64| (x * x + y * y) / 0.1;
//! let contact = half_spaces(Some(STEEL), Some(STEEL), grid, gap, vec![descent(256)])?;
//! let (problem, friction) = (&contact.problem, vec![0.3; 256]);
//! let push = |way: f64| problem.geometry().uniform([way, 0.0, 0.0]);
//! let loading = contact.loading(&[Load::Force(100.0)])?;
//! let pushes = [push(0.2e-6), push(5e-6)];
//! let steps = problem.stick_or_slip(&loading, &friction, 0.0, &pushes, 1e-9, &unmonitored)?;
//! assert!(steps.iter().all(|step| step.unsolved().is_none()));
//! assert!(steps[0].points.contains(&PointState::Stick));
//! // far enough it slides
//! assert!(!steps[1].points.contains(&PointState::Stick));
//! assert!((steps[1].force[0] - 0.3 * 100.0).abs() < 1e-6);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! A simulation that asks once a step keeps a [`prepared`](contact::prepared) contact, which takes pose and velocity:
//!
//! ```
//! use std::sync::Arc;
//!
//! use mtb::contact::prepared::{Prepared, PreparedContact, Pull, Sliding, Step, Table};
//! use mtb::{Grid, Load, STEEL, descent, half_spaces, unmonitored};
//!
//! let grid = Grid::new(16, 16, 0.1e-3, 0.1e-3)?;
//! let gap = |x: f64, y: f64| (x * x + y * y) / 0.1;
//! let contact = half_spaces(Some(STEEL), Some(STEEL), grid, gap, vec![descent(256)])?;
//! let sliding = Sliding {
//!     // falls from 0.4 to 0.2 between standstill and 10 m/s
//!     friction: Table::new(vec![0.0, 10.0], vec![vec![0.4; 256], vec![0.2; 256]])?,
//!     direction: [1.0, 0.0],
//!     standstill_speed: None,
//!     velocity: None,
//!     layer: 0.0,
//! };
//! let prepared = Prepared::new(
//!     &contact.problem,
//!     &contact.loading(&[Load::Force(100.0)])?,
//!     None,
//!     vec![("z".to_owned(), Some(2))], // names of the free motions, and what they are of the pose
//!     sliding,
//!     [0.0; 3],
//!     &unmonitored,
//! )?;
//! let mut contact = PreparedContact::new(Arc::new(prepared));
//! // all of the pose from balance
//! let step = Step { pose: [f64::NAN; 6], velocity: [5.0, 0.0], pull: Pull::Scene, gap: None, friction: None, diagonal: None, shift: None };
//! let state = contact.step(&step, &unmonitored)?;
//! assert_eq!(state.unsolved(), None);
//! assert!((state.force[0] - 0.3 * 100.0).abs() < 1e-6);
//! # Ok::<(), mtb::Error>(())
//! ```
//!
//! # 4. Rolling
//!
//! [`PreparedWheels`] takes pose and velocity of a wheelset once a step and gives forces, moments and tractions
//! on the rails; [`contact::tangential`] rolls any two half-spaces. See the example `rolling_wheel`.
//!
//! # Further
//!
//! The crates behind this one are its modules: [`geometry`], [`operator`], [`complementarity`],
//! [`elasticity`], [`heat`], [`contact`], [`wheelset`]. Anything that may take long takes a [`Monitor`], which can
//! interrupt it; [`unmonitored`] never does.
//!
//! **References.** [Johnson1985], [Steininger2025].

mod contact_of_two;
mod error;
mod held;
mod scenes;
mod standing;

pub use mtb_complementarity as complementarity;
pub use mtb_contact as contact;
pub use mtb_elasticity as elasticity;
pub use mtb_geometry as geometry;
pub use mtb_heat as heat;
pub use mtb_operator as operator;
pub use mtb_wheelset as wheelset;

pub use contact_of_two::{Contact, State, descent, tilts};
pub use error::Error;
pub use held::Held;
pub use mtb_contact::problem::{Body, FreeMotion, Friction, Load};
pub use mtb_elasticity::Material;
pub use mtb_elasticity::tetra::{Hold, Support};
pub use mtb_geometry::{PoleShoe, Profile, WheelOnRail};
pub use mtb_operator::{Compliance, Component, Grid, Monitor, Relative, unmonitored};
pub use mtb_wheelset::{PreparedWheels, Wheelset};
pub use scenes::{BlockOnPlane, BodyOnPlane, PoleShoeOnRail, Rail, STEEL, half_spaces};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
