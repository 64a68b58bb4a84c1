/* Forward substitution in registers of four doubles. No fused multiply-add, so the bits are those of two-double
 * registers. */
#ifdef KM_LANES_AVX2
#define NAME  km_triangle_squares_avx2
#define WIDTH 4
#include "linalg/sparse/triangular_solve_body.h"
#else
typedef int km_triangle_avx2_is_empty;
#endif
