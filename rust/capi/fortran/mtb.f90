! SPDX-License-Identifier: MIT OR Apache-2.0
!> The C interface of prepared sliding contacts and wheels on rails for Fortran 2003; include/mtb.h says what each does.
module mtb
  use, intrinsic :: iso_c_binding
  implicit none

  enum, bind(c)
    enumerator :: mtb_status_ok = 0, mtb_status_bad_argument = 1, mtb_status_bad_file = 2
    enumerator :: mtb_status_no_solution = 3, mtb_status_not_converged = 4, mtb_status_internal = 5
  end enum

  !> Contact load of a step of wheels.
  type, bind(c) :: mtb_wheel_step
    real(c_double) :: force(3), moment(3), vertical_force(2), balance_error, reference_point(3), pose(6)
    real(c_double) :: friction_power
    integer(c_int64_t) :: patches, normal_solves, iterations
  end type

  !> What else a step of wheels may be given, and what it found of it; left first, then right.
  type, bind(c) :: mtb_wheel_conditions
    real(c_double) :: lateral_force, longitudinal_force, axle_moment, curvature
    real(c_double) :: rails(3, 2), rail_rates(3, 2), wheels(6, 2), wheel_rates(6, 2)
    real(c_double) :: velocity(6), rail_displacement(2, 2)
  end type

  !> A contact patch; directions(:, 1), (:, 2), (:, 3) are x, y and normal of its frame.
  type, bind(c) :: mtb_wheel_patch
    integer(c_int64_t) :: side, nx, ny
    real(c_double) :: start(2), spacing(2), position(3), directions(3, 3)
    real(c_double) :: contact_angle, rail_position, wheel_position, approach, creepage(3), rolling_speed
    real(c_double) :: normal_force, neglected, friction_power
  end type

  interface
    integer(c_int) function mtb_contact_load_c(path, contact) bind(c, name="mtb_contact_load")
      import :: c_int, c_char, c_int64_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int64_t), intent(out) :: contact
    end function

    integer(c_int) function mtb_contact_copy(contact, copy) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: contact
      integer(c_int64_t), intent(out) :: copy
    end function

    integer(c_int) function mtb_contact_free(contact) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: contact
    end function

    integer(c_int) function mtb_contact_size(contact, points, motions) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: contact
      integer(c_int64_t), intent(out) :: points, motions
    end function

    !> index counts from 0; name is ended by a zero, component is -1 or 0 to 5
    integer(c_int) function mtb_contact_motion_c(contact, index, length, name, component) &
        bind(c, name="mtb_contact_motion")
      import :: c_int, c_char, c_int32_t, c_int64_t
      integer(c_int64_t), value :: contact, index, length
      character(kind=c_char), intent(out) :: name(length)
      integer(c_int32_t), intent(out) :: component
    end function

    integer(c_int) function mtb_contact_points(contact, n, points, normals, areas) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: points(n, 3), normals(n, 3), areas(n)
    end function

    integer(c_int) function mtb_contact_reference_point(contact, point) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact
      real(c_double), intent(out) :: point(3)
    end function

    integer(c_int) function mtb_contact_step(contact, pose, velocity, magnetic_pressure, force, moment, effort) &
        bind(c)
      import :: c_int, c_int64_t, c_double, c_ptr
      integer(c_int64_t), value :: contact
      real(c_double), intent(in) :: pose(6), velocity(2)
      real(c_double), value :: magnetic_pressure
      real(c_double), intent(out) :: force(3), moment(3)
      type(c_ptr), value :: effort
    end function

    integer(c_int) function mtb_contact_step_shifted(contact, pose, velocity, shift, magnetic_pressure, force, moment, &
        effort) bind(c)
      import :: c_int, c_int64_t, c_double, c_ptr
      integer(c_int64_t), value :: contact
      real(c_double), intent(in) :: pose(6), velocity(2), shift(2)
      real(c_double), value :: magnetic_pressure
      real(c_double), intent(out) :: force(3), moment(3)
      type(c_ptr), value :: effort
    end function

    integer(c_int) function mtb_contact_friction(contact, n, tractions, slip, states, work) bind(c)
      import :: c_int, c_int32_t, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: tractions(n, 2), slip(n, 2), work
      integer(c_int32_t), intent(out) :: states(n)
    end function

    !> ampere-turns of the magnet in all steps from here on; 0: switched off, NaN: those with which it was prepared
    integer(c_int) function mtb_contact_set_ampere_turns(contact, ampere_turns) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact
      real(c_double), value :: ampere_turns
    end function

    integer(c_int) function mtb_contact_attraction(contact, n, pull, attraction) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: pull(n), attraction
    end function

    integer(c_int) function mtb_contact_resume_attraction(contact, n, pull) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(in) :: pull(n)
    end function

    !> columns is 9, after a step with a shift 11
    integer(c_int) function mtb_contact_magnet_derivatives(contact, columns, by_ampere_turns, of_attraction) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, columns
      real(c_double), intent(out) :: by_ampere_turns(9), of_attraction(columns)
    end function

    integer(c_int) function mtb_contact_memory_size(contact, size) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: contact
      integer(c_int64_t), intent(out) :: size
    end function

    integer(c_int) function mtb_contact_memory(contact, size, memory) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, size
      real(c_double), intent(out) :: memory(size)
    end function

    integer(c_int) function mtb_contact_remember(contact, size, memory) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, size
      real(c_double), intent(in) :: memory(size)
    end function

    ! derivatives(j, i): of output i by input j, in the order of mtb.h
    integer(c_int) function mtb_contact_shift_derivatives(contact, derivatives) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact
      real(c_double), intent(out) :: derivatives(11, 8)
    end function

    integer(c_int) function mtb_contact_pressure(contact, n, pressure) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: pressure(n)
    end function

    integer(c_int) function mtb_contact_summary(contact, friction_power, peak_pressure) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact
      real(c_double), intent(out) :: friction_power, peak_pressure
    end function

    ! derivatives(j, i): of output i by input j, in the order of mtb.h
    integer(c_int) function mtb_contact_derivatives(contact, derivatives) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact
      real(c_double), intent(out) :: derivatives(9, 8)
    end function

    integer(c_int) function mtb_contact_amplitudes(contact, m, amplitudes) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, m
      real(c_double), intent(out) :: amplitudes(m)
    end function

    integer(c_int) function mtb_contact_gap(contact, n, gap) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: gap(n)
    end function

    integer(c_int) function mtb_contact_state(contact, n, state) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: state(n)
    end function

    integer(c_int) function mtb_contact_resume(contact, n, state) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(in) :: state(n)
    end function

    integer(c_int) function mtb_wheels_load_c(path, wheels) bind(c, name="mtb_wheels_load")
      import :: c_int, c_char, c_int64_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int64_t), intent(out) :: wheels
    end function

    integer(c_int) function mtb_wheels_copy(wheels, copy) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: wheels
      integer(c_int64_t), intent(out) :: copy
    end function

    integer(c_int) function mtb_wheels_free(wheels) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: wheels
    end function

    integer(c_int) function mtb_wheels_reference_point(wheels, point) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels
      real(c_double), intent(out) :: point(3)
    end function

    integer(c_int) function mtb_wheels_step(wheels, pose, velocity, step) bind(c)
      import :: c_int, c_int64_t, c_double, mtb_wheel_step
      integer(c_int64_t), value :: wheels
      real(c_double), intent(in) :: pose(6), velocity(6)
      type(mtb_wheel_step), intent(out) :: step
    end function

    integer(c_int) function mtb_wheels_step_under(wheels, pose, velocity, conditions, step) bind(c)
      import :: c_int, c_int64_t, c_double, mtb_wheel_conditions, mtb_wheel_step
      integer(c_int64_t), value :: wheels
      real(c_double), intent(in) :: pose(6), velocity(6)
      type(mtb_wheel_conditions), intent(inout) :: conditions
      type(mtb_wheel_step), intent(out) :: step
    end function

    !> as mtb_wheels_step_under, rolling on from the last step for a duration [s]
    integer(c_int) function mtb_wheels_step_transient(wheels, pose, velocity, duration, conditions, step) bind(c)
      import :: c_int, c_int64_t, c_double, mtb_wheel_conditions, mtb_wheel_step
      integer(c_int64_t), value :: wheels
      real(c_double), intent(in) :: pose(6), velocity(6)
      real(c_double), value :: duration
      type(mtb_wheel_conditions), intent(inout) :: conditions
      type(mtb_wheel_step), intent(out) :: step
    end function

    !> index counts from 0
    integer(c_int) function mtb_wheels_patch(wheels, index, patch) bind(c)
      import :: c_int, c_int64_t, mtb_wheel_patch
      integer(c_int64_t), value :: wheels, index
      type(mtb_wheel_patch), intent(out) :: patch
    end function

    ! derivatives(j, i): of output i by input j, in the order of mtb.h
    integer(c_int) function mtb_wheels_derivatives(wheels, derivatives) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels
      real(c_double), intent(out) :: derivatives(12, 9)
    end function

    ! derivatives(j, i): of output i by input j, in the order of mtb.h
    integer(c_int) function mtb_wheels_derivatives_under(wheels, derivatives) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels
      real(c_double), intent(out) :: derivatives(52, 25)
    end function

    ! of the outputs of mtb_wheels_derivatives_under by the duration of a transient step
    integer(c_int) function mtb_wheels_duration_derivatives(wheels, derivatives) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels
      real(c_double), intent(out) :: derivatives(25)
    end function

    integer(c_int) function mtb_wheels_fields(wheels, index, n, pressure, traction, slip_velocity, status) bind(c)
      import :: c_int, c_int32_t, c_int64_t, c_double
      integer(c_int64_t), value :: wheels, index, n
      real(c_double), intent(out) :: pressure(n), traction(n, 2), slip_velocity(n, 2)
      integer(c_int32_t), intent(out) :: status(n)
    end function

    ! where its rows lie in the track, and their directions x, y and normal
    integer(c_int) function mtb_wheels_rows(wheels, index, rows, position, directions) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels, index, rows
      real(c_double), intent(out) :: position(3, rows), directions(3, 3, rows)
    end function

    integer(c_int) function mtb_wheels_state_size(wheels, n) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: wheels
      integer(c_int64_t), intent(out) :: n
    end function

    integer(c_int) function mtb_wheels_state(wheels, n, state) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels, n
      real(c_double), intent(out) :: state(n)
    end function

    integer(c_int) function mtb_wheels_resume(wheels, n, state) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: wheels, n
      real(c_double), intent(in) :: state(n)
    end function

    type(c_ptr) function mtb_last_error_message_c() bind(c, name="mtb_last_error_message")
      import :: c_ptr
    end function

    type(c_ptr) function mtb_version_c() bind(c, name="mtb_version")
      import :: c_ptr
    end function
  end interface

  private :: text_at

contains

  !> Reads a contact; `path` is trimmed.
  integer(c_int) function mtb_contact_load(path, contact) result(status)
    character(len=*), intent(in) :: path
    integer(c_int64_t), intent(out) :: contact
    status = mtb_contact_load_c(trim(path)//c_null_char, contact)
  end function

  !> Name of a motion found from balance, `index` from 0, and what it is of the pose: 0 to 5, or -1 for none.
  integer(c_int) function mtb_contact_motion(contact, index, name, component) result(status)
    integer(c_int64_t), intent(in) :: contact, index
    character(len=:), allocatable, intent(out) :: name
    integer(c_int32_t), intent(out) :: component
    character(kind=c_char), target :: letters(4096)
    status = mtb_contact_motion_c(contact, index, size(letters, kind=c_int64_t), letters, component)
    name = ""
    if (status == mtb_status_ok) name = text_at(c_loc(letters))
  end function

  !> Reads wheels; `path` is trimmed.
  integer(c_int) function mtb_wheels_load(path, wheels) result(status)
    character(len=*), intent(in) :: path
    integer(c_int64_t), intent(out) :: wheels
    status = mtb_wheels_load_c(trim(path)//c_null_char, wheels)
  end function

  !> Version of the library, for example "0.1.0".
  function mtb_version() result(version)
    character(len=:), allocatable :: version
    version = text_at(mtb_version_c())
  end function

  !> Why the last call on this thread failed.
  function mtb_last_error_message() result(message)
    character(len=:), allocatable :: message
    message = text_at(mtb_last_error_message_c())
  end function

  function text_at(address) result(text)
    type(c_ptr), intent(in) :: address
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: length
    call c_f_pointer(address, letters, [4096])
    length = 0
    do while (length < 4096)
      if (letters(length + 1) == c_null_char) exit
      length = length + 1
    end do
    allocate (character(len=length) :: text)
    text = transfer(letters(1:length), text)
  end function
end module
