/* Forward substitution in registers of two doubles, which every processor has. */
#define NAME  km_triangle_squares_plain
#define WIDTH 2
#include "linalg/sparse/triangular_solve_body.h"
