// Links calls to hypot to the oldest version of this symbol on x86-64, which every glibc has.
// glibc 2.35 added a version that differs only in its handling of errors. A wheel that uses the new
// version cannot run with an older glibc.
extern "C" {

double hypot_of_any_glibc(double x, double y);
__asm__(".symver hypot_of_any_glibc, hypot@GLIBC_2.2.5");

// The linker replaces calls to hypot with calls to this function (--wrap=hypot).
double __wrap_hypot(double x, double y) {  // NOLINT(bugprone-reserved-identifier)
  return hypot_of_any_glibc(x, y);
}

}  // extern "C"
