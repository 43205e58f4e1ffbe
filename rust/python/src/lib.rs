// SPDX-License-Identifier: MIT OR Apache-2.0
//! Python bindings: one file per crate, no arithmetic.
//!
//! A bound function checks shapes, borrows its arrays, lets go of the interpreter, calls, maps the
//! error, and hands the owned results over.

#![allow(
    clippy::needless_pass_by_value,
    reason = "extracted arguments are owned"
)]

mod contact;
mod elasticity;
mod error;
mod geometry;
mod heat;
mod in_rows;
mod magnet;
mod normal;
mod operator;
mod prepared;
mod prism;
mod problem;
mod solid;
mod stress;
mod stuck;
mod tangent;
mod tangential;
mod tetra;
mod vibrating;
mod wear;
mod wheelset;

use pyo3::prelude::*;

/// The compiled core of `mtb_rs`; private, use the package.
#[pymodule]
mod _mtb_rs {
    #[pymodule_export]
    use super::contact::{
        PyIncrementalOptions, PyIncrementalOutcome, PyStaggeredOutcome, solve_incremental,
        solve_staggered,
    };
    #[pymodule_export]
    use super::elasticity::{
        PyLayered, carried, half_space, half_space_cut_hats, half_space_gaussians, half_space_hats,
        refined,
    };
    #[pymodule_export]
    use super::geometry::{
        PyBodySurface, PyContactGrid, PyContactPoints, PyProfile, PySlices, PyWheelRailGap,
        pole_shoe_grid, read_columns, read_profile, standing_wheelsets, surface_gap,
        wheel_on_rail_gap,
    };
    #[pymodule_export]
    use super::heat::{
        PyConductingBody, PyConductionModes, PyConductionStep, PySeen, PyStepControl,
        moving_half_space, rolling_temperatures, step_error, swelling,
    };
    #[pymodule_export]
    use super::magnet::{PyMagneticCircuit, PySettled};
    #[pymodule_export]
    use super::normal::{
        PyNormalOutcome, PyNormalTangent, available_address_space, available_memory, normal_memory,
        sliding_memory, solve_normal,
    };
    #[pymodule_export]
    use super::operator::PyCompliance;
    #[pymodule_export]
    use super::prepared::PyPreparedContact;
    #[pymodule_export]
    use super::prism::{
        PyNormalPrisms, PyPrismPair, PyPrismRows, PySection, block_section, outline_section, prism,
        rail_outline, rail_section,
    };
    #[pymodule_export]
    use super::problem::{PyContactGeometry, PyLoading, PyOutcome, PyProblem, stick_or_slip_held};
    #[pymodule_export]
    use super::solid::{
        block_mesh, check_unknowns, held_points, nearest_nodes, pole_mesh, quadratic_mesh,
        rail_lines, rail_mesh, tetrahedra,
    };
    #[pymodule_export]
    use super::stress::{dang_van, stress_at, stress_below};
    #[pymodule_export]
    use super::stuck::PyStickSlip;
    #[pymodule_export]
    use super::tangent::PyTangent;
    #[pymodule_export]
    use super::tangential::{
        PyFoundationOutcome, PyFriction, PyPatchOperators, PyTangentialChange, PyTangentialOutcome,
        PyTangentialTangent, fastsim_curve, kalker_coefficients, polach_curve,
    };
    #[pymodule_export]
    use super::tetra::{PySampling, PyTetraBody, PyTetraMesh, flexibility};
    #[pymodule_export]
    use super::vibrating::PyVibratingContact;
    #[pymodule_export]
    use super::wear::{PyWearStep, wear_contact, wear_problem};
    #[pymodule_export]
    use super::wheelset::{
        PyPreparedWheels, PyWheelChange, PyWheelOutcome, PyWheelPatch, PyWheelTangent,
    };
    use super::{Bound, PyAnyMethods, PyModule, PyModuleMethods, PyResult};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("CONDENSATION_DIGEST", mtb_elasticity::tetra::DIGEST)?;
        module.add("PRODUCTS_FROM", mtb_contact::sliding::PRODUCTS_FROM)?;
        module.add("PATH_TOLERANCE", mtb_contact::coupled::PATH_TOLERANCE)?;
        let not_converged = module.py().get_type::<super::wheelset::NotConverged>();
        module.add("NotConverged", not_converged)?;
        let too_large = module.py().get_type::<super::error::TooLargeError>();
        module.add("TooLargeError", too_large)?;
        module.add(
            "FACTOR_MEMORY",
            mtb_elasticity::tetra::Limits::default().bytes,
        )?;
        // what is exported is said once, in the stub
        module.delattr("__all__")
    }
}
