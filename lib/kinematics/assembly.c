/* Assembly: closes all loops of a model from its initial displacements (docs/theory.md 4.3).
 *
 *   1. full closing by Newton's method (4.2)
 *   2. min |e|² + 1e-10 |δ|² by Levenberg-Marquardt, then 1
 *   3. 1 and 2 from displaced starts q + a u, u random in [−1, 1]ⁿ, a = 0.05 · 1.2^k
 *
 * Loops that violate the polygon inequality close from no start. A closure tolerance is suggested for rounded data. */
#include "kinematics/assembly.h"
#include "base/number/tolerances.h"
#include "base/random.h"
#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/polygon_inequality.h"
#include "kmech/mechanism.h"
#include "topology/compile.h"

#include <string.h>

/* Misfits (scaled rms) below this are rounding of the data, larger ones are open loops. */
static const double max_rounding_misfit = 5e-3;

static km_closure_outcome close_fully(const km_mechanism *m, km_state *s, int index, km_closure *evidence) {
  return km_loops_close_fully(m, s, index, &(km_pivoting){.driver = KM_NO_DRIVER, .basis = KM_BASIS_ANY}, evidence);
}

/* Levenberg-Marquardt from the present configuration, then full closing by Newton's method. */
static km_closure_outcome relax_and_close(const km_mechanism *m, km_state *s, int index, km_closure *evidence,
                                          km_status *status, km_error *error) {
  *status = km_damped_least_squares(m, s, index, error);
  return *status ? KM_OPEN : close_fully(m, s, index, evidence);
}

/* Newton's method from the present configuration, else Levenberg-Marquardt and Newton's method. A small misfit of
 * secondary rows is left to the caller, since least squares would move along the motion that rounded data conceal.
 * Other substructures are not moved. */
static km_closure_outcome close_from_here(const km_mechanism *m, km_state *s, int index, double *saved,
                                          km_closure *evidence, km_status *status, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  km_state_save(s, sub, saved);
  km_closure_outcome outcome = close_fully(m, s, index, evidence);
  if (outcome == KM_CLOSED || (outcome == KM_INCONSISTENT && evidence->residual < max_rounding_misfit))
    return outcome;
  km_state_restore(s, sub, saved);
  return relax_and_close(m, s, index, evidence, status, error);
}

km_status km_assemble_one(const km_mechanism *m, km_state *s, int substructure, double *saved, bool *closed) {
  km_closure evidence;
  km_status status = KM_OK;
  *closed = close_from_here(m, s, substructure, saved, &evidence, &status, NULL) == KM_CLOSED && !status;
  return status;
}

/* A start with links on one line, or a symmetric one, is a stationary point of |e|², which no descent leaves. Random
 * displacements that grow from start to start find a configuration near the given one first. */
enum { MAX_STARTS = 24, MAX_STARTS_OF_SMALL_MISFIT = 6 };
static const double initial_displacement = 0.05, displacement_growth = 1.2; /* radians, or sizes of the substructure */
/* Largest deviation of the second-order change of a gap from the gap itself, relative to it: φ²/2 over 1 − cos φ is at
 * most 1.5 for a link that turns by 2.2 rad. */
static const double max_closing_deviation = 0.5;

typedef struct assembly {
  double *saved, *start, *best_outcome; /* saved coordinates of a substructure; workspace */
  int starts;                           /* starts that the last substructure needed */
  km_long_link violation;               /* link that proves that loop `violating_loop` cannot close */
  int violating_loop;                   /* -1: none */
} assembly;

/* Displaces every unlocked coordinate by `amplitude` times a random number, uniform in [−1, 1]. */
static void displace_randomly(const km_mechanism *m, km_state *s, const km_substructure *sub, double amplitude,
                              uint64_t *random) {
  for (int k = 0; k < sub->columns; ++k) {
    double share = km_uniform(random);
    s->work[k] = s->locked[m->column_coordinate[sub->column_start + k]] ? 0.0 : amplitude * share;
  }
  km_state_move(m, s, sub, s->work);
}

/* Number of starts: starts · rows · columns² (the cost of least-squares steps) is bounded, so that large substructures
 * take seconds. */
static int max_start_count(const km_substructure *sub) {
  double work = (double)sub->rows * sub->columns * sub->columns;
  return work * MAX_STARTS <= km_search_work ? MAX_STARTS : (int)(km_search_work / work);
}

/* Index of a loop that violates the polygon inequality; -1: none. */
static int find_violating_loop(const km_mechanism *m, const km_substructure *sub, km_long_link *link) {
  for (int i = 0; i < sub->loop_count; ++i)
    if (km_loop_violates_polygon(m, m->loop_order[sub->loop_start + i], link))
      return m->loop_order[sub->loop_start + i];
  return -1;
}

/* Second-order change of the gap e_s at the present configuration along a step d with J_p d = 0, relative to the gap:
 * −½ e_sᵀ (e_s''(d, d) + J_s x) / |e_s|² with J_p x = −e_p''(d, d), which keeps the primary rows closed. The gap closes
 * at the step 1 if it is 1. Velocity products are −e''. */
static double second_order_closing(const km_mechanism *m, km_state *s, int index, const double *step,
                                   km_arena *scratch) {
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
  double *rate = KM_ARENA_NEW(scratch, double, (size_t)m->coordinate_count);
  double *gamma = KM_ARENA_NEW(scratch, double, rows), *x = KM_ARENA_NEW(scratch, double, columns);
  double *J = KM_ARENA_NEW(scratch, double, rows *columns), closing = 0.0, square = 0.0;
  if (scratch->failed)
    return 0.0;
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    rate[c] = step[k] * m->unit[c];
  }
  km_loops_velocity_products(m, s, sub, rate, gamma);
  km_factor_solve(p, gamma, x);
  km_state_jacobian_dense(s, sub, J);
  for (int i = km_factor_rank(p); i < sub->rows; ++i) {
    size_t r = (size_t)km_factor_row_order(p)[i];
    double error = km_state_error(s, sub)[r], change = gamma[r];
    for (size_t k = 0; k < columns; ++k)
      change -= J[k * rows + r] * x[k];
    closing += 0.5 * error * change;
    square += error * error;
  }
  return square > 0.0 ? closing / square : 0.0;
}

/* True if the present, closed configuration is the one at which the gap of the stationary point `from` closes by second
 * order. Data whose rounding conceals a motion have no such curvature. The state is unchanged but for its pivots. */
static bool closes_from_stationary_point(const km_mechanism *m, km_state *s, int index, const double *from,
                                         double misfit, double *saved) {
  const km_substructure *sub = &m->substructures[index];
  km_arena scratch = {0};
  double *step = KM_ARENA_NEW(&scratch, double, (size_t)sub->columns), closing = 0.0;
  if (step) {
    km_state_difference(s, sub, from, step);
    km_state_save(s, sub, saved);
    km_state_restore(s, sub, from);
    km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, misfit);
    closing = second_order_closing(m, s, index, step, &scratch);
    km_state_restore(s, sub, saved);
    km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, 0.0);
  }
  km_arena_free(&scratch);
  return fabs(closing - 1.0) <= max_closing_deviation;
}

/* Closes one substructure by steps 1 to 3. If no start closes, or the polygon inequality is violated, the state is left
 * at the smallest residual. A small misfit counts as rounded data, unless a start closes where the second order of the
 * gap predicts it. */
static km_closure_outcome assemble_one(const km_mechanism *m, km_state *s, int index, assembly *a, km_closure *evidence,
                                       km_status *status, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  uint64_t random = 1;
  km_state_save(s, sub, a->start);
  km_closure_outcome best_outcome = close_from_here(m, s, index, a->saved, evidence, status, error);
  a->starts = 1;
  a->violating_loop = -1;
  if (best_outcome == KM_CLOSED || *status)
    return best_outcome;
  a->violating_loop = find_violating_loop(m, sub, &a->violation);
  bool is_small = best_outcome == KM_INCONSISTENT && evidence->residual < max_rounding_misfit;
  km_state_save(s, sub, a->best_outcome);
  if (is_small)
    memcpy(a->start, a->best_outcome, (size_t)(KM_SAVED_PER_COLUMN * sub->columns) * sizeof *a->start);
  int count = a->violating_loop >= 0 ? 0 : is_small ? MAX_STARTS_OF_SMALL_MISFIT : max_start_count(sub);
  double amplitude = is_small ? fmin(initial_displacement, sqrt(evidence->residual)) : initial_displacement;
  for (; a->starts <= count && !*status; amplitude *= displacement_growth) {
    km_closure found;
    km_state_restore(s, sub, a->start);
    displace_randomly(m, s, sub, amplitude, &random);
    km_closure_outcome outcome = relax_and_close(m, s, index, &found, status, error);
    if (*status)
      break;
    if (outcome == KM_CLOSED &&
        (!is_small || closes_from_stationary_point(m, s, index, a->start, evidence->residual, a->saved))) {
      *evidence = found;
      return outcome;
    }
    ++a->starts;
    if (!is_small && found.residual < evidence->residual) {
      best_outcome = outcome;
      *evidence = found;
      km_state_save(s, sub, a->best_outcome);
    }
  }
  km_state_restore(s, sub, a->best_outcome);
  km_loops_update(m, s, sub);
  return best_outcome;
}

/* Result of closing a substructure with another closure tolerance. */
typedef struct tolerance_trial {
  bool closes;
  int freedom, rank;
  double tolerance, misfit;
} tolerance_trial;

/* Compiles the model with a tolerance, closes the substructure and factors its Jacobian, as for a file with this
 * tolerance. */
static tolerance_trial try_tolerance(const km_mechanism *m, int index, double tolerance) {
  tolerance_trial result = {.tolerance = tolerance};
  km_mechanism *other = NULL;
  km_state *s = NULL;
  double *saved = KM_NEW(double, (size_t)(KM_SAVED_PER_COLUMN * m->largest_columns));
  km_compiling options = km_mechanism_options(m);
  options.closure_tolerance = tolerance;
  if (saved && !km_mechanism_compile_as(m->model, &options, &other, NULL) && !km_state_create(other, &s, NULL)) {
    km_closure evidence;
    km_status status = KM_OK;
    result.closes = close_from_here(other, s, index, saved, &evidence, &status, NULL) == KM_CLOSED;
    result.misfit = evidence.residual;
    km_update_and_search_pivots(other, s, index, KM_NO_DRIVER,
                                evidence.residual); /* the pivots of the closure may belong to another configuration */
    result.rank = km_factor_rank(s->factor[index]);
    result.freedom = km_factor_freedom(s->factor[index]);
  }
  km_state_free(s);
  km_mechanism_free(other);
  km_free(saved);
  return result;
}

/* Finds the smallest tolerance that closes and gives the same rank two values further up. That larger value is
 * returned, since the misfit can be larger in other configurations. False: none. */
static bool find_tolerance(const km_mechanism *m, int index, int least_mobility, tolerance_trial *out) {
  static const double tolerances[] = {1e-9, 2e-9, 5e-9, 1e-8, 2e-8, 5e-8, 1e-7, 2e-7, 5e-7, 1e-6,
                                      2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3};
  for (size_t i = 0; i + 2 < sizeof tolerances / sizeof *tolerances; ++i) {
    if (tolerances[i] <= m->closure_tolerance)
      continue;
    tolerance_trial tight = try_tolerance(m, index, tolerances[i]);
    *out = try_tolerance(m, index, tolerances[i + 2]);
    if (tight.closes && out->closes && tight.rank == out->rank && tight.freedom >= least_mobility)
      return true;
  }
  return false;
}

bool km_assemble_suggest(const km_mechanism *m, int index, int least_mobility, km_suggestion *out) {
  tolerance_trial suggested;
  if (!find_tolerance(m, index, least_mobility, &suggested))
    return false;
  *out = (km_suggestion){suggested.tolerance, suggested.misfit, suggested.freedom};
  return true;
}

/* Appends e.g. "connect: loop 1 (joints A, B, connect, D)". */
static void append_loop_name(const km_mechanism *m, int loop, km_text *text) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  km_text_format(text, "%s: loop %d (joints", model->joints[t->chord[loop]].where, loop + 1);
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i)
    km_text_format(text, "%s %.80s", i > t->member_start[loop] ? "," : "", model->joints[t->member[i].joint].label);
  km_text_add(text, ")");
}

/* Appends e.g. "a gap of 0.12 m is left at connect". */
static void append_gap(const km_mechanism *m, const km_state *s, int loop, km_text *text) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  const km_twist *e = &s->misfit[loop];
  double size = m->substructures[t->substructure_of_loop[loop]].size, gap = km_vec3_norm(e->v),
         turn = km_vec3_norm(e->w);
  bool gaps = gap > km_relative_zero * turn, turns = turn > km_relative_zero * gap;
  if (gaps)
    km_text_format(text, "a gap of %.4g %s", size * gap, model->units.length->suffix);
  if (turns)
    km_text_format(text, "%sa turn of %.4g %s", gaps ? " and " : "", turn / model->units.angle->si,
                   model->units.angle->suffix);
  km_text_format(text, " %s left at %.80s", gaps && turns ? "are" : "is", model->joints[t->chord[loop]].label);
}

static const char *joint_label(const km_model *model, int coordinate) {
  return model->joints[model->coordinates[coordinate].joint].label;
}

/* Appends the reason why a loop does not close: the link that is too long, or the remaining gap. */
static void describe_open_loop(const km_mechanism *m, const km_state *s, int loop, const assembly *a, km_text *text) {
  const km_model *model = m->model;
  const km_long_link *link = &a->violation;
  if (a->violating_loop >= 0) {
    append_loop_name(m, a->violating_loop, text);
    km_text_format(text,
                   ": the links can't meet: the one between %.80s and %.80s is %.4g %s longer than the others together",
                   joint_label(model, link->coordinates[0]), joint_label(model, link->coordinates[1]),
                   link->excess * m->substructures[m->topology.substructure_of_loop[a->violating_loop]].size,
                   model->units.length->suffix);
    return;
  }
  append_loop_name(m, loop, text);
  km_text_add(text, ": the links don't meet: ");
  append_gap(m, s, loop, text);
  if (a->starts > 1)
    km_text_format(text, ", the least of %d starting configurations", a->starts);
}

/* Fails with the open loop or coupling, and with a suggested closure tolerance if one closes. */
static km_status report_open(const km_mechanism *m, const km_state *s, int index, const assembly *a,
                             const km_closure *evidence, km_error *error) {
  km_text text = {0};
  if (evidence->worst >= 0)
    describe_open_loop(m, s, evidence->worst, a, &text);
  else
    km_text_format(&text, "a coupling of substructure %d can't be met: %.4g is left", index + 1, evidence->residual);
  tolerance_trial suggested;
  if (evidence->residual < max_rounding_misfit && find_tolerance(m, index, 0, &suggested))
    km_text_format(&text,
                   "; check lengths and starting angles, or for rounded data state \"closure_tolerance\": %g in "
                   "model_parameters, which gives mobility %d in substructure %d",
                   suggested.tolerance, suggested.freedom, index + 1);
  else
    km_text_add(&text, "; check lengths and starting angles");
  km_status status = km_fail(error, KM_MODEL, "%s", text.failed ? "out of memory" : text.data);
  km_text_free(&text);
  return status;
}

/* Residuals are relative to a size that includes the slides' start values. If these are far larger than the assembled
 * loop, the residual can be as large as the loop: then the start is refused. */
static km_status check_scale(const km_mechanism *m, const km_state *s, int index, const km_closure *evidence,
                             km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  double size = km_substructure_size(m, index, s->q);
  if (evidence->residual * sub->size <= fmax(m->closure_tolerance, 1e-9) * size)
    return KM_OK;
  const int *list = m->column_coordinate + sub->column_start;
  int farthest = list[0];
  for (int k = 0; k < sub->columns; ++k)
    if (km_model_coordinate_is_length(m->model, list[k]) &&
        (!km_model_coordinate_is_length(m->model, farthest) || fabs(m->start[list[k]]) > fabs(m->start[farthest])))
      farthest = list[k];
  return km_fail(
      error, KM_MODEL,
      "substructure %d starts with \"%.80s\" at %.4g and comes out %.4g large, so that rounding leaves it open; "
      "expected a start near the assembled pose",
      index + 1, m->model->coordinates[farthest].label,
      m->start[farthest] / km_model_coordinate_factor(m->model, farthest), size);
}

/* Assembles every substructure and collects the evidence: worst residual, most iterations. */
static km_status assemble_all(const km_mechanism *m, km_state *s, assembly *a, km_assembly *total, km_error *error) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_closure evidence;
    km_status status = KM_OK;
    km_closure_outcome outcome = assemble_one(m, s, i, a, &evidence, &status, error);
    if (status)
      return status;
    if (outcome != KM_CLOSED)
      return report_open(m, s, i, a, &evidence, error);
    status = check_scale(m, s, i, &evidence, error);
    if (status)
      return status;
    if (evidence.residual > total->residual) {
      total->residual = evidence.residual;
      total->worst_loop = evidence.worst;
    }
    if (evidence.iterations > total->iterations)
      total->iterations = evidence.iterations;
  }
  return KM_OK;
}

/* Closes all loops from the state's coordinates (docs/theory.md 4.3). */
km_status km_assemble(const km_mechanism *m, km_state *s, km_assembly *out, km_error *error) {
  if (out)
    *out = (km_assembly){.residual = nan(""), .worst_loop = -1};
  km_status fits = km_check_state(m, s, error);
  if (fits)
    return fits;
  km_assembly total = {.worst_loop = -1};
  size_t size = (size_t)(KM_SAVED_PER_COLUMN * m->largest_columns);
  km_arena scratch = {0};
  assembly a = {.saved = KM_ARENA_NEW(&scratch, double, size),
                .start = KM_ARENA_NEW(&scratch, double, size),
                .best_outcome = KM_ARENA_NEW(&scratch, double, size)};
  km_status status = scratch.failed ? km_fail(error, KM_MEMORY, "out of memory while assembling")
                                    : assemble_all(m, s, &a, &total, error);
  km_arena_free(&scratch);
  if (out)
    *out = total;
  return status;
}
