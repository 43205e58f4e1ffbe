/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Prepared sliding contacts and wheels on rails for multibody programs. SI units; forces act on the
   lower body, the rail. Generated from rust/capi/src: do not edit.

   - A function returns a status. If it is not MTB_STATUS_OK, nothing is written through its pointers, and
     mtb_last_error_message says why.
   - A null pointer leaves out an output of a function that has several ones. The only output of a function,
     and inputs where nothing else is said, must not be null.
   - Handles are numbers, for any thread. Calls with one handle wait for each other; copies share the matrices
     and run side by side, one for each thread. The message of a failure is that of the calling thread.
   - The memory of the last step decides how long a step takes, not what comes out.
   - The first call starts worker threads, as many as there are processors; the environment variable
     RAYON_NUM_THREADS, read then, asks for fewer. Each thread that multiplies matrices, the callers' as well,
     keeps address space of twice the outermost cache of the machine (VmSize, not resident memory).
   - The library can be forked: the child works in the calling thread alone. */


#ifndef MTB_H
#define MTB_H

#include <stdint.h>

/*
 How a call ended.
 */
typedef enum mtb_status {
  /*
   All is well.
   */
  MTB_STATUS_OK = 0,
  /*
   An argument cannot be: the message says which.
   */
  MTB_STATUS_BAD_ARGUMENT = 1,
  /*
   The file cannot be read, or does not hold what is to be loaded.
   */
  MTB_STATUS_BAD_FILE = 2,
  /*
   No sliding state exists: the body wedges.
   */
  MTB_STATUS_NO_SOLUTION = 3,
  /*
   The resultant of the load lies outside the contact, no height carries the force of the wheels, or no
   solution was found.
   */
  MTB_STATUS_NOT_CONVERGED = 4,
  /*
   A fault of this library.
   */
  MTB_STATUS_INTERNAL = 5
} mtb_status;

/*
 What a step took.
 */
typedef struct mtb_effort {
  /*
   Active sets.
   */
  uint64_t sets;
  /*
   Factorisations.
   */
  uint64_t factorisations;
  /*
   Products with the influence matrix, and solves with its factors.
   */
  uint64_t products;
  /*
   Relative complementarity residual.
   */
  double residual;
} mtb_effort;

/*
 Contact load of a step of wheels.
 */
typedef struct mtb_wheel_step {
  /*
   Force of all patches on the rails [N].
   */
  double force[3];
  /*
   Moment of it about the reference point [N m].
   */
  double moment[3];
  /*
   Vertical force that the wheels press on the left and on the right rail with, friction included [N].
   */
  double vertical_force[2];
  /*
   What the vertical force departs by from the one that the height was to be found for, over that: the largest
   departure, with its sign, below 1e-8 but at a small jump of the force. NaN where the height was given.
   */
  double balance_error;
  /*
   The reference point, where the pose has put it [m].
   */
  double reference_point[3];
  /*
   The pose, with what was found from balance: x, y, z [m], roll, pitch, yaw [rad].
   */
  double pose[6];
  /*
   Heat of sliding [W].
   */
  double friction_power;
  /*
   Number of patches; none where the wheels are lifted.
   */
  uint64_t patches;
  /*
   Normal problems, of all patches and trials of the height.
   */
  uint64_t normal_solves;
  /*
   Newton steps of the tangential problems.
   */
  uint64_t iterations;
} mtb_wheel_step;

/*
 What else a step of wheels may be given, and what it found of it. Left first, then right.
 */
typedef struct mtb_wheel_conditions {
  /*
   Force of all wheels on the rails along y [N], for which y of the pose, NaN, is found with the height; NaN: y is
   given.
   */
  double lateral_force;
  /*
   Force of all wheels on the rails along x [N], for which the rotation about the axle is found; NaN: none.
   */
  double longitudinal_force;
  /*
   Moment of the forces on the rails about the axle [N m] in place of it, 0 for free rolling; NaN: none.
   */
  double axle_moment;
  /*
   Curvature of the track [1/m], > 0 in a curve to the left; the velocity is then relative to a frame that goes
   along the track.
   */
  double curvature;
  /*
   Rails beside their places: y, z [m], rotation about x [rad].
   */
  double rails[2][3];
  /*
   Their rates [m/s], [rad/s].
   */
  double rail_rates[2][3];
  /*
   Wheels beside their places on the wheelset: x, y, z [m], rotation about x, y, z [rad], in axes that roll and yaw
   turn and the pitch does not.
   */
  double wheels[2][6];
  /*
   Their rates [m/s], [rad/s].
   */
  double wheel_rates[2][6];
  /*
   Out: velocity [m/s] and rotation [rad/s] of the wheelset, with what was found.
   */
  double velocity[6];
  /*
   Out: displacement of the rails along y and z [m], that of their springs included.
   */
  double rail_displacement[2][2];
} mtb_wheel_conditions;

/*
 A contact patch, in its own frame: x along the rail, y across, normal from the rail to the wheel.
 */
typedef struct mtb_wheel_patch {
  /*
   1 for the left wheel, -1 for the right one.
   */
  int64_t side;
  /*
   Points along x.
   */
  uint64_t nx;
  /*
   Points along y.
   */
  uint64_t ny;
  /*
   First point, x and y [m].
   */
  double start[2];
  /*
   Distance of the points along x and y [m].
   */
  double spacing[2];
  /*
   Origin of the frame, in the track [m].
   */
  double position[3];
  /*
   Directions of x, y and normal in the track, three numbers each.
   */
  double directions[3][3];
  /*
   Slope of the contact plane [rad], > 0 where it rises to the field side (flange contact).
   */
  double contact_angle;
  /*
   y of the origin in the rail profile's own frame [m].
   */
  double rail_position;
  /*
   y of the origin in the wheel profile's own frame [m].
   */
  double wheel_position;
  /*
   Largest overlap of the undeformed bodies along the normal [m].
   */
  double approach;
  /*
   Rigid slip of the wheel over the rail at the origin, over the rolling speed: xi, eta [-], phi [1/m].
   */
  double creepage[3];
  /*
   Mean of the speeds at which the patch runs over rail and wheel [m/s]; > 0 along x.
   */
  double rolling_speed;
  /*
   Sum of pressure times area [N].
   */
  double normal_force;
  /*
   Share of the estimated contact area inclined too much against the plane to be represented by it [-].
   */
  double neglected;
  /*
   Heat of sliding [W].
   */
  double friction_power;
} mtb_wheel_patch;

#ifdef __cplusplus
extern "C" {
#endif /* __cplusplus */

/*
 Version of the library, for example "0.1.0".
 */
const char *mtb_version(void);

/*
 Why the last call on this thread failed; empty if it did not. Valid until the next call on this thread.
 */
const char *mtb_last_error_message(void);

/*
 Reads a contact that Python's `PreparedContact.save` wrote.

 `path`: text in UTF-8, ended by a zero. `contact`: gets the handle, which `mtb_contact_free` gives back.

 # Safety
 `path` must be such a text, `contact` must point to a number.
 */
enum mtb_status mtb_contact_load(const char *path,
                                 uint64_t *contact);

/*
 Another contact without memory that shares the matrices of this one, for a second shoe or thread.

 # Safety
 `copy` must point to a number.
 */
enum mtb_status mtb_contact_copy(uint64_t contact, uint64_t *copy);

/*
 Gives a contact back.
 */
enum mtb_status mtb_contact_free(uint64_t contact);

/*
 Numbers of contact points and of motions found from balance. A null pointer leaves one out.

 # Safety
 `points` and `motions` must point to numbers or be null.
 */
enum mtb_status mtb_contact_size(uint64_t contact, uint64_t *points, uint64_t *motions);

/*
 Name of a motion found from balance, counted from 0, for example "left z", and what it is of the pose.

 `name`: room for `length` bytes, the zero at its end included; a name takes at most 64 as a rule, and a room
 that is too small is refused with the length needed. `component`: 0 to 5, the component of the pose (x, y, z,
 roll, pitch, yaw) that takes its place when it is prescribed, or -1 where none does. A null pointer leaves one
 out.

 # Safety
 `name` must have this room or be null, `component` must point to a number or be null.
 */
enum mtb_status mtb_contact_motion(uint64_t contact,
                                   uint64_t index,
                                   uint64_t length,
                                   char *name,
                                   int32_t *component);

/*
 Contact points and normals of the lower body (3 n each: all x, all y, all z) [m], areas (n) [m2].

 `n`: the number of points, as `mtb_contact_size` tells. A null pointer leaves a field out.

 # Safety
 The arrays must be of these lengths.
 */
enum mtb_status mtb_contact_points(uint64_t contact,
                                   uint64_t n,
                                   double *points,
                                   double *normals,
                                   double *areas);

/*
 The point that moments and rotations are about [m]. It was chosen when the contact was prepared and stays
 where it is, whatever the pose; that of wheels moves with them.

 # Safety
 `point` must have room for 3 numbers.
 */
enum mtb_status mtb_contact_reference_point(uint64_t contact,
                                            double *point);

/*
 Solves the contact at one instant, from the memory of the last step.

 `pose` (6): displacement of the upper body from its reference, x, y, z [m], roll, pitch, yaw [rad]: turned about
 the fixed x, then y, then z axis through the reference point, then shifted. NaN, or a null pointer for all: found
 from balance where free, else zero. The contact points stay on the lower body and the gap over them changes by
 the displacement along their normals: x changes nothing where no normal leans along x, as on a straight rail, and
 a displacement must stay small against the radii of the surfaces. `velocity` (2): of the upper body over the lower
 one, x and y [m/s]; only its direction counts unless friction or pull are tables over the speed.
 `magnetic_pressure` [Pa]: uniform, in place of the scene's; NaN: the scene's, also that of a magnet whose pull follows
 the gap, with the ampere-turns of `mtb_contact_set_ampere_turns`. No number may be larger than 1e30.
 Out, each left out by a null pointer: `force` (3) [N] on the lower body, `moment` (3) [N m] of it about the
 reference point, `effort`. A contact that the edge of its grid would cut off, while the bodies go on, is a bad
 argument.

 # Safety
 The arrays must be of these lengths or null.
 */
enum mtb_status mtb_contact_step(uint64_t contact,
                                 const double *pose,
                                 const double *velocity,
                                 double magnetic_pressure,
                                 double *force,
                                 double *moment,
                                 struct mtb_effort *effort);

/*
 Solves the contact at the end of a displacement of the upper body over the lower one, from the last step on: points
 stick or slip, and keep their tractions from step to step.

 As `mtb_contact_step`, for a contact that Python's `PreparedContact.save` wrote with `shift=True`. `shift` (2):
 displacement since the last step, x and y [m], besides the change of `pose`, which displaces points as well. `velocity`
 (2): only its size counts, as the speed of tables. The first step starts from the bodies pressed together without
 friction, and so does one after `mtb_contact_resume`; after a step that was not solved the one before it counts. Here
 the memory decides what comes out: to take a step again, keep what `mtb_contact_memory` gives before it.

 # Safety
 The arrays must be of these lengths or null; `shift` must not be null.
 */
enum mtb_status mtb_contact_step_shifted(uint64_t contact,
                                         const double *pose,
                                         const double *velocity,
                                         const double *shift,
                                         double magnetic_pressure,
                                         double *force,
                                         double *moment,
                                         struct mtb_effort *effort);

/*
 Ampere-turns [A] of the magnet, whose pull follows the gap, in all steps from here on; 0: switched off, NaN: those with
 which it was prepared.

 A contact without such a magnet is a bad argument. A copy of a contact begins with those with which it was prepared.
 */
enum mtb_status mtb_contact_set_ampere_turns(uint64_t contact,
                                             double ampere_turns);

/*
 How the magnet, whose pull follows the gap, pulled in the last step that was solved.

 `pull` (n): pressure at each point [Pa], also for `mtb_contact_resume_attraction`. `attraction`: their sum times the
 areas [N]. A null pointer leaves one out. A step under anything else is a bad argument.

 # Safety
 `pull` must have room for `n` numbers or be null, `attraction` must point to a number or be null.
 */
enum mtb_status mtb_contact_attraction(uint64_t contact,
                                       uint64_t n,
                                       double *pull,
                                       double *attraction);

/*
 Derivatives of the last step that was solved by the ampere-turns of its magnet, and of the force of this.

 `by_ampere_turns` (9): of force x, y, z [N], moment x, y, z [N m], heat of sliding [W] (of a step with a shift the work
 of the friction [J]), largest mean pressure [Pa] and attraction [N], by the ampere-turns [A]. `of_attraction`: of the
 attraction by the columns of `mtb_contact_derivatives` (`columns` is 9), after a step with a shift by those of
 `mtb_contact_shift_derivatives` (11). A null pointer leaves one out.

 # Safety
 The arrays must be of these lengths or null.
 */
enum mtb_status mtb_contact_magnet_derivatives(uint64_t contact,
                                               uint64_t columns,
                                               double *by_ampere_turns,
                                               double *of_attraction);

/*
 Mean pressure over each of the `n` points [Pa] in the last step that was solved.

 # Safety
 `pressure` must have room for `n` numbers.
 */
enum mtb_status mtb_contact_pressure(uint64_t contact, uint64_t n, double *pressure);

/*
 Heat of sliding [W] and the largest mean pressure over a point [Pa] in the last step that was solved. A null
 pointer leaves one out.

 `friction_power`: friction times the velocity, without the power of the pressures; of a step with a shift NaN, whose
 friction does the work that `mtb_contact_friction` tells.

 # Safety
 `friction_power` and `peak_pressure` must point to numbers or be null.
 */
enum mtb_status mtb_contact_summary(uint64_t contact,
                                    double *friction_power,
                                    double *peak_pressure);

/*
 Derivatives of the last step that was solved, 8 x 9, row by row.

 The rows are force x, y, z [N] and moment x, y, z [N m] on the lower body, heat of sliding [W] and largest mean
 pressure [Pa]; the columns are what they are derived by: pose x, y, z [m], roll, pitch, yaw [rad], velocity x, y
 [m/s], and a uniform magnetic pressure [Pa], 0 for a contact that knows of none. Components of the pose that
 are found from balance have columns of 0. The points in contact stay the same.

 # Safety
 `derivatives` must have room for 72 numbers.
 */
enum mtb_status mtb_contact_derivatives(uint64_t contact,
                                        double *derivatives);

/*
 What the motions found from balance did in the last step that was solved, [m] or [rad], in the order of
 `mtb_contact_motion`; NaN for one in whose place a component of the pose was prescribed.

 # Safety
 `amplitudes` must have room for `m` numbers, as many as `mtb_contact_size` tells.
 */
enum mtb_status mtb_contact_amplitudes(uint64_t contact,
                                       uint64_t m,
                                       double *amplitudes);

/*
 Friction at each of the `n` points in the last step that was solved.

 `tractions` (2 n): mean traction on the lower body along the first tangent of each point, then along the second one
 [Pa]; the first tangent lies along x. `slip` (2 n): how far the upper body slipped over the lower one in a step with a
 shift, along both tangents [m], where points slip; zeros where they stick. `states` (n): 0 open, 1 stick, 2 slip.
 `work`: of the friction on the slip [J]. Of a step without a shift `slip` and `work` are NaN. A null pointer leaves one
 out.

 # Safety
 The arrays must be of these lengths or null.
 */
enum mtb_status mtb_contact_friction(uint64_t contact,
                                     uint64_t n,
                                     double *tractions,
                                     double *slip,
                                     int32_t *states,
                                     double *work);

/*
 How many numbers the memory of steps with a shift has.

 # Safety
 `size` must point to a number.
 */
enum mtb_status mtb_contact_memory_size(uint64_t contact, uint64_t *size);

/*
 What the next step with a shift starts from, after the last step that was solved: `size` numbers for
 `mtb_contact_remember`.

 # Safety
 `memory` must have room for `size` numbers.
 */
enum mtb_status mtb_contact_memory(uint64_t contact,
                                   uint64_t size,
                                   double *memory);

/*
 Starts the next step from a memory of `mtb_contact_memory`, of this contact or a copy of it.

 # Safety
 `memory` must hold `size` numbers.
 */
enum mtb_status mtb_contact_remember(uint64_t contact, uint64_t size, const double *memory);

/*
 Derivatives of the last step, which had a shift and started from another step, 8 x 11, row by row.

 The rows are force x, y, z [N] and moment x, y, z [N m] on the lower body, work of the friction on the slip [J] and
 largest mean pressure [Pa]; the columns are pose x, y, z [m], roll, pitch, yaw [rad], shift x, y [m], velocity x, y [m/s]
 of the tables, and a uniform magnetic pressure [Pa]. What sticks, slips and is in contact stays the same.

 # Safety
 `derivatives` must have room for 88 numbers.
 */
enum mtb_status mtb_contact_shift_derivatives(uint64_t contact,
                                              double *derivatives);

/*
 Gap at each of the `n` points [m] in the last step that was solved.

 # Safety
 `gap` must have room for `n` numbers.
 */
enum mtb_status mtb_contact_gap(uint64_t contact, uint64_t n, double *gap);

/*
 The state after the last step that was solved, `n` numbers for `mtb_contact_resume`.

 # Safety
 `state` must have room for `n` numbers.
 */
enum mtb_status mtb_contact_state(uint64_t contact, uint64_t n, double *state);

/*
 Starts the next step from a state of `mtb_contact_state` in place of the memory, for steps taken again. A
 step taken again gives the same to rounding, not bit by bit. Where friction allows two states, the one on
 whose way the last step lay comes out. Tractions are forgotten: steps with a shift go on from
 `mtb_contact_remember`. The pull of a magnet that follows the gap is forgotten as well, and
 `mtb_contact_resume_attraction` gives it after this call.

 # Safety
 `state` must hold `n` numbers.
 */
enum mtb_status mtb_contact_resume(uint64_t contact,
                                   uint64_t n,
                                   const double *state);

/*
 Starts the next step under a magnet that follows the gap from a pull of `mtb_contact_attraction`, in place of that of
 the last step: after `mtb_contact_resume`. Where two states exist, of bodies apart and of bodies that touch, the pull
 tells which of them comes out.

 # Safety
 `pull` must hold `n` numbers.
 */
enum mtb_status mtb_contact_resume_attraction(uint64_t contact,
                                              uint64_t n,
                                              const double *pull);

/*
 Reads wheels that Python's `PreparedWheels.save` wrote.

 `path`: text in UTF-8, ended by a zero. `wheels`: gets the handle, which `mtb_wheels_free` gives back.

 # Safety
 `path` must be such a text, `wheels` must point to a number.
 */
enum mtb_status mtb_wheels_load(const char *path,
                                uint64_t *wheels);

/*
 The same wheels without memory, for a second wheelset or thread.

 # Safety
 `copy` must point to a number.
 */
enum mtb_status mtb_wheels_copy(uint64_t wheels, uint64_t *copy);

/*
 Gives wheels back.
 */
enum mtb_status mtb_wheels_free(uint64_t wheels);

/*
 The point of the wheelset that poses, velocities and moments are about, at the zero pose [m]. It moves with the
 wheelset: `mtb_wheel_step` tells where a step has put it.

 # Safety
 `point` must have room for 3 numbers.
 */
enum mtb_status mtb_wheels_reference_point(uint64_t wheels,
                                           double *point);

/*
 Solves the contacts of the wheels at one instant, from the memory of the last step.

 `pose` (6): displacement of the wheelset from where it was prepared, x, y, z [m], roll, pitch, yaw [rad]: turned
 by the pitch about the fixed y axis through the reference point, as far as the wheels have rolled, then by roll and yaw
 about the fixed x and z axes, then shifted; z NaN: found so that the wheels
 carry their vertical force, friction included; z and roll NaN, both wheels: so that each carries it. A null pointer: z NaN,
 roll likewise for both wheels, all else zero. Wheels and rails are bodies of revolution and straight: x and pitch move places alone, unless friction
 changes along the rail. A pose whose contact reaches the end of a profile, and numbers larger than 1e30, are bad
 arguments. `velocity` (6): of the reference point along x, y, z [m/s], then
 rotation about x, y, z [rad/s], that about the axle included, which has parts along x and z by yaw and roll, found ones
 too. Track frame: x along the rails, y to the
 left, z up. Out: `step`.

 # Safety
 The arrays must be of these lengths, `step` must point to such a structure.
 */
enum mtb_status mtb_wheels_step(uint64_t wheels,
                                const double *pose,
                                const double *velocity,
                                struct mtb_wheel_step *step);

/*
 As `mtb_wheels_step`, with what else a step may be given: forces for which y and the rotation are found, a curve of
 the track, rails and wheels beside their places. `conditions` also gets what was found.

 # Safety
 As of `mtb_wheels_step`; `conditions` must point to such a structure.
 */
enum mtb_status mtb_wheels_step_under(uint64_t wheels,
                                      const double *pose,
                                      const double *velocity,
                                      struct mtb_wheel_conditions *conditions,
                                      struct mtb_wheel_step *step);

/*
 Rolls on from the last step, or from rest without one, for a `duration` [s] > 0: each patch remembers its tractions.

 As `mtb_wheels_step_under`, with pose and velocity at the end of the step. `conditions` may be null: then there are
 none. Nothing is special about the last step: a steady one is rolled on from as well. A step over several cells is
 divided into parts of a cell at most, in which pressure and creepages change evenly; one over more than four lengths
 of a patch is steady there. A wheel may stand still: then it is shifted by its slip velocity times the duration. The
 heat of sliding is the mean of the step. After a step that was not solved the one before it counts. Here the memory
 decides what comes out: to take a step again, keep what `mtb_wheels_state` gives before it, and for a start from rest
 take a copy.

 # Safety
 As of `mtb_wheels_step_under`; `conditions` may be null.
 */
enum mtb_status mtb_wheels_step_transient(uint64_t wheels,
                                          const double *pose,
                                          const double *velocity,
                                          double duration,
                                          struct mtb_wheel_conditions *conditions,
                                          struct mtb_wheel_step *step);

/*
 A patch of the last step that was solved, counted from 0, those of the left wheel first.

 # Safety
 `patch` must point to such a structure.
 */
enum mtb_status mtb_wheels_patch(uint64_t wheels, uint64_t index, struct mtb_wheel_patch *patch);

/*
 Fields of a patch of the last step that was solved, `n` = nx ny points, x fastest.

 `pressure` (n) [Pa]; `traction` on the rail (2 n: along x, along y) [Pa]; `slip_velocity` of the wheel over
 the rail (2 n) [m/s]; `status` (n): 0 open, 1 stick, 2 slip. A null pointer leaves a field out.

 # Safety
 The arrays must be of these lengths.
 */
enum mtb_status mtb_wheels_fields(uint64_t wheels,
                                  uint64_t index,
                                  uint64_t n,
                                  double *pressure,
                                  double *traction,
                                  double *slip_velocity,
                                  int32_t *status);

/*
 Where the rows of a patch of the last step that was solved lie in the track, the number `rows` of them, its ny.

 `position` (3 for each row): the place at the x of the origin [m]; `directions` (9 for each row): those of x, y and
 normal, three numbers each, along which its tractions and pressures act. On a plane all rows have those of the patch.
 A null pointer leaves either out.

 # Safety
 The arrays must be of these lengths.
 */
enum mtb_status mtb_wheels_rows(uint64_t wheels,
                                uint64_t index,
                                uint64_t rows,
                                double *position,
                                double *directions);

/*
 Derivatives of the last step that was solved, 9 x 12, row by row.

 The rows are force x, y, z [N] and moment x, y, z [N m] on the rails, vertical force of the left and of the right
 wheel [N], and heat of sliding [W]; the columns are what they are derived by: pose x, y, z [m], roll, pitch, yaw
 [rad], then velocity x, y, z [m/s] and rotation about x, y, z [rad/s]. Height and roll that were found from balance
 follow the rest, and have columns of 0. Contact planes, the gap over them and creepages change with the
 pose; points stay in contact, in stick and in slip as they are. The moment is about the reference point, which moves.

 # Safety
 `derivatives` must have room for 108 numbers.
 */
enum mtb_status mtb_wheels_derivatives(uint64_t wheels,
                                       double *derivatives);

/*
 Derivatives of the last step that was solved by all that `mtb_wheels_step_under` takes, 25 x 52, row by row.

 The rows are those of `mtb_wheels_derivatives`, then the pose x, y, z [m], roll, pitch, yaw [rad], the velocity
 x, y, z [m/s] and the rotation about x, y, z [rad/s], and the displacement of the left rail along y and z and of
 the right one [m], with what was found of them. The columns are pose and velocity as there, then the numbers of
 `mtb_wheel_conditions` from `lateral_force` to `wheel_rates` in their order. What was found follows the rest; by
 components of the pose that were found, and by forces that were not given, derivatives are 0.

 # Safety
 `derivatives` must have room for 1300 numbers.
 */
enum mtb_status mtb_wheels_derivatives_under(uint64_t wheels,
                                             double *derivatives);

/*
 Derivatives of the last step, which `mtb_wheels_step_transient` took, by its duration: 25 numbers, of the rows of
 `mtb_wheels_derivatives_under`. Pose and velocity are held, and what the step before has left.

 # Safety
 `derivatives` must have room for 25 numbers.
 */
enum mtb_status mtb_wheels_duration_derivatives(uint64_t wheels,
                                                double *derivatives);

/*
 How many numbers the state after the last step that was solved has.

 # Safety
 `n` must point to a number.
 */
enum mtb_status mtb_wheels_state_size(uint64_t wheels, uint64_t *n);

/*
 The state after the last step that was solved, `n` numbers for `mtb_wheels_resume`.

 # Safety
 `state` must have room for `n` numbers.
 */
enum mtb_status mtb_wheels_state(uint64_t wheels, uint64_t n, double *state);

/*
 Starts the next step from a state of `mtb_wheels_state` in place of the memory, for steps taken again. The memory
 decides how long a steady step takes, not what comes out, and what a transient step rolls on from.

 # Safety
 `state` must hold `n` numbers.
 */
enum mtb_status mtb_wheels_resume(uint64_t wheels,
                                  uint64_t n,
                                  const double *state);

#ifdef __cplusplus
}  // extern "C"
#endif  /* __cplusplus */

#endif  /* MTB_H */
