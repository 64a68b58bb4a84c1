/* Tracking of solutions along straight paths of parameters (homotopy.h). */
#include "space/complex/homotopy.h"

#include "space/complex/complex_solve.h"

#include <string.h>

/* First correction of a step, in radians and sizes: the step size aims at the target, steps above the limit are
 * rejected, and below the small one one factorisation is enough, since the error that remains is its square. */
static const double target_correction = 3e-2, correction_limit = 2e-1, small_correction = 1e-3;
static const double contraction = 0.25; /* largest ratio of two corrections of Newton's method */
static const double first_step = 0.02, shortest_step = 1e-9, largest_growth = 2.5, least_growth = 0.3;
/* Corrections at the end of a path. Those that no longer decrease are rounding up to the second size: solutions beside
 * a pole, with complex rotations of norm 1e2, lose four digits. */
static const double final_correction = 1e-11, rounded_correction = 1e-9;
static const double final_error = 1e-6; /* largest |H| at the end of a path over the largest part of a pose */
enum { MAX_STEPS = 500 };               /* a path takes some 40 steps, one that is lost beside a pole thousands */
static const double infinite_angle = 60.0, infinite_length = 1e9; /* imaginary part; sizes */

void km_homotopy_redirect(km_homotopy *h, uint64_t *random) {
  const km_complex_closure *c = h->closure;
  bool has_position = false;
  for (int i = 0; i < c->size; ++i) {
    h->direction[i] = c->turn_of[i] >= 0 ? 0.0 : km_complex_random(random);
    has_position = has_position || c->turn_of[i] < 0;
  }
  for (int i = c->size; i < h->section_start; ++i)
    h->direction[i] = has_position || !c->has_turn[i - c->size] ? 0.0 : km_complex_random(random);
}

bool km_homotopy_create(const km_complex_closure *closure, bool has_section, uint64_t *random, km_arena *arena,
                        km_homotopy *out) {
  int n = closure->size, size = n + has_section, length = closure->length + has_section;
  int section_start = n + 4 * closure->sub->loop_count, parameters = section_start + (has_section ? 3 : 0);
  *out = (km_homotopy){.closure = closure,
                       .has_section = has_section,
                       .size = size,
                       .length = length,
                       .parameter_count = parameters,
                       .section_start = section_start,
                       .step_factor = 1.0,
                       .functional_size = 1.0};
  out->direction = KM_ARENA_NEW(arena, km_complex, (size_t)section_start);
  out->turn = KM_ARENA_NEW(arena, km_complex, (size_t)(section_start - n));
  out->J = KM_ARENA_NEW(arena, km_complex, (size_t)(size * size));
  out->F = KM_ARENA_NEW(arena, km_complex, (size_t)size);
  out->parameter = KM_ARENA_NEW(arena, km_complex, (size_t)parameters);
  out->slope = KM_ARENA_NEW(arena, km_complex, (size_t)parameters);
  out->rates = KM_ARENA_NEW(arena, km_complex, (size_t)size);
  out->step = KM_ARENA_NEW(arena, km_complex, (size_t)size);
  out->rhs = KM_ARENA_NEW(arena, km_complex, (size_t)size);
  for (int k = 0; k < 3; ++k)
    out->point[k] = KM_ARENA_NEW(arena, km_wide, (size_t)length);
  for (int k = 0; k < 2; ++k)
    out->rate[k] = KM_ARENA_NEW(arena, km_complex, (size_t)length);
  out->row = KM_ARENA_NEW(arena, int, (size_t)size);
  if (!arena->failed)
    km_homotopy_redirect(out, random);
  return !arena->failed;
}

/* True if a component of `turn` belongs to a planar loop. */
static bool is_planar_turn(const km_complex_closure *c, int turn) {
  int place = c->sub->loop_start + turn / 4;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    if (place >= program->loop_start && place < program->loop_start + program->loop_count)
      return program->planar;
  }
  return false;
}

static const double imaginary_turn = 0.3; /* imaginary parts of quaternions with real parts of length 1 */

/* Decades of the section's numbers: random sizes reach the solutions far out, which exchange places on large closed
 * paths only. Half a decade left 6 of 24 searches of a Bennett linkage without them. */
static const double section_decades = 1.0;

/* 10^u, u uniform in [0, decades]. */
static double random_size(double decades, uint64_t *random) {
  return pow(10.0, decades * (0.5 + 0.5 * km_uniform(random)));
}

/* Draws a quaternion with the components that a loop has. */
static void draw_quaternion(const bool *has, uint64_t *random, km_complex *P) {
  double length = 0.0;
  for (int k = 0; k < 4; ++k) {
    km_complex z = km_complex_random(random);
    P[k] = has[k] ? km_complex_of(creal(z), imaginary_turn * cimag(z)) : 0.0;
    length += creal(P[k]) * creal(P[k]);
  }
  if (!has[0])
    P[0] = 1.0;
  else
    for (int k = 0; k < 4; ++k)
      P[k] = km_complex_of(creal(P[k]) / sqrt(length), cimag(P[k]));
}

void km_homotopy_draw(const km_homotopy *h, uint64_t *random, km_complex *parameters) {
  const km_complex_closure *c = h->closure;
  for (int i = 0; i < h->parameter_count; ++i)
    parameters[i] = i < c->size && c->turn_of[i] >= 0 ? 0.0 : km_complex_random(random);
  if (h->has_section) {
    parameters[h->section_start] *= random_size(section_decades, random);
    for (int k = 1; k < 3; ++k)
      parameters[h->section_start + k] *= h->functional_size * random_size(section_decades, random);
  }
  for (int l = 0; l < c->sub->loop_count; ++l)
    draw_quaternion(c->has_turn + 4 * l, random, parameters + c->size + 4 * l);
}

void km_homotopy_close(const km_homotopy *h, km_complex *parameters) {
  memset(parameters, 0, (size_t)h->parameter_count * sizeof *parameters);
  for (int l = 0; l < h->closure->sub->loop_count; ++l)
    parameters[h->closure->size + 4 * l] = 1.0;
}

void km_homotopy_begin(const km_homotopy *h, const km_wide *centre, uint64_t *random, km_wide *x,
                       km_complex *parameters) {
  const km_complex_closure *c = h->closure;
  km_homotopy_close(h, parameters);
  bool is_near = false;
  for (double distance = 0.5; !is_near && distance > 1e-3; distance *= 0.5) {
    km_complex_values values = {.F = parameters, .functional = -1};
    km_complex_randomise(c, centre, distance, random, x);
    km_complex_evaluate(c, x, &values);
    is_near = true;
    for (int i = 0; i < c->size; ++i)
      is_near = is_near && !(c->turn_of[i] >= 0 && cabs(parameters[i]) > 1.0);
  }
  for (int i = 0; i < c->size; ++i)
    if (c->turn_of[i] >= 0) {
      km_complex error = parameters[i]; /* 2 g; of a planar loop (A − 1)/i */
      bool is_planar = is_planar_turn(c, c->turn_of[i]);
      parameters[c->size + c->turn_of[i]] = is_planar ? error / (2.0 + KM_I * error) : 0.5 * error;
      parameters[i] = 0.0;
    }
}

/* Component of the angular velocity ω = 2 vec(Ḋ P*) / (P·P) of a loop's rotation P of the last evaluation, if P changes
 * at the rate Ḋ: parameters' rates. */
static km_complex turn_rate(const km_homotopy *h, int turn, const km_complex *rates) {
  const km_complex *P = h->turn + turn / 4 * 4, *D = rates + h->closure->size + turn / 4 * 4;
  int k = turn % 4, i = 1 + k % 3, j = 1 + (k + 1) % 3;
  km_complex square = P[0] * P[0] + P[1] * P[1] + P[2] * P[2] + P[3] * P[3];
  return 2.0 * (D[k] * P[0] - D[0] * P[k] - D[i] * P[j] + D[j] * P[i]) / square;
}

/* Computes H and factors H_x at x and the present parameters; h->F = −H. False: singular. */
static bool linearise(km_homotopy *h, const km_wide *x, km_complex *section_value) {
  int n = h->closure->size, stride = h->size;
  const km_complex *P = h->parameter, *section = P + h->section_start;
  km_complex_values values = {.turn = h->turn,
                              .F = h->F,
                              .J = h->J,
                              .stride = stride,
                              .functional = h->has_section ? KM_TRACE : -1,
                              .is_narrow = h->is_narrow,
                              .gradient = h->has_section ? h->J + n * stride : NULL};
  km_complex s = h->has_section ? (km_complex)x[h->closure->length] : 0.0;
  for (int i = n; i < h->section_start; ++i)
    h->turn[i - n] = P[i] + s * h->direction[i];
  km_complex_evaluate(h->closure, x, &values);
  for (int i = 0; i < n; ++i)
    h->F[i] = P[i] + s * h->direction[i] - h->F[i];
  if (h->has_section) {
    km_complex *last = h->J + n * stride;
    *section_value = values.value;
    for (int i = 0; i < n; ++i) {
      h->J[i * stride + n] =
          h->closure->turn_of[i] < 0 ? -h->direction[i] : -turn_rate(h, h->closure->turn_of[i], h->direction);
      last[i] *= s - section[0];
    }
    last[n] = values.value - section[1];
    h->F[n] = section[2] - (s - section[0]) * last[n];
  }
  ++h->evaluations;
  return km_complex_factor(h->J, h->size, stride, h->row);
}

/* Rates of the unknowns along the path, from the present factors. */
static void path_rates(km_homotopy *h, const km_wide *x, km_complex section_value, km_complex *out) {
  int n = h->closure->size;
  for (int i = 0; i < n; ++i)
    h->rhs[i] = h->closure->turn_of[i] < 0 ? h->slope[i] : turn_rate(h, h->closure->turn_of[i], h->slope);
  if (h->has_section) {
    const km_complex *section = h->parameter + h->section_start, *slope = h->slope + h->section_start;
    h->rhs[n] = slope[2] + slope[0] * (section_value - section[1]) +
                ((km_complex)x[h->closure->length] - section[0]) * slope[1];
  }
  km_complex_solve(h->J, h->size, h->size, h->row, h->rhs, h->rates);
  km_complex_rate(h->closure, x, h->rates, out);
  if (h->has_section)
    out[h->closure->length] = h->rates[n];
}

/* One step of Newton's method with the present factors. Returns its size, relative for s. */
static double correct(km_homotopy *h, km_wide *x) {
  int n = h->closure->size;
  km_complex_solve(h->J, h->size, h->size, h->row, h->F, h->step);
  double largest = km_complex_move(h->closure, h->step, x);
  if (h->has_section) {
    double size = cabs(h->step[n]) / (1.0 + cabs((km_complex)x[h->closure->length]));
    largest = size > largest || isnan(size) ? size : largest;
    x[h->closure->length] += h->step[n];
  }
  return largest;
}

/* True if the section changes the rotation P, four numbers from `first`: P + s V, V ≠ 0. The end −P would need −V. */
static bool changes_on_section(const km_homotopy *h, int first) {
  bool changes = false;
  for (int k = first; k < first + 4; ++k)
    changes = changes || (h->has_section && h->direction[k] != 0.0);
  return changes;
}

/* Sets the slope of the path. P and −P are one rotation: the nearer one is the end. */
static void set_slope(km_homotopy *h, const km_complex *from, const km_complex *to) {
  for (int i = 0; i < h->parameter_count; ++i)
    h->slope[i] = to[i] - from[i];
  for (int first = h->closure->size; first < h->section_start; first += 4) {
    double along = 0.0;
    for (int k = first; k < first + 4; ++k)
      along += creal(from[k]) * creal(to[k]);
    for (int k = first; k < first + 4 && along < 0.0 && !changes_on_section(h, first); ++k)
      h->slope[k] = -to[k] - from[k];
  }
}

/* Sets the parameters of the path at t. */
static void set_parameters(km_homotopy *h, const km_complex *from, double t) {
  for (int i = 0; i < h->parameter_count; ++i)
    h->parameter[i] = from[i] + t * h->slope[i];
}

/* Cubic Hermite extrapolation from the points at −g and 0 to `step`; Euler's step without a last point (g = 0). */
static void predict(const km_homotopy *h, double g, double step, km_wide *out) {
  const km_wide *x0 = h->point[0], *x1 = h->point[1];
  const km_complex *r0 = h->rate[0], *r1 = h->rate[1];
  if (g <= 0.0) {
    for (int i = 0; i < h->length; ++i)
      out[i] = x1[i] + step * r1[i];
  } else {
    double u = 1.0 + step / g; /* 0 is the last point, 1 the present one */
    double b = u * u * (3.0 - 2.0 * u), c = u * u * (u - 1.0) * g, d = u * (u - 1.0) * (u - 1.0) * g;
    for (int i = 0; i < h->length; ++i)
      out[i] = x0[i] + b * (x1[i] - x0[i]) + c * r1[i] + d * r0[i];
  }
  km_complex_normalise(h->closure, out);
}

static bool is_infinite(const km_homotopy *h, const km_wide *x) {
  const km_complex_closure *c = h->closure;
  for (int i = 0; i < c->size; ++i) {
    int k = c->column_of[i], coordinate = c->m->column_coordinate[c->sub->column_start + k];
    if (c->m->ball_of[coordinate] >= 0)
      continue;
    bool is_length = km_model_coordinate_is_length(c->m->model, coordinate);
    km_complex number = (km_complex)x[c->start_of[k]];
    if (!(is_length ? cabs(number) <= infinite_length : fabs(cimag(number)) <= infinite_angle))
      return true;
  }
  return false;
}

/* True if the errors at the end of a path are rounding: Newton's method can converge to other points beside poles. */
static bool is_solution(km_homotopy *h, const km_wide *x, km_complex *section_value) {
  bool is_small = linearise(h, x, section_value);
  double largest = final_error * fmax(km_complex_pose_extent(h->closure, x).largest, 1.0);
  for (int i = 0; i < h->size; ++i)
    is_small = is_small && cabs(h->F[i]) <= largest;
  return is_small;
}

/* Corrects the predicted point. Returns the first correction, infinity if the step is rejected. */
static double correct_step(km_homotopy *h, km_wide *x, km_complex *section_value, bool is_last) {
  if (!linearise(h, x, section_value))
    return HUGE_VAL;
  double first = correct(h, x), last = first;
  if (!(first <= correction_limit * h->step_factor))
    return HUGE_VAL;
  double enough = is_last ? final_correction : small_correction;
  for (int i = 0; last > enough && i < (is_last ? 6 : 1); ++i) {
    if (!linearise(h, x, section_value))
      return HUGE_VAL;
    double next = correct(h, x);
    if (!(next <= contraction * last))
      return next <= (is_last ? rounded_correction : small_correction) ? first : HUGE_VAL;
    last = next;
  }
  return first;
}

static void exchange(km_wide **a, km_wide **b) {
  km_wide *before = *a;
  *a = *b;
  *b = before;
}

km_path_outcome km_homotopy_track(km_homotopy *h, const km_complex *from, const km_complex *to, km_wide *x) {
  size_t bytes = (size_t)h->length * sizeof *x;
  double t = 0.0, step = first_step * h->step_factor, last = 0.0;
  km_complex section_value = 0.0;
  km_path_outcome outcome = KM_PATH_ARRIVED;
  h->is_narrow = h->step_factor == 1.0;
  set_slope(h, from, to);
  set_parameters(h, from, 0.0);
  memcpy(h->point[1], x, bytes);
  if (!linearise(h, x, &section_value))
    outcome = KM_PATH_SINGULAR;
  else
    path_rates(h, x, section_value, h->rate[1]);
  for (int i = 0; outcome == KM_PATH_ARRIVED && t < 1.0; ++i) {
    if (i == MAX_STEPS) {
      outcome = KM_PATH_SINGULAR;
      break;
    }
    bool is_last = t + 1.001 * step >= 1.0;
    double end = is_last ? 1.0 : t + step;
    predict(h, last, end - t, h->point[2]);
    set_parameters(h, from, end);
    h->is_narrow = h->step_factor == 1.0 && !is_last;
    double first = correct_step(h, h->point[2], &section_value, is_last);
    if (first == HUGE_VAL) {
      step = 0.4 * (end - t);
      if (step < shortest_step * (1.0 - t) || step < 1e-14)
        outcome = KM_PATH_SINGULAR;
      continue;
    }
    exchange(&h->point[0], &h->point[1]);
    exchange(&h->point[1], &h->point[2]);
    km_complex *rate = h->rate[0];
    h->rate[0] = h->rate[1];
    h->rate[1] = rate;
    if (is_last && !is_solution(h, h->point[1], &section_value))
      outcome = KM_PATH_SINGULAR;
    path_rates(h, h->point[1], section_value, h->rate[1]);
    last = end - t;
    t = end;
    double growth = pow(target_correction * h->step_factor / (first + 1e-30), 0.25);
    step = last * fmin(fmax(growth, least_growth), largest_growth);
    if (is_infinite(h, h->point[1]))
      outcome = KM_PATH_INFINITE;
  }
  memcpy(x, h->point[1], bytes);
  h->reached = t;
  return outcome;
}
