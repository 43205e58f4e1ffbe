! SPDX-License-Identifier: MIT OR Apache-2.0
! Brake force, normal force and moment of a prepared shoe at three velocities: brake shoe.mtbc
program brake
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_fortran_env, only: error_unit
  use mtb
  implicit none
  real(c_double), parameter :: speeds(3) = [30.0_c_double, 20.0_c_double, 10.0_c_double]
  character(len=1000) :: path
  integer(c_int64_t) :: shoe
  integer :: k
  real(c_double) :: free, pose(6), force(3), moment(3)

  call get_command_argument(1, path)
  call check(mtb_contact_load(path, shoe))
  free = ieee_value(free, ieee_quiet_nan)
  pose = free
  do k = 1, 3
    call check(mtb_contact_step(shoe, pose, [speeds(k), 0.0_c_double], free, force, moment, c_null_ptr))
    write (*, "(f4.1, 3(1x, es22.15))") speeds(k), force(1), force(3), moment(2)
  end do
  call check(mtb_contact_free(shoe))

contains

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == mtb_status_ok) return
    write (error_unit, "(a)") mtb_last_error_message()
    ! codes of stop are constants in Fortran 2008
    if (status == mtb_status_bad_file) stop mtb_status_bad_file
    stop 1
  end subroutine
end program
