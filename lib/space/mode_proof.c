/* Newton-Kantorovich proof of one closed configuration (mode_proof.h). */
#include "space/mode_proof.h"

#include "space/complex/complex_loops.h"
#include "space/complex/complex_solve.h"

#include <float.h>

/* Roundings of one number of a pose by one step of a program: the products by a constant and a joint's rotation, a sine
 * and a cosine, and the sum of a position are 20 at most. */
enum { ROUNDINGS_PER_STEP = 32 };

/* Columns of a loop, and the reach of its chain: constant links and slides, one size more for slides within the ball of
 * the proof, and the distance of the loop's point. */
typedef struct loop_size {
  double columns, reach;
} loop_size;

/* A motion of one coordinate, and its link: number of columns and length. */
typedef struct step_size {
  bool is_slide;
  int coordinate;
  double columns, length;
} step_size;

static step_size size_of_step(const km_mechanism *m, const km_program *program, int i) {
  if (program->planar) {
    const km_planar_step *step = &m->planar_steps[i];
    return (step_size){step->is_slide, step->coordinate, 1.0, hypot(step->x, step->y)};
  }
  const km_step *step = &m->steps[i];
  return (step_size){step->primitive == KM_PRISMATIC, step->coordinate, km_primitive_freedom(step->primitive),
                     km_vec3_norm(step->before.p)};
}

static loop_size size_of_loop(const km_complex_closure *c, const km_program *program, const km_loop *loop,
                              const km_wide *x) {
  loop_size size = {0.0, 1.0};
  for (int e = 0; e < loop->entry_count; ++e) {
    step_size step = size_of_step(c->m, program, program->step_start + c->m->entries[loop->entry_start + e].step);
    size.columns += step.columns;
    size.reach += step.length;
    size.reach += step.is_slide ? (double)cabsl(x[c->start_of[km_complex_column(c, step.coordinate)]]) : 0.0;
  }
  for (int side = 0; side < 2; ++side)
    size.reach += program->planar ? hypot(loop->planar_closing_point[side][0], loop->planar_closing_point[side][1])
                                  : km_vec3_norm(loop->closing_frame[side].p);
  size.reach += program->planar ? hypot(loop->planar_origin_offset[0], loop->planar_origin_offset[1]) +
                                      hypot(loop->planar_point[0], loop->planar_point[1])
                                : km_vec3_norm(loop->origin_offset) + km_vec3_norm(loop->point[0]);
  return size;
}

/* K, and the rounding error of an entry of F or J. */
static double second_derivative_bound(const km_complex_closure *c, const km_wide *x, double *rounding) {
  double sum = 0.0, largest = 0.0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      int place = program->loop_start + j;
      loop_size size = size_of_loop(c, program, &c->m->loops[c->m->loop_order[place]], x);
      /* The image E(o) of a fixed point is a sum of three vectors of the chain's reach, the moving point is one. */
      double position = (c->closing_step[place - c->sub->loop_start] >= 0 ? 1.0 : 3.0) * size.reach;
      sum += size.columns * size.columns * (position * position + 1.0);
      largest = fmax(largest, (size.columns + 2.0) * (1.0 + size.reach));
    }
  }
  *rounding = ROUNDINGS_PER_STEP * DBL_EPSILON * largest;
  return sqrt(sum);
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

bool km_mode_prove(const km_complex_closure *c, const km_wide *x, km_mode_proof *out) {
  km_arena arena = {0};
  size_t n = (size_t)c->size;
  km_complex *J = KM_ARENA_NEW(&arena, km_complex, n * n), *LU = KM_ARENA_NEW(&arena, km_complex, n * n);
  km_complex *X = KM_ARENA_NEW(&arena, km_complex, n * n), *F = KM_ARENA_NEW(&arena, km_complex, n);
  km_complex *unit = KM_ARENA_NEW(&arena, km_complex, n);
  int *row = KM_ARENA_NEW(&arena, int, n);
  bool is_ok = !arena.failed;
  *out = (km_mode_proof){.h = nan(""), .error_bound = nan(""), .radius = nan("")};
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
      double beta = inverse / (1.0 - defect - inverse * c->size * rounding);
      double eta = beta * (sqrt(error) + sqrt(c->size) * rounding);
      if (beta > 0.0 && isfinite(beta)) {
        out->h = beta * eta * K;
        out->is_proved = out->h <= 0.5 && km_complex_has_all_rows(c);
        double root = sqrt(fmax(1.0 - 2.0 * out->h, 0.0));
        out->error_bound = 2.0 * eta / (1.0 + root);
        out->radius = (1.0 + root) / (beta * K);
      }
    }
  }
  km_arena_free(&arena);
  return is_ok;
}
