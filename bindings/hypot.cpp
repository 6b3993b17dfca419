// Calls of hypot with the version that all systems have. Since glibc 2.35 hypot has a new version,
// which differs only in errno. It alone would keep wheels from running with glibc 2.34.
extern "C" {

double hypot_of_any_glibc(double x, double y);
__asm__(".symver hypot_of_any_glibc, hypot@GLIBC_2.2.5");

// The linker replaces calls of hypot by calls of this function (--wrap=hypot).
double __wrap_hypot(double x, double y) {  // NOLINT(bugprone-reserved-identifier)
  return hypot_of_any_glibc(x, y);
}

}  // extern "C"
