! SPDX-License-Identifier: MIT OR Apache-2.0
! The break-away of break_away.c from Fortran.
program break_away
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_fortran_env, only: error_unit
  use mtb
  implicit none
  character(len=1000) :: path
  integer(c_int64_t) :: contact, n, m, size
  integer :: k
  real(c_double) :: free, along
  real(c_double), allocatable :: memory(:)

  call get_command_argument(1, path)
  call check(mtb_contact_load(path, contact))
  call check(mtb_contact_size(contact, n, m))
  call check(mtb_contact_memory_size(contact, size))
  allocate (memory(size))
  free = ieee_value(free, ieee_quiet_nan)
  do k = 0, 11
    along = 0.0_c_double
    if (k < 11) along = -6.0e-7_c_double
    if (k < 8) along = 3.0e-7_c_double
    if (k > 0) call check(mtb_contact_memory(contact, size, memory))
    call step()
  end do
  call check(mtb_contact_remember(contact, size, memory))
  call step()
  call check(mtb_contact_free(contact))

contains

  subroutine step()
    real(c_double) :: pose(6), force(3), moment(3), tractions(n, 2), slip(n, 2), work
    integer(c_int32_t) :: states(n)
    pose = free
    call check(mtb_contact_step_shifted(contact, pose, [1.0_c_double, 0.0_c_double], [along, 0.0_c_double], free, force, &
      moment, c_null_ptr))
    call check(mtb_contact_friction(contact, n, tractions, slip, states, work))
    write (*, "(2(es24.16e3, 1x), i0, 1x, es24.16e3)") along, force(1), count(states == 1), work
  end subroutine

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == mtb_status_ok) return
    write (error_unit, "(a)") mtb_last_error_message()
    stop 1
  end subroutine
end program
