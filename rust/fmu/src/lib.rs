// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepared contacts as functional mock-up units for co-simulation: FMI 2.0 [Blochwitz2012] and FMI 3.0
//! [ModelicaAssociation2022].
//!
//! **What.** The functions of the FMI standard over one contact that Python prepared: a sliding contact
//! (`resources/contact.mtbc`) or wheels on rails (`resources/wheels.mtbw`, or `transient_wheels.mtbw`, whose steps roll
//! on from the last one). `PreparedContact.save_fmu` and `PreparedWheels.save_fmu` pack it with this library and the
//! description of its variables.
//!
//! **Not here.** No mechanics: a step reads the inputs, calls [`mtb_contact::prepared`] or [`mtb_wheelset`] and keeps
//! the outputs.
//!
//! **Conventions.** SI units; forces on the lower body, or on the rails. `resources/variables.txt` lists the variables
//! of the description with their value references, sizes and first values; what is no input there is left to balance,
//! or to what was prepared. A unit knows nothing of a version of the standard: with the description of FMI 2 its
//! variables are single numbers, with that of FMI 3 some are arrays. Messages go to the logger of the importing
//! program.
//!
//! Unsafe code is allowed in this crate for two things: names that a loader finds, and the pointers of the
//! importing program, which are checked against null here and must otherwise be as the standard says.

#![allow(
    unsafe_code,
    reason = "exported names and the pointers of the importing program; nothing else"
)]
#![allow(non_snake_case, reason = "the names are the standard's")]

mod contact;
pub mod fmi2;
pub mod fmi3;
mod instance;
mod resources;
mod sliding;
mod unit;
mod variables;
mod wheels;

/// An error in words.
fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}
