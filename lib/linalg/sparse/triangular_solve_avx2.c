/* The same in registers of four doubles. No fused multiply-add: the bits stay the same. */
#ifdef KM_LANES_AVX2
#define NAME  km_triangle_squares_avx2
#define WIDTH 4
#include "linalg/sparse/triangular_solve_body.h"
#else
typedef int km_triangle_avx2_is_empty;
#endif
