! SPDX-License-Identifier: MIT OR Apache-2.0
! The ride of ride.c from Fortran; a step taken again from its state gives the same force.
program ride
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_fortran_env, only: error_unit
  use mtb
  implicit none
  character(len=1000) :: path
  character(len=:), allocatable :: name
  integer(c_int64_t) :: contact, n, m, index
  integer(c_int32_t) :: component
  integer :: k
  real(c_double) :: free, speed, pitch, force(3), moment(3), again(3), power, peak
  real(c_double), allocatable :: pressure(:), state(:), amplitudes(:)

  call get_command_argument(1, path)
  call check(mtb_contact_load(path, contact))
  call check(mtb_contact_size(contact, n, m))
  do index = 0, m - 1
    call check(mtb_contact_motion(contact, index, name, component))
    ! each motion has a name and is one of six components of the pose, or none
    if (len(name) == 0 .or. component < -1 .or. component > 5) stop 72
  end do
  free = ieee_value(free, ieee_quiet_nan)
  do k = 0, 19
    speed = -1.0_c_double
    if (k < 15) speed = 30.0_c_double - 2.0_c_double*k
    pitch = 1.0e-6_c_double*k
    call step(force)
    write (*, "(8(es24.16e3, 1x))") speed, pitch, force, moment
  end do

  allocate (pressure(n), state(n), amplitudes(m))
  call check(mtb_contact_pressure(contact, n, pressure))
  call check(mtb_contact_summary(contact, power, peak))
  if (abs(maxval(pressure) - peak) > 0.0_c_double .or. power < 0.0_c_double) stop 73
  call check(mtb_contact_amplitudes(contact, m, amplitudes))
  write (*, "(es24.16e3)") pressure
  call check(mtb_contact_state(contact, n, state))
  call check(mtb_contact_resume(contact, n, state))
  call step(again)
  if (maxval(abs(again - force)) > 1.0e-9_c_double*maxval(abs(force))) stop 70
  call check(mtb_contact_free(contact))
  if (mtb_contact_free(contact) /= mtb_status_bad_argument) stop 71

contains

  subroutine step(out)
    real(c_double), intent(out) :: out(3)
    real(c_double) :: pose(6)
    pose = free
    pose(5) = pitch
    call check(mtb_contact_step(contact, pose, [speed, 0.0_c_double], free, out, moment, c_null_ptr))
  end subroutine

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == mtb_status_ok) return
    write (error_unit, "(a)") mtb_last_error_message()
    ! codes of stop are constants in Fortran 2008
    if (status == mtb_status_bad_file) stop mtb_status_bad_file
    stop 1
  end subroutine
end program
