! SPDX-License-Identifier: MIT OR Apache-2.0
!> The C interface of prepared sliding contacts for Fortran 2003; include/mtb.h says what each does.
module mtb
  use, intrinsic :: iso_c_binding
  implicit none

  enum, bind(c)
    enumerator :: mtb_status_ok = 0, mtb_status_bad_argument = 1, mtb_status_bad_file = 2
    enumerator :: mtb_status_no_solution = 3, mtb_status_not_converged = 4, mtb_status_internal = 5
  end enum

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

    integer(c_int) function mtb_contact_pressure(contact, n, pressure) bind(c)
      import :: c_int, c_int64_t, c_double
      integer(c_int64_t), value :: contact, n
      real(c_double), intent(out) :: pressure(n)
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

    type(c_ptr) function mtb_last_error_message_c() bind(c, name="mtb_last_error_message")
      import :: c_ptr
    end function
  end interface

contains

  !> Reads a contact; `path` is trimmed.
  integer(c_int) function mtb_contact_load(path, contact) result(status)
    character(len=*), intent(in) :: path
    integer(c_int64_t), intent(out) :: contact
    status = mtb_contact_load_c(trim(path)//c_null_char, contact)
  end function

  !> Why the last call on this thread failed.
  function mtb_last_error_message() result(message)
    character(len=:), allocatable :: message
    character(kind=c_char), pointer :: text(:)
    type(c_ptr) :: address
    integer :: length
    address = mtb_last_error_message_c()
    call c_f_pointer(address, text, [4096])
    length = 0
    do while (length < 4096)
      if (text(length + 1) == c_null_char) exit
      length = length + 1
    end do
    allocate (character(len=length) :: message)
    message = transfer(text(1:length), message)
  end function
end module
