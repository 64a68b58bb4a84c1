/* One step of a continuation by arc length (theory 4.9).
 *
 *   t  tangent, |D t| = 1;   h  step of arc length
 *   accept : |D correction| <= 0.05 |h| + 1e-9,  cos(t, t_new) >= 0.98,  same number of freedoms
 *   arc    : length of the cubic between both configurations; secant iteration on h
 *   g      = det(pivot block) / t_i, i the independent coordinate: up to a constant det of J bordered by t,
 *            so its sign changes at a branch point */
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"

#include <string.h>

static double pivots_over_tangent(const km_factor *p, const double *t) {
  return km_factor_pivot_product(p) / t[km_factor_column_order(p)[km_factor_rank(p)]];
}

double km_arc_motion_branch_function(const km_arc_motion *f, const double *t) {
  return pivots_over_tangent(f->c.state->factor[f->c.substructure], t);
}

double km_arc_motion_branch_function_after_step(km_arc_motion *f) {
  if (f->g == 0.0)
    return 0.0;
  const km_factor *p = f->c.state->factor[f->c.substructure];
  km_factor *r = f->c.history.reference;
  if (km_factor_search_count(p) == km_factor_search_count(r))
    return km_arc_motion_branch_function(f, f->c.next_t);
  km_factor_refactor(r, km_state_jacobian(f->c.state, km_arc_motion_sub(f)), KM_BASIS_SHORT);
  return pivots_over_tangent(r, f->c.next_t);
}

void km_arc_motion_set_origin(km_arc_motion *f) {
  size_t columns = (size_t)km_arc_motion_sub(f)->columns;
  memcpy(f->origin_t, f->c.history.t, columns * sizeof *f->origin_t);
  memcpy(f->origin, f->c.from, KM_SAVED_PER_COLUMN * columns * sizeof *f->origin);
  f->origin_s = f->s;
  f->is_origin_pending = false;
}

bool km_arc_motion_try(km_arc_motion *f, double h, double *length) {
  const km_substructure *sub = km_arc_motion_sub(f);
  const km_step_terms terms = km_step_terms_of(km_strict_correction_ratio, fabs(h));
  km_continuation_predict(&f->c, h, km_continuation_has_single_freedom(&f->c, f->freedom));
  km_state_restore(f->c.state, sub, f->c.from);
  if (km_continuation_correct(&f->c, &terms) != KM_STEP_ACCEPTED ||
      km_factor_freedom(f->c.state->factor[f->c.substructure]) != f->freedom) {
    km_continuation_reject(&f->c);
    return false;
  }
  km_state_difference(f->c.state, sub, f->c.from, f->c.move);
  *length = km_continuation_arc_length(&f->c, f->c.move, f->c.history.t, f->c.next_t);
  return true;
}

/* Secant iteration on h until the arc length of the step is `length`. */
bool km_arc_motion_step(km_arc_motion *f, double length, double *reached) {
  double h = length;
  for (int i = 0; i < 8; ++i) {
    if (!km_arc_motion_try(f, h, reached))
      return false;
    if (fabs(*reached - length) <= 1e-14 + 1e-11 * fabs(length))
      return true;
    h *= length / *reached;
  }
  return true;
}

void km_arc_motion_save_start(km_arc_motion *f) {
  km_state_save(f->c.state, km_arc_motion_sub(f), f->c.from);
  f->g = f->freedom == 1 ? km_arc_motion_branch_function(f, f->c.history.t) : 0.0;
}

void km_arc_motion_accept(km_arc_motion *f, double length) {
  km_continuation_accept(&f->c, length);
  f->s += length;
  km_arc_motion_save_start(f);
  if (f->is_origin_pending)
    km_arc_motion_set_origin(f);
}
