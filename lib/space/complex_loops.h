/* Evaluation of one program of loops over the complex numbers (complex_closure.h). Private to space/. */
#ifndef KM_SPACE_COMPLEX_LOOPS_H
#define KM_SPACE_COMPLEX_LOOPS_H

#include "space/complex_closure.h"

/* Evaluates the loops of a program and adds its part of the functional. `weight`: coefficients of the program's slots,
 * by step; NULL: no functional. */
void km_complex_planar(const km_complex_closure *c, const km_program *program, const km_complex *x,
                       const km_slot_weight *weight, km_complex_values *out);
void km_complex_spatial(const km_complex_closure *c, const km_program *program, const km_complex *x,
                        const km_slot_weight *weight, km_complex_values *out);

/* Sets the quaternion of a ball joint that closes a loop of a spatial program, at a configuration x: the rotation with
 * which the loop's frames agree. */
void km_complex_close_ball(const km_complex_closure *c, const km_program *program, const km_loop *loop, int step,
                           km_complex *x);

/* Returns the first column of a step's coordinate, −1 if it is held. */
static inline int km_complex_column(const km_complex_closure *c, int coordinate) {
  return c->m->column_of[coordinate];
}

/* Quaternion P of the loop at a place of the mechanism's loop order; NULL: no rotation. */
static inline const km_complex *km_complex_turn(const km_complex_closure *c, int place, const km_complex_values *out) {
  return out->turn ? out->turn + 4 * (place - c->sub->loop_start) : NULL;
}

/* Stores an entry of J; left-out rows and fixed columns have none. */
static inline void km_complex_store(const km_complex_closure *c, const km_complex_values *out, int row, int column,
                                    km_complex value) {
  int equation = c->equation_of[row], unknown = c->unknown_of[column];
  if (equation >= 0 && unknown >= 0)
    out->J[equation * out->stride + unknown] = value;
}

#endif
