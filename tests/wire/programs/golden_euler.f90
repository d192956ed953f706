! Euler's scheme in Fortran, which answers as the golden transcript does. The functions are those of sdaeverify.h.
program golden_euler
  use iso_c_binding
  implicit none
  interface
    integer(c_int) function sv_next(hello) bind(c)
      import; character(kind=c_char), intent(in) :: hello(*)
    end function
    type(c_ptr) function sv_get(name) bind(c)
      import; character(kind=c_char), intent(in) :: name(*)
    end function
    integer(c_long) function sv_size(name) bind(c)
      import; character(kind=c_char), intent(in) :: name(*)
    end function
    integer(c_long) function sv_paths(name) bind(c)
      import; character(kind=c_char), intent(in) :: name(*)
    end function
    subroutine sv_begin(words) bind(c)
      import; character(kind=c_char), intent(in) :: words(*)
    end subroutine
    subroutine sv_put(name, data, rows, paths) bind(c)
      import; character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(in) :: data(*)
      integer(c_long), value :: rows, paths
    end subroutine
    type(c_ptr) function sv_ask() bind(c)
      import
    end function
    subroutine sv_send() bind(c)
    end subroutine
  end interface
  character(len=*), parameter :: nl = new_line('a')
  character(len=*), parameter :: hello = 'name golden-euler' // nl // 'form SDE' // nl // 'noise dW' // nl // &
    'asks drift diffusion' // nl // c_null_char
  real(c_double), pointer :: t(:), h(:), x(:, :), dW(:, :), f(:, :), B(:, :, :)
  real(c_double), allocatable :: y(:, :)
  integer(c_long) :: d, l, P, i, j

  do while (sv_next(hello) == 1)
    P = sv_paths('x' // c_null_char)
    d = sv_size('x' // c_null_char) / P
    l = sv_size('dW' // c_null_char) / P
    call c_f_pointer(sv_get('t' // c_null_char), t, [1])
    call c_f_pointer(sv_get('h' // c_null_char), h, [1])
    call c_f_pointer(sv_get('x' // c_null_char), x, [P, d])   ! paths first: the first axis is Fortran's fastest
    call c_f_pointer(sv_get('dW' // c_null_char), dW, [P, l])
    call ask_at('ask drift')
    call c_f_pointer(sv_ask(), f, [P, d])
    call ask_at('ask diffusion')
    call c_f_pointer(sv_ask(), B, [P, l, d])
    y = x + h(1) * f
    do i = 1, d
      do j = 1, l
        y(:, i) = y(:, i) + B(:, j, i) * dW(:, j)
      end do
    end do
    call sv_begin('done' // c_null_char)
    call sv_put('x' // c_null_char, y, d, P)
    call sv_send()
  end do
contains
  subroutine ask_at(words)
    character(len=*), intent(in) :: words
    call sv_begin(words // c_null_char)
    call sv_put('t' // c_null_char, t, -1_c_long, 1_c_long)
    call sv_put('x' // c_null_char, x, d, P)
  end subroutine
end program
