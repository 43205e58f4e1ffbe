/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Prepared sliding contacts for multibody programs. SI units; forces act on the lower body.
   Generated from rust/capi/src/lib.rs: do not edit. */

#ifndef MTB_H
#define MTB_H

#include <stdint.h>

// How a call ended.
typedef enum mtb_status {
  // All is well.
  MTB_STATUS_OK = 0,
  // An argument cannot be: the message says which.
  MTB_STATUS_BAD_ARGUMENT = 1,
  // The file cannot be read, or holds no prepared contact.
  MTB_STATUS_BAD_FILE = 2,
  // No sliding state exists: the body wedges.
  MTB_STATUS_NO_SOLUTION = 3,
  // The resultant of the load lies outside the contact, or no solution was found.
  MTB_STATUS_NOT_CONVERGED = 4,
  // A fault of this library.
  MTB_STATUS_INTERNAL = 5,
} mtb_status;

// What a step took.
typedef struct mtb_effort {
  // Active sets.
  uint64_t sets;
  // Factorisations.
  uint64_t factorisations;
  // Products with the influence matrix, and solves with its factors.
  uint64_t products;
  // Relative complementarity residual.
  double residual;
} mtb_effort;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of the library, for example "0.1.0".
const char *mtb_version(void);

// Why the last call on this thread failed; empty if it did not. Valid until the next call on this thread.
const char *mtb_last_error_message(void);

// Reads a contact that Python's `PreparedContact.save` wrote.
//
// `path`: text in UTF-8, ended by a zero. `contact`: gets the handle, which `mtb_contact_free` gives back.
//
// # Safety
// `path` must be such a text, `contact` must point to a number.
enum mtb_status mtb_contact_load(const char *path,
                                 uint64_t *contact);

// Another contact without memory that shares the matrices of this one, for a second shoe or thread.
//
// # Safety
// `copy` must point to a number.
enum mtb_status mtb_contact_copy(uint64_t contact, uint64_t *copy);

// Gives a contact back.
enum mtb_status mtb_contact_free(uint64_t contact);

// Numbers of contact points and of motions found from balance.
//
// # Safety
// `points` and `motions` must point to numbers.
enum mtb_status mtb_contact_size(uint64_t contact, uint64_t *points, uint64_t *motions);

// Contact points and normals of the lower body (3 n each: all x, all y, all z) [m], areas (n) [m2].
//
// `n`: the number of points, as `mtb_contact_size` tells.
//
// # Safety
// The arrays must be of these lengths.
enum mtb_status mtb_contact_points(uint64_t contact,
                                   uint64_t n,
                                   double *points,
                                   double *normals,
                                   double *areas);

// The point that moments and rotations are about [m].
//
// # Safety
// `point` must have room for 3 numbers.
enum mtb_status mtb_contact_reference_point(uint64_t contact, double *point);

// Solves the contact at one instant, from the memory of the last step.
//
// `pose` (6): displacement of the upper body from its reference, x, y, z [m], roll, pitch, yaw [rad];
// NaN, or a null pointer for all: found from balance where free, else zero. `velocity` (2): of the upper
// body over the lower one, x and y [m/s]. `magnetic_pressure` [Pa]: uniform, in place of the scene's;
// NaN: the scene's. Out: `force` (3) [N] on the lower body, `moment` (3) [N m] of it about the
// reference point, and, unless null, `effort`.
//
// # Safety
// The arrays must be of these lengths.
enum mtb_status mtb_contact_step(uint64_t contact,
                                 const double *pose,
                                 const double *velocity,
                                 double magnetic_pressure,
                                 double *force,
                                 double *moment,
                                 struct mtb_effort *effort);

// Mean pressure over each of the `n` points [Pa] in the last step that was solved.
//
// # Safety
// `pressure` must have room for `n` numbers.
enum mtb_status mtb_contact_pressure(uint64_t contact, uint64_t n, double *pressure);

// Gap at each of the `n` points [m] in the last step that was solved.
//
// # Safety
// `gap` must have room for `n` numbers.
enum mtb_status mtb_contact_gap(uint64_t contact, uint64_t n, double *gap);

// The state after the last step that was solved, `n` numbers for `mtb_contact_resume`.
//
// # Safety
// `state` must have room for `n` numbers.
enum mtb_status mtb_contact_state(uint64_t contact, uint64_t n, double *state);

// Starts the next step from a state of `mtb_contact_state` in place of the memory, for steps taken again.
//
// # Safety
// `state` must hold `n` numbers.
enum mtb_status mtb_contact_resume(uint64_t contact,
                                   uint64_t n,
                                   const double *state);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MTB_H */
