/* Gauss-Newton search for the nearest mechanism of a given rank.
 *
 *   configurations   q_0 from the start; further ones by steps along the motion, in both senses, at most 0.25 rad or
 *                    sizes in a coordinate
 *   Newton           δ = −V_1 S_1⁻¹ U_1ᵀ e, the first `rank` singular directions
 *   weights          x_k = ω_k y_k, |y| minimal; ω_k falls where |x_k| > 1, so that changes stay within half a digit */
#include "rounding/nearest_mechanism.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "base/random.h"
#include "linalg/dense/singular_values.h"

#include <float.h>
#include <string.h>

enum { FIRST_CONFIGURATIONS = 12, MOST_CONFIGURATIONS = 64, LEAST_CONFIGURATIONS = 4 };
enum { NEWTON_STEPS = 25, GAUSS_NEWTON_STEPS = 25, SCOUTING_STEPS = 30 };
/* Radians or sizes, of the largest coordinate between configurations and in a Newton step. */
static const double step_length = 0.25;
static const double closed_gap = 2e-14;        /* scaled: the rounding error of a product of about ten poses */
static const double polished = 0.25;           /* part of the bounds that is tried afterwards: as exact files give */
static const double least_conditioning = 0.02; /* smallest singular value kept, relative to that at the start */
static const double within_rounding = 1.05;    /* largest |x|: a half, and 5 % for the linear effect of a number on R */

/* Gap of configurations between, where errors of x are a few times larger. */
static double checked_gap(void) {
  return 10.0 * closed_gap;
}

km_status km_nearest_create(km_model *model, const km_compiling *options, const km_mechanism *m, km_state *state,
                            const km_pose *written, int index, int most_numbers, km_arena *arena,
                            km_nearest_mechanism *out, km_error *error) {
  *out = (km_nearest_mechanism){
      .model = model, .options = options, .arena = arena, .index = index, .m = m, .s = state, .written = written};
  out->number = KM_ARENA_NEW(arena, km_written_number, (size_t)most_numbers);
  out->half = KM_ARENA_NEW(arena, double, (size_t)most_numbers);
  out->x = KM_ARENA_NEW(arena, double, (size_t)most_numbers);
  if (arena->failed || !km_loop_gaps_create(m, state, index, arena, &out->gaps))
    return km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  size_t rows = (size_t)out->gaps.rows, columns = (size_t)out->gaps.columns;
  out->rows = out->gaps.rows;
  out->columns = out->gaps.columns;
  out->e = KM_ARENA_NEW(arena, double, rows);
  out->J = KM_ARENA_NEW(arena, double, rows *columns);
  out->E = KM_ARENA_NEW(arena, double, rows *(size_t)most_numbers);
  out->S = KM_ARENA_NEW(arena, double, rows < columns ? rows : columns);
  out->U = KM_ARENA_NEW(arena, double, rows *rows);
  out->Vt = KM_ARENA_NEW(arena, double, columns *columns);
  out->configuration = KM_ARENA_NEW(arena, double, MOST_CONFIGURATIONS *KM_SAVED_PER_COLUMN *columns);
  out->heading = KM_ARENA_NEW(arena, double, MOST_CONFIGURATIONS *columns);
  out->start = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *columns);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism") : KM_OK;
}

void km_nearest_release(km_nearest_mechanism *n) {
  if (n->own)
    km_state_free(n->s);
  km_mechanism_free(n->own);
  n->own = NULL;
  n->s = NULL;
  n->m = NULL;
}

/* The pose of a frame after the changes x. */
static km_pose changed_pose(const km_nearest_mechanism *n, int frame) {
  km_vec3 move = {0, 0, 0}, turn = {0, 0, 0};
  for (int k = 0; k < n->count; ++k) {
    const km_written_number *number = &n->number[k];
    if (n->x[k] == 0.0 || (number->frame[0] != frame && number->frame[1] != frame))
      continue;
    move = km_vec3_axpy(n->half[k] * n->x[k], number->move, move);
    turn = km_vec3_axpy(n->half[k] * n->x[k], number->turn, turn);
  }
  km_rotation R = km_quaternion_rotation(km_quaternion_exp(turn));
  const km_pose *written = &n->written[frame];
  return (km_pose){km_rotation_product(&R, &written->R), km_vec3_add(written->p, move)};
}

km_status km_nearest_apply(km_nearest_mechanism *n, km_error *error) {
  km_status status = KM_OK;
  for (int k = 0; k < n->count && !status; ++k)
    for (int end = 0; end < 2 && !status; ++end) {
      int f = n->number[k].frame[end];
      bool again = k > 0 && n->number[k - 1].frame[0] == n->number[k].frame[0]; /* numbers of a frame are adjacent */
      if (f < 0 || again)
        continue;
      km_pose pose = changed_pose(n, f);
      const double T[3] = {pose.p.x, pose.p.y, pose.p.z};
      double R[9];
      km_rotation_rows(&pose.R, R);
      status = km_model_set_frame(n->model, f, T, R, error);
    }
  if (status)
    return status;
  km_nearest_release(n);
  status = km_mechanism_compile_as(n->model, n->options, &n->own, error);
  n->m = n->own;
  if (!status)
    status = km_state_create(n->m, &n->s, error);
  if (!status)
    km_loop_gaps_replace(&n->gaps, n->m, n->s);
  return status;
}

km_status km_nearest_decompose(km_nearest_mechanism *n, km_error *error) {
  km_loop_gaps_compute(&n->gaps, n->e, n->J);
  return km_singular_value_decomposition(n->rows, n->columns, n->J, true, n->S, n->U, n->Vt, error);
}

static const km_substructure *substructure(const km_nearest_mechanism *n) {
  return &n->m->substructures[n->index];
}

km_status km_nearest_correct(km_nearest_mechanism *n, bool *converged, km_error *error) {
  double *step = n->s->work, before = HUGE_VAL;
  *converged = false;
  for (int i = 0; i < NEWTON_STEPS; ++i) {
    km_status status = km_nearest_decompose(n, error);
    if (status)
      return status;
    memset(step, 0, (size_t)n->columns * sizeof *step);
    for (int r = 0; r < n->rank; ++r) {
      double along = -km_dot(n->U + (size_t)r * (size_t)n->rows, n->e, n->rows) / n->S[r];
      for (int c = 0; c < n->columns; ++c)
        step[c] += along * n->Vt[(size_t)c * (size_t)n->columns + (size_t)r];
    }
    double size = km_max_norm(step, n->columns);
    *converged = size <= 4.0 * DBL_EPSILON || (size < 1e-9 && size >= 0.5 * before);
    if (*converged)
      return KM_OK;
    for (int c = 0; c < n->columns && size > step_length; ++c)
      step[c] *= step_length / size;
    before = size;
    km_state_move(n->m, n->s, substructure(n), step);
  }
  return KM_OK;
}

static double *configuration(const km_nearest_mechanism *n, int i) {
  return n->configuration + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)n->columns;
}

/* Writes a unit step (largest entry 1) in the null space of the present J: `from` projected on it, or random; with many
 * freedoms both. */
static void choose_heading(const km_nearest_mechanism *n, const double *from, uint64_t *random, double *out) {
  int freedom = n->columns - n->rank;
  memset(out, 0, (size_t)n->columns * sizeof *out);
  for (int r = n->rank; r < n->columns; ++r) {
    double along = from ? 0.0 : km_uniform(random);
    for (int c = 0; c < n->columns && from; ++c)
      along += from[c] * n->Vt[(size_t)c * (size_t)n->columns + (size_t)r];
    if (from && freedom > 1)
      along += km_uniform(random);
    for (int c = 0; c < n->columns; ++c)
      out[c] += along * n->Vt[(size_t)c * (size_t)n->columns + (size_t)r];
  }
  double size = km_max_norm(out, n->columns);
  for (int c = 0; c < n->columns && size > 0.0; ++c)
    out[c] /= size;
}

/* Steps from the saved configuration `base` along `from` (NULL: at random) by `length`, or less where Newton's method
 * fails or the smallest singular value kept falls. The state is left there. */
static km_status walk(km_nearest_mechanism *n, const double *base, const double *from, double length,
                      double conditioning, uint64_t *random, double *heading, bool *walked, km_error *error) {
  *walked = false;
  for (int attempt = 0; attempt < 4 && !*walked; ++attempt, length *= 0.5) {
    bool converged;
    km_state_restore(n->s, substructure(n), base);
    km_status status = km_nearest_decompose(n, error);
    if (status)
      return status;
    choose_heading(n, from, random, heading);
    for (int c = 0; c < n->columns; ++c)
      n->s->work[c] = length * heading[c];
    km_state_move(n->m, n->s, substructure(n), n->s->work);
    status = km_nearest_correct(n, &converged, error);
    if (status)
      return status;
    *walked = converged && n->S[n->rank - 1] >= least_conditioning * conditioning;
  }
  return KM_OK;
}

/* Adds configurations up to `target`: two chains from the start in opposite senses, then others from the start. */
static km_status extend(km_nearest_mechanism *n, int target, double conditioning, uint64_t *random, km_error *error) {
  size_t columns = (size_t)n->columns;
  double *from = KM_ARENA_NEW(n->arena, double, columns);
  if (!from)
    return km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  for (int failures = 0; n->configuration_count < target && failures < 4;) {
    int i = n->configuration_count, base = i > 2 && failures == 0 ? i - 2 : 0;
    bool is_first = i == 1 || failures > 0, walked;
    for (size_t c = 0; c < columns && !is_first; ++c)
      from[c] = i == 2 ? -n->heading[columns + c] : n->heading[(size_t)base * columns + c];
    km_status status = walk(n, configuration(n, base), is_first ? NULL : from, step_length, conditioning, random,
                            n->heading + (size_t)i * columns, &walked, error);
    if (status)
      return status;
    failures += !walked;
    if (walked) {
      km_state_save(n->s, substructure(n), configuration(n, i));
      n->configuration_count = i + 1;
    }
  }
  return KM_OK;
}

/* The conditions of all configurations on the change ω y of x, N_iᵀ E_i h ω y = −N_iᵀ e_i. */
typedef struct conditions {
  int rows, most_rows;
  double *A, *b;  /* [most_rows × count], column-major; [most_rows] */
  double *weight; /* [count] ω */
  double gap;     /* largest |e| */
} conditions;

/* Adds the relations and what they lack. */
static void add_relations(const km_nearest_mechanism *n, conditions *c) {
  if (!n->relations)
    return;
  double *b = c->b + c->rows;
  int rows = km_relations_rows(n->relations);
  km_relations_compute(n->relations, n->model, n->number, n->half, n->count, b, c->A + c->rows, (size_t)c->most_rows);
  c->gap = fmax(c->gap, km_max_norm(b, rows));
  for (int r = 0; r < rows; ++r) {
    b[r] = -b[r];
    for (int k = 0; k < n->count; ++k)
      c->A[(size_t)k * (size_t)c->most_rows + (size_t)(c->rows + r)] *= c->weight[k];
  }
  c->rows += rows;
}

static km_status gather(km_nearest_mechanism *n, conditions *c, km_error *error) {
  int redundant = n->rows - n->rank;
  c->rows = 0;
  c->gap = 0.0;
  for (int i = 0; i < n->configuration_count; ++i) {
    bool converged;
    km_state_restore(n->s, substructure(n), configuration(n, i));
    km_status status = km_nearest_correct(n, &converged, error);
    if (status)
      return status;
    if (converged)
      km_state_save(n->s, substructure(n), configuration(n, i));
    else if (i > 0)
      continue;
    km_loop_gaps_number_columns(&n->gaps, n->number, n->half, n->count, n->E);
    c->gap = fmax(c->gap, km_max_norm(n->e, n->rows));
    for (int r = 0; r < redundant; ++r) {
      const double *w = n->U + (size_t)(n->rank + r) * (size_t)n->rows;
      for (int k = 0; k < n->count; ++k) {
        double a = km_dot(w, n->E + (size_t)k * (size_t)n->rows, n->rows);
        c->A[(size_t)k * (size_t)c->most_rows + (size_t)c->rows] = a * c->weight[k];
      }
      c->b[c->rows++] = -km_dot(w, n->e, n->rows);
    }
  }
  add_relations(n, c);
  return KM_OK;
}

/* A = U S Vᵀ of the conditions. */
typedef struct decomposition {
  km_arena arena;
  int rows, count; /* number of singular values */
  double *S, *U, *Vt;
} decomposition;

static km_status decompose(const km_nearest_mechanism *n, const conditions *c, decomposition *d, km_error *error) {
  *d = (decomposition){.rows = c->rows, .count = c->rows < n->count ? c->rows : n->count};
  double *A = KM_ARENA_NEW(&d->arena, double, (size_t)c->rows *(size_t)n->count);
  d->S = KM_ARENA_NEW(&d->arena, double, (size_t)d->count);
  d->U = KM_ARENA_NEW(&d->arena, double, (size_t)c->rows *(size_t)d->count);
  d->Vt = KM_ARENA_NEW(&d->arena, double, (size_t)d->count *(size_t)n->count);
  if (d->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  for (int k = 0; k < n->count; ++k)
    memcpy(A + (size_t)k * (size_t)c->rows, c->A + (size_t)k * (size_t)c->most_rows, (size_t)c->rows * sizeof *A);
  return km_singular_value_decomposition(c->rows, n->count, A, false, d->S, d->U, d->Vt, error);
}

/* Adds ω y to x, A y = b with |y| minimal. A direction of y whose singular value would need a larger change than
 * rounding allows to close the gap is left out: it is noise of A, which the other directions lower. */
static km_status solve(km_nearest_mechanism *n, const conditions *c, km_error *error) {
  static const double largest_step = 2.0; /* halves */
  decomposition d;
  km_status status = decompose(n, c, &d, error);
  for (int i = 0; i < d.count && !status && d.S[i] > fmax(c->gap / largest_step, closed_gap); ++i) {
    double along = km_dot(d.U + (size_t)i * (size_t)d.rows, c->b, d.rows) / d.S[i];
    for (int k = 0; k < n->count; ++k)
      n->x[k] += c->weight[k] * along * d.Vt[(size_t)k * (size_t)d.count + (size_t)i];
  }
  km_arena_free(&d.arena);
  return status;
}

/* True if rounding explains changes of this size: of c conditions on numbers whose errors are uniform on [−1, 1],
 * 3 |Px|² is distributed like χ² of c freedoms, P the projector on the rows of A, and at most c + 2 √(c t) + 2 t with a
 * probability of 1 − e^−t (B. Laurent and P. Massart 2000). */
static km_status is_plausible(const km_nearest_mechanism *n, const conditions *c, bool *plausible, km_error *error) {
  const double t = log(1000.0); /* one of 1000 at most is refused wrongly */
  double square = 0.0;
  int count = 0;
  decomposition d;
  km_status status = decompose(n, c, &d, error);
  for (; count < d.count && !status && d.S[count] > km_relative_zero * d.S[0]; ++count) {
    double along = 0.0;
    for (int k = 0; k < n->count; ++k)
      along += n->x[k] / c->weight[k] * d.Vt[(size_t)k * (size_t)d.count + (size_t)count];
    square += along * along;
  }
  *plausible = 3.0 * square <= count + 2.0 * sqrt(count * t) + 2.0 * t;
  km_arena_free(&d.arena);
  return status;
}

/* Gauss-Newton steps at the present configurations. */
static km_status iterate(km_nearest_mechanism *n, conditions *c, bool *closed, km_error *error) {
  *closed = false;
  for (int i = 0; i < GAUSS_NEWTON_STEPS; ++i) {
    km_status status = km_nearest_apply(n, error);
    if (!status)
      status = gather(n, c, error);
    if (status)
      return status;
    *closed = c->gap <= closed_gap || (i > 4 && c->gap <= checked_gap());
    if (*closed)
      return KM_OK;
    status = solve(n, c, error);
    if (status || km_max_norm(n->x, n->count) > km_significant_ratio)
      return status;
  }
  return KM_OK;
}

/* True if the loops are closed, and J has its rank, at the state's configuration. */
static bool is_exact_here(const km_nearest_mechanism *n) {
  bool has_rank =
      n->rank == n->columns || n->rank == n->rows || n->S[n->rank] <= n->strictness * km_solved_rounding * n->S[0];
  return has_rank && km_max_norm(n->e, n->rows) <= n->strictness * checked_gap();
}

/* Adds the state's configuration, reached along `heading`, to those of the search. */
static void add_configuration(km_nearest_mechanism *n, const double *heading) {
  if (n->configuration_count == MOST_CONFIGURATIONS)
    return;
  memcpy(n->heading + (size_t)n->configuration_count * (size_t)n->columns, heading,
         (size_t)n->columns * sizeof *heading);
  km_state_save(n->s, substructure(n), configuration(n, n->configuration_count++));
}

/* Follows the motion from configuration i, until a step fails or the loops don't close: that configuration is added. */
static km_status scout(km_nearest_mechanism *n, int i, double conditioning, uint64_t *random, double *workspace,
                       bool *closed, km_error *error) {
  size_t columns = (size_t)n->columns;
  double *from = workspace, *heading = from + columns, *at = heading + columns;
  memcpy(from, n->heading + (size_t)i * columns, columns * sizeof *from);
  memcpy(at, configuration(n, i), KM_SAVED_PER_COLUMN * columns * sizeof *at);
  for (int k = 0; k < SCOUTING_STEPS; ++k) {
    bool walked;
    km_status status = walk(n, at, from, step_length, conditioning, random, heading, &walked, error);
    if (status || !walked)
      return status;
    if (!is_exact_here(n)) {
      *closed = false;
      add_configuration(n, heading);
      return KM_OK;
    }
    memcpy(from, heading, columns * sizeof *from);
    km_state_save(n->s, substructure(n), at);
  }
  return KM_OK;
}

/* True if the loops close at other configurations too: between those of the search, and further along the motion in
 * both senses. Those where they don't are added. */
static km_status check_elsewhere(km_nearest_mechanism *n, double conditioning, uint64_t *random, bool *closed,
                                 km_error *error) {
  size_t columns = (size_t)n->columns;
  double *workspace = KM_ARENA_NEW(n->arena, double, (2 + KM_SAVED_PER_COLUMN) * columns);
  int count = n->configuration_count;
  km_status status = workspace ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  *closed = true;
  for (int i = 0; i < count && !status; ++i) {
    bool walked;
    double length = (0.3 + 0.3 * fabs(km_uniform(random))) * step_length;
    status = walk(n, configuration(n, i), NULL, length, conditioning, random, workspace, &walked, error);
    if (status || !walked || is_exact_here(n))
      continue;
    *closed = false;
    add_configuration(n, workspace);
  }
  for (int i = count > 2 ? count - 2 : count - 1; i < count && *closed && !status; ++i)
    status = scout(n, i, conditioning, random, workspace, closed, error);
  return status;
}

/* Lowers the weights of numbers that change by more than half a digit, and starts again. */
static void lower_weights(km_nearest_mechanism *n, double *weight) {
  for (int k = 0; k < n->count; ++k) {
    weight[k] /= fmax(1.0, fabs(n->x[k]));
    n->x[k] = 0.0;
  }
}

/* Corrects the start configuration and finds the smallest singular value kept there. */
static km_status begin(km_nearest_mechanism *n, double *conditioning, bool *converged, km_error *error) {
  memset(n->x, 0, (size_t)n->count * sizeof *n->x);
  km_status status = km_nearest_apply(n, error);
  if (status)
    return status;
  km_state_restore(n->s, substructure(n), n->start);
  status = km_nearest_correct(n, converged, error);
  if (status)
    return status;
  *conditioning = n->rank > 0 ? n->S[n->rank - 1] : 1.0;
  km_state_save(n->s, substructure(n), configuration(n, 0));
  n->configuration_count = 1;
  return KM_OK;
}

static km_status reserve_conditions(const km_nearest_mechanism *n, int rows, conditions *out, km_error *error) {
  *out = (conditions){.most_rows = rows + (n->relations ? km_relations_rows(n->relations) : 0)};
  out->A = KM_ARENA_NEW(n->arena, double, (size_t)out->most_rows *(size_t)(n->count + 1));
  out->b = KM_ARENA_NEW(n->arena, double, (size_t)out->most_rows);
  out->weight = KM_ARENA_NEW(n->arena, double, (size_t)n->count + 1);
  if (n->arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  for (int k = 0; k < n->count; ++k)
    out->weight[k] = 1.0;
  return KM_OK;
}

km_status km_nearest_regular(km_nearest_mechanism *n, bool *found, km_error *error) {
  conditions c;
  km_status status = reserve_conditions(n, 0, &c, error);
  *found = false;
  n->configuration_count = 0;
  memset(n->x, 0, (size_t)n->count * sizeof *n->x);
  if (!status && n->count > 0 && c.most_rows > 0)
    status = iterate(n, &c, found, error);
  *found = *found && km_max_norm(n->x, n->count) <= within_rounding;
  return status;
}

/* Closes the loops of a mechanism that was found still better, at the configurations where they are open most. Its
 * numbers stay if that fails. */
static km_status polish(km_nearest_mechanism *n, conditions *c, double conditioning, uint64_t *random,
                        km_error *error) {
  enum { MOST_POLISHING = 6 };
  double *x = KM_ARENA_NEW(n->arena, double, (size_t)n->count);
  if (!x)
    return km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
  memcpy(x, n->x, (size_t)n->count * sizeof *x);
  n->strictness = polished;
  bool closed = true, improved = false;
  km_status status = KM_OK;
  for (int i = 0; i < MOST_POLISHING && closed && !improved && !status; ++i) {
    status = check_elsewhere(n, conditioning, random, &improved, error);
    if (!status && !improved)
      status = iterate(n, c, &closed, error);
    closed = closed && km_max_norm(n->x, n->count) <= within_rounding;
  }
  n->strictness = 1.0;
  if (status || improved)
    return status;
  memcpy(n->x, x, (size_t)n->count * sizeof *x);
  return km_nearest_apply(n, error);
}

km_status km_nearest_find(km_nearest_mechanism *n, bool *found, km_error *error) {
  enum { MOST_ROUNDS = 60 };
  int redundant = n->rows - n->rank, target = 2 * redundant + 2;
  target = target < LEAST_CONFIGURATIONS   ? LEAST_CONFIGURATIONS
           : target > FIRST_CONFIGURATIONS ? FIRST_CONFIGURATIONS
                                           : target;
  conditions c;
  km_status reserved = reserve_conditions(n, MOST_CONFIGURATIONS * (redundant > 0 ? redundant : 1), &c, error);
  *found = false;
  if (reserved)
    return reserved;
  if (n->count == 0 || n->rank == 0 || redundant == 0)
    return KM_OK;
  double conditioning;
  uint64_t random = 1;
  bool closed;
  n->strictness = 1.0;
  km_status status = begin(n, &conditioning, &closed, error);
  if (status || !closed)
    return status;
  for (int round = 0; round < MOST_ROUNDS; ++round) {
    status = iterate(n, &c, &closed, error);
    if (status || !closed || km_max_norm(n->x, n->count) > km_significant_ratio)
      return status;
    if (n->configuration_count < target) {
      int next = 2 * n->configuration_count + 1, before = n->configuration_count;
      status = extend(n, next < target ? next : target, conditioning, &random, error);
      if (status)
        return status;
      if (n->configuration_count > before)
        continue;
      if (n->configuration_count < LEAST_CONFIGURATIONS)
        return KM_OK;
      target = n->configuration_count;
    }
    if (km_max_norm(n->x, n->count) > within_rounding) {
      lower_weights(n, c.weight);
      continue;
    }
    status = check_elsewhere(n, conditioning, &random, &closed, error);
    if (!status && closed)
      status = is_plausible(n, &c, found, error);
    if (!status && *found)
      status = polish(n, &c, conditioning, &random, error);
    if (status || closed)
      return status;
  }
  return KM_OK;
}
