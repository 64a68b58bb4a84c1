/* Newton-Kantorovich proof of one closed configuration (mode_proof.h). */
#include "space/mode_proof.h"

#include "space/complex_loops.h"
#include "space/complex_solve.h"

#include <float.h>

/* Roundings of one step of a program: products of rotations, a sine, sums. */
enum { ROUNDINGS_PER_STEP = 64 };

/* Reach of the loops of one program: all constant links and slides, one size more for slides within the ball of the
 * proof, and the distance of the loop's point. */
static double program_reach(const km_complex_closure *c, const km_program *program, const km_complex *x) {
  double reach = 1.0;
  for (int i = 0; i < program->step_count; ++i) {
    if (program->planar) {
      const km_planar_step *step = &c->m->planar_steps[program->step_start + i];
      reach += hypot(step->x, step->y);
      if (step->is_slide)
        reach += cabs(x[c->start_of[km_complex_column(c, step->coordinate)]]);
    } else {
      const km_step *step = &c->m->steps[program->step_start + i];
      reach += km_vec3_norm(step->before.p);
      if (step->primitive == KM_PRISMATIC)
        reach += cabs(x[c->start_of[km_complex_column(c, step->coordinate)]]);
    }
  }
  return reach;
}

static double loop_reach(const km_program *program, const km_loop *loop) {
  double reach = 0.0;
  for (int side = 0; side < 2; ++side)
    reach += program->planar ? hypot(loop->planar_closing_point[side][0], loop->planar_closing_point[side][1])
                             : km_vec3_norm(loop->closing_frame[side].p);
  return reach + (program->planar ? hypot(loop->planar_origin_offset[0], loop->planar_origin_offset[1]) +
                                        hypot(loop->planar_point[0], loop->planar_point[1])
                                  : km_vec3_norm(loop->origin_offset) + km_vec3_norm(loop->point[0]));
}

/* K, and the rounding errors of F and J. */
static double second_derivative_bound(const km_complex_closure *c, const km_complex *x, double *rounding) {
  double sum = 0.0, largest = 0.0;
  int steps = 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    double chain = program_reach(c, program, x);
    steps += program->step_count;
    for (int j = 0; j < program->loop_count; ++j) {
      const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + j]];
      double r = chain + loop_reach(program, loop), columns = 0.0;
      for (int e = 0; e < loop->entry_count; ++e)
        columns += program->planar ? 1.0
                                   : km_primitive_freedom(c->m->steps[program->step_start +
                                                                      c->m->entries[loop->entry_start + e].step]
                                                              .primitive);
      sum += columns * columns * (9.0 * r * r + 1.0);
      largest = fmax(largest, r);
    }
  }
  *rounding = ROUNDINGS_PER_STEP * DBL_EPSILON * steps * (1.0 + largest) * c->size;
  return sqrt(sum);
}

/* True if all rows of all loops are equations, or are solved by a joint that closes the loop. */
static bool has_all_equations(const km_complex_closure *c) {
  int count = 0, closing = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    count += c->equation_of[r] >= 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j)
      if (c->closing_step[program->loop_start + j - c->sub->loop_start] >= 0)
        closing += program->planar ? 1 : 3;
  }
  return count + closing == c->sub->rows;
}

/* Frobenius norms of X = J⁻¹, computed from its factors, and of 1 − X J. */
static void inverse_norms(const km_complex_closure *c, const km_complex *J, const km_complex *LU, const int *row,
                          km_complex *unit, km_complex *X, double *inverse, double *defect) {
  int n = c->size;
  *inverse = *defect = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i)
      unit[i] = i == j;
    km_complex_solve(LU, n, n, row, unit, X + j * n);
    for (int i = 0; i < n; ++i)
      *inverse += creal(X[j * n + i] * conj(X[j * n + i]));
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      km_complex sum = i == j;
      for (int k = 0; k < n; ++k)
        sum -= X[k * n + i] * J[k * n + j];
      *defect += creal(sum * conj(sum));
    }
  *inverse = sqrt(*inverse);
  *defect = sqrt(*defect);
}

bool km_mode_prove(const km_complex_closure *c, const km_complex *x, km_mode_proof *out) {
  km_arena arena = {0};
  size_t n = (size_t)c->size;
  km_complex *J = KM_ARENA_NEW(&arena, km_complex, n *n), *LU = KM_ARENA_NEW(&arena, km_complex, n *n);
  km_complex *X = KM_ARENA_NEW(&arena, km_complex, n *n), *F = KM_ARENA_NEW(&arena, km_complex, n);
  km_complex *unit = KM_ARENA_NEW(&arena, km_complex, n);
  int *row = KM_ARENA_NEW(&arena, int, n);
  bool is_ok = !arena.failed;
  *out = (km_mode_proof){.h = NAN, .error_bound = NAN, .radius = NAN};
  if (is_ok) {
    km_complex_values values = {.F = F, .J = LU, .stride = c->size, .functional = -1};
    km_complex_evaluate(c, x, &values);
    values.J = J;
    km_complex_evaluate(c, x, &values);
    if (km_complex_factor(LU, c->size, c->size, row)) {
      double rounding, K = second_derivative_bound(c, x, &rounding), inverse, defect, error = 0.0;
      inverse_norms(c, J, LU, row, unit, X, &inverse, &defect);
      for (int i = 0; i < c->size; ++i)
        error += creal(F[i] * conj(F[i]));
      double beta = inverse / (1.0 - defect - inverse * rounding), eta = beta * (sqrt(error) + rounding);
      if (beta > 0.0 && isfinite(beta)) {
        out->h = beta * eta * K;
        out->is_proved = out->h <= 0.5 && has_all_equations(c);
        double root = sqrt(fmax(1.0 - 2.0 * out->h, 0.0));
        out->error_bound = 2.0 * eta / (1.0 + root);
        out->radius = (1.0 + root) / (beta * K);
      }
    }
  }
  km_arena_free(&arena);
  return is_ok;
}
