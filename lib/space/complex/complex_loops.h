/* Evaluation of one program of loops over the complex numbers (complex_closure.h). Private to space/. */
#ifndef KM_SPACE_COMPLEX_COMPLEX_LOOPS_H
#define KM_SPACE_COMPLEX_COMPLEX_LOOPS_H

#include "space/complex/complex_closure.h"

static inline bool km_complex_is_ball(const km_complex_closure *c, int column) {
  return c->m->ball_of[c->m->column_coordinate[c->sub->column_start + column]] >= 0;
}

/* True if `column` is the first one of a ball joint. */
static inline bool km_complex_begins_ball(const km_complex_closure *c, int column) {
  int coordinate = c->m->column_coordinate[c->sub->column_start + column], ball = c->m->ball_of[coordinate];
  return ball >= 0 && c->m->ball_coordinate[ball] == coordinate;
}

/* Draws the coefficients of the fingerprint's functionals; weights of the trace's one are 0. */
void km_complex_draw_weights(km_complex_closure *c, uint64_t *random, km_arena *arena);

static inline void km_complex_set_quaternion(km_quaternion Q, km_wide *x) {
  const km_wide numbers[4] = {Q.w, Q.x, Q.y, Q.z};
  memcpy(x, numbers, sizeof numbers);
}

/* Coefficients of a program: of its slots by step, and of the two ends of each of its loops. */
typedef struct km_program_weight {
  const km_slot_weight *slot, *end;
} km_program_weight;

/* Evaluates the loops of a program and adds its part of the functional; weight.slot = NULL: no functional. */
void km_complex_planar(const km_complex_closure *c, const km_program *program, const km_wide *x,
                       km_program_weight weight, km_complex_values *out);
void km_complex_spatial(const km_complex_closure *c, const km_program *program, const km_wide *x,
                        km_program_weight weight, km_complex_values *out);

/* Sets the ball joint, or planar hinge, that closes a loop at a configuration x, to the rotation with which the loop's
 * frames agree. The configuration is real but for rounding. */
void km_complex_close_planar(const km_complex_closure *c, const km_program *program, const km_loop *loop, int step,
                             km_wide *x);
void km_complex_close_spatial(const km_complex_closure *c, const km_program *program, const km_loop *loop, int step,
                              km_wide *x);

/* Enlarges the extent by the parts of poses whose weights aren't 0. */
void km_complex_planar_extent(const km_complex_closure *c, const km_program *program, const km_wide *x,
                              km_program_weight weight, km_complex_extent *extent);
void km_complex_spatial_extent(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               km_program_weight weight, km_complex_extent *extent);
/* Enlarges the extent by one number. */
static inline void km_complex_extend(km_complex_extent *extent, km_complex z) {
  extent->largest = fmax(extent->largest, cabs(z));
  extent->imaginary = fmax(extent->imaginary, fabs(cimag(z)));
}

/* First column of a step's coordinate. */
static inline int km_complex_column(const km_complex_closure *c, int coordinate) {
  return c->m->column_of[coordinate];
}

/* One loop: its quaternion P (NULL: none), and whether its rows are taken at the moving point where side b ends. That
 * is so if a joint takes any rotation; else E would not be constant along the solutions of one error. */
typedef struct km_complex_loop {
  const km_loop *loop;
  const km_complex *P;
  bool has_moving_point;
} km_complex_loop;

/* The loop at a place of the mechanism's loop order. */
static inline km_complex_loop km_complex_loop_at(const km_complex_closure *c, int place, const km_complex_values *out) {
  int index = place - c->sub->loop_start;
  return (km_complex_loop){&c->m->loops[c->m->loop_order[place]], out->turn ? out->turn + 4 * index : NULL,
                           c->closing_step[index] >= 0};
}

/* Stores an entry of J; left-out rows and fixed columns have none. */
static inline void km_complex_store(const km_complex_closure *c, const km_complex_values *out, int row, int column,
                                    km_complex value) {
  int equation = c->equation_of[row], unknown = c->unknown_of[column];
  if (equation >= 0 && unknown >= 0)
    out->J[equation * out->stride + unknown] = value;
}

#endif
