! SPDX-License-Identifier: MIT OR Apache-2.0
! The path of wheelset.c from Fortran; a step taken again from its state gives the same force.
program wheelset
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_fortran_env, only: error_unit
  use mtb
  implicit none
  real(c_double), parameter :: speed = 30.0_c_double, amplitude = 4.0e-3_c_double
  real(c_double), parameter :: wave = 2.0_c_double*acos(-1.0_c_double)/20.0_c_double
  character(len=1000) :: path
  integer(c_int64_t) :: wheels, n, index, i
  integer :: k
  real(c_double) :: free, axle(3), spin, way, y, yaw, pose(6), velocity(6)
  real(c_double), allocatable :: state(:), pressure(:), traction(:, :), slip(:, :)
  integer(c_int32_t), allocatable :: status(:)
  type(mtb_wheel_step) :: step, again
  type(mtb_wheel_patch) :: patch

  if (len(mtb_version()) == 0) stop 69
  call get_command_argument(1, path)
  call check(mtb_wheels_load(path, wheels))
  call check(mtb_wheels_reference_point(wheels, axle))
  free = ieee_value(free, ieee_quiet_nan)
  spin = speed/axle(3)
  do k = 0, 19
    way = real(k, c_double)
    y = amplitude*sin(wave*way)
    yaw = amplitude*wave*cos(wave*way)
    pose = [way, y, free, free, 0.0_c_double, yaw]
    ! it turns about its axle, which yaws, and rolls by what the first of two steps finds
    velocity = [speed, speed*yaw, 0.0_c_double, -spin*yaw, spin, -wave**2*speed*y]
    call check(mtb_wheels_step(wheels, pose, velocity, step))
    velocity(6) = velocity(6) + spin*step%pose(4)
    call check(mtb_wheels_step(wheels, pose, velocity, step))
    write (*, "(12(es24.16e3, 1x), i0)") way, y, yaw, step%pose(3:4), step%force, step%moment, &
      step%friction_power, step%patches
  end do

  do index = 0, step%patches - 1
    call check(mtb_wheels_patch(wheels, index, patch))
    write (*, "(i0, 4(1x, es24.16e3), 2(1x, i0))") patch%side, patch%normal_force, patch%creepage, patch%nx, patch%ny
    n = patch%nx*patch%ny
    allocate (pressure(n), traction(n, 2), slip(n, 2), status(n))
    call check(mtb_wheels_fields(wheels, index, n, pressure, traction, slip, status))
    do i = 1, n
      write (*, "(5(es24.16e3, 1x), i0)") pressure(i), traction(i, :), slip(i, :), status(i)
    end do
    deallocate (pressure, traction, slip, status)
  end do

  call check(mtb_wheels_state_size(wheels, n))
  allocate (state(n))
  call check(mtb_wheels_state(wheels, n, state))
  call check(mtb_wheels_resume(wheels, n, state))
  call check(mtb_wheels_step(wheels, pose, velocity, again))
  if (maxval(abs(again%force - step%force)) > 1.0e-6_c_double*maxval(abs(step%force))) stop 70
  call check(mtb_wheels_free(wheels))
  if (mtb_wheels_free(wheels) /= mtb_status_bad_argument) stop 71

contains

  subroutine check(code)
    integer(c_int), intent(in) :: code
    if (code == mtb_status_ok) return
    write (error_unit, "(a)") mtb_last_error_message()
    ! codes of stop are constants in Fortran 2008
    if (code == mtb_status_bad_file) stop mtb_status_bad_file
    stop 1
  end subroutine
end program
