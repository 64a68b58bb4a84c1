/* Closing all loops of a model from its initial displacements. */
#include "kinematics/assembly.h"
#include "base/random.h"
#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/polygon_inequality.h"
#include "kmech/mechanism.h"
#include "topology/compile.h"

#include <string.h>

/* From this misfit on (scaled rms), what is left is open geometry and not rounding. */
static const double rounding = 5e-3;

static km_closure_outcome close_fully(const km_mechanism *m, km_state *s, int index, km_closure *evidence) {
  return km_close_fully(km_loops_close, m, s, index, KM_NO_DRIVER, evidence);
}

/* Least squares from where the state is, then Newton's method. */
static km_closure_outcome relax_and_close(const km_mechanism *m, km_state *s, int index, km_closure *evidence,
                                          km_status *status, km_error *error) {
  *status = km_damped_least_squares(m, s, index, error);
  return *status ? KM_OPEN : close_fully(m, s, index, evidence);
}

/* Newton's method from where the state is, else damped least squares from there and Newton again. Equations that
 * contradict each other by rounding alone are left to the caller: least squares would wander off along the
 * motion that they hide. The other substructures' coordinates aren't touched. */
static km_closure_outcome close_from_here(const km_mechanism *m, km_state *s, int index, double *saved,
                                          km_closure *evidence, km_status *status, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  km_state_save(s, sub, saved);
  km_closure_outcome outcome = close_fully(m, s, index, evidence);
  if (outcome == KM_CLOSED || (outcome == KM_INCONSISTENT && evidence->residual < rounding))
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

/* A start with links on one line, or a symmetric one, is a stationary point of the gap |e|^2: no descent leaves it. So
 * further starts are tried, displaced at random, by amounts that grow: the first ones find a configuration near the
 * file's. */
enum { STARTS = 24, FEW_STARTS = 6 };
static const double least_displacement = 0.05, displacement_growth = 1.2; /* radians, or sizes of the substructure */

typedef struct assembly {
  double *saved, *start, *best; /* saved coordinates of a substructure; workspace */
  int starts;                   /* how many the last substructure has taken */
  km_long_link too_long;        /* shows that its loop `shown` can't close */
  int shown;                    /* -1: none */
} assembly;

/* Displaces every coordinate that is free to move by a random share of `most`. */
static void displace(const km_mechanism *m, km_state *s, const km_substructure *sub, double most, uint64_t *random) {
  for (int k = 0; k < sub->columns; ++k) {
    double share = km_uniform(random);
    s->work[k] = s->locked[m->column_coordinate[sub->column_start + k]] ? 0.0 : most * share;
  }
  km_state_move(m, s, sub, s->work);
}

/* Further starts of a large substructure would take minutes: their number times the cost of a least squares step is
 * bounded. */
static int start_count(const km_substructure *sub) {
  static const double most_work = 1e9; /* starts * rows * columns^2 */
  double work = (double)sub->rows * sub->columns * sub->columns;
  return work * STARTS <= most_work ? STARTS : (int)(most_work / work);
}

/* The loop that can't close, by its lengths; -1: none is known. */
static int find_too_long(const km_mechanism *m, const km_substructure *sub, km_long_link *link) {
  for (int i = 0; i < sub->loop_count; ++i)
    if (km_loop_violates_polygon(m, m->loop_order[sub->loop_start + i], link))
      return m->loop_order[sub->loop_start + i];
  return -1;
}

/* Largest scaled change of a coordinate since `saved`. */
static double distance_from(km_state *s, const km_substructure *sub, const double *saved) {
  double largest = 0.0;
  km_state_difference(s, sub, saved, s->work);
  for (int k = 0; k < sub->columns; ++k)
    largest = fmax(largest, fabs(s->work[k]));
  return largest;
}

/* Closes the substructure's loops from the state's configuration, else from others near it. Where none leads to a
 * closed configuration, or lengths show that there is none, the state is left at that with the least gap. A small gap
 * e is one of rounded data, unless the loops close at a distance of order sqrt(e), as they do beside a stationary
 * point. */
static km_closure_outcome assemble_one(const km_mechanism *m, km_state *s, int index, assembly *a, km_closure *evidence,
                                       km_status *status, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  uint64_t random = 1;
  km_state_save(s, sub, a->start);
  km_closure_outcome best = close_from_here(m, s, index, a->saved, evidence, status, error);
  a->starts = 1;
  a->shown = -1;
  if (best == KM_CLOSED || *status)
    return best;
  a->shown = find_too_long(m, sub, &a->too_long);
  bool is_small = best == KM_INCONSISTENT && evidence->residual < rounding;
  double reach = is_small ? 10.0 * sqrt(evidence->residual) : HUGE_VAL;
  km_state_save(s, sub, a->best);
  if (is_small)
    memcpy(a->start, a->best, (size_t)(KM_SAVED_PER_COLUMN * sub->columns) * sizeof *a->start);
  int count = a->shown >= 0 ? 0 : is_small ? FEW_STARTS : start_count(sub);
  for (double most = least_displacement; a->starts <= count && !*status; most *= displacement_growth) {
    km_closure found;
    km_state_restore(s, sub, a->start);
    displace(m, s, sub, most, &random);
    km_closure_outcome outcome = relax_and_close(m, s, index, &found, status, error);
    if (*status)
      break;
    if (outcome == KM_CLOSED && distance_from(s, sub, a->start) <= reach) {
      *evidence = found;
      return outcome;
    }
    ++a->starts;
    if (!is_small && found.residual < evidence->residual) {
      best = outcome;
      *evidence = found;
      km_state_save(s, sub, a->best);
    }
  }
  km_state_restore(s, sub, a->best);
  km_loops_update(m, s, sub);
  return best;
}

/* What a substructure would be with another tolerance. */
typedef struct trial {
  bool closes;
  int freedom, rank;
  double tolerance, misfit;
} trial;

/* Reads the displacements again, closes, and searches pivots: just what a file with this tolerance gets. */
static trial try_tolerance(const km_mechanism *m, int index, double tolerance) {
  trial result = {.tolerance = tolerance};
  km_mechanism *other = NULL;
  km_state *s = NULL;
  km_hold *holds = KM_NEW(km_hold, (size_t)m->coordinate_count);
  double *saved = KM_NEW(double, (size_t)(KM_SAVED_PER_COLUMN * m->largest_columns));
  int held = 0;
  for (int c = 0; holds && c < m->coordinate_count; ++c)
    if (m->held[c])
      holds[held++] = (km_hold){c, m->start[c] / km_model_coordinate_factor(m->model, c)};
  km_compiling how = {holds, held, tolerance, m->length, m->length_source};
  if (holds && saved && !km_mechanism_compile_as(m->model, &how, &other, NULL) && !km_state_create(other, &s, NULL)) {
    km_closure evidence;
    km_status status = KM_OK;
    result.closes = close_from_here(other, s, index, saved, &evidence, &status, NULL) == KM_CLOSED;
    result.misfit = evidence.residual;
    km_update_and_search_pivots(other, s, index, KM_NO_DRIVER,
                                evidence.residual); /* those of the closure may be of another pose */
    result.rank = s->partition[index].rank;
    result.freedom = km_partition_freedom(&s->partition[index]);
  }
  km_state_free(s);
  km_mechanism_free(other);
  km_free(saved);
  km_free(holds);
  return result;
}

/* The smallest tolerance of the 1-2-5 ladder that closes, with the same rank two rungs higher, which is the
 * one to name: the misfit of other poses may be larger than this one's. False: none. */
static bool fitting_tolerance(const km_mechanism *m, int index, int least_mobility, trial *out) {
  static const double ladder[] = {1e-9, 2e-9, 5e-9, 1e-8, 2e-8, 5e-8, 1e-7, 2e-7, 5e-7, 1e-6,
                                  2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3};
  for (size_t i = 0; i + 2 < sizeof ladder / sizeof *ladder; ++i) {
    if (ladder[i] <= m->closure_tolerance)
      continue;
    trial tight = try_tolerance(m, index, ladder[i]);
    *out = try_tolerance(m, index, ladder[i + 2]);
    if (tight.closes && out->closes && tight.rank == out->rank && tight.freedom >= least_mobility)
      return true;
  }
  return false;
}

bool km_assemble_suggest(const km_mechanism *m, int index, int least_mobility, km_suggestion *out) {
  trial named;
  if (!fitting_tolerance(m, index, least_mobility, &named))
    return false;
  *out = (km_suggestion){named.tolerance, named.misfit, named.freedom};
  return true;
}

/* Of a gap and a turn (scaled) the one below this share of the other isn't told. */
static const double unseen = 1e-9;

/* "connect: loop 1 (joints A, B, connect, D)". */
static void name_loop(const km_mechanism *m, int loop, km_text *text) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  km_text_format(text, "%s: loop %d (joints", model->joints[t->chord[loop]].where, loop + 1);
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i)
    km_text_format(text, "%s %.80s", i > t->member_start[loop] ? "," : "", model->joints[t->member[i].joint].label);
  km_text_add(text, ")");
}

/* "a gap of 0.12 m is left at connect". */
static void add_gap(const km_mechanism *m, const km_state *s, int loop, km_text *text) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  const km_twist *e = &s->misfit[loop];
  double size = m->substructures[t->substructure_of_loop[loop]].size, gap = km_vec3_norm(e->v),
         turn = km_vec3_norm(e->w);
  bool gaps = gap > unseen * turn, turns = turn > unseen * gap;
  if (gaps)
    km_text_format(text, "a gap of %.4g %s", size * gap, model->units.length->suffix);
  if (turns)
    km_text_format(text, "%sa turn of %.4g %s", gaps ? " and " : "", turn / model->units.angle->si,
                   model->units.angle->suffix);
  km_text_format(text, " %s left at %.80s", gaps && turns ? "are" : "is", model->joints[t->chord[loop]].label);
}

static const char *joint_of(const km_model *model, int coordinate) {
  return model->joints[model->coordinates[coordinate].joint].label;
}

static void describe_open_loop(const km_mechanism *m, const km_state *s, int loop, const assembly *a, km_text *text) {
  const km_model *model = m->model;
  const km_long_link *link = &a->too_long;
  if (a->shown >= 0) {
    name_loop(m, a->shown, text);
    km_text_format(
        text, ": the links can't meet: the one between %.80s and %.80s is %.4g %s longer than the others together",
        joint_of(model, link->coordinates[0]), joint_of(model, link->coordinates[1]),
        link->excess * m->substructures[m->topology.substructure_of_loop[a->shown]].size, model->units.length->suffix);
    return;
  }
  name_loop(m, loop, text);
  km_text_add(text, ": the links don't meet: ");
  add_gap(m, s, loop, text);
  if (a->starts > 1)
    km_text_format(text, ", the least of %d starting configurations", a->starts);
}

static km_status report_open(const km_mechanism *m, const km_state *s, int index, const assembly *a,
                             const km_closure *evidence, km_error *error) {
  km_text text = {0};
  if (evidence->worst >= 0)
    describe_open_loop(m, s, evidence->worst, a, &text);
  else
    km_text_format(&text, "a coupling of substructure %d can't be met: %.4g is left", index + 1, evidence->residual);
  trial named;
  if (evidence->residual < rounding && fitting_tolerance(m, index, 0, &named))
    km_text_format(&text,
                   "; check lengths and starting angles, or for rounded data state \"closure_tolerance\": %g in "
                   "model_parameters, which gives mobility %d in substructure %d",
                   named.tolerance, named.freedom, index + 1);
  else
    km_text_add(&text, "; check lengths and starting angles");
  km_status status = km_fail(error, KM_MODEL, "%s", text.failed ? "out of memory" : text.data);
  km_text_free(&text);
  return status;
}

/* Newton closes a loop in the scale of its slides' start. Where that is far larger than the loop that comes out, what
 * is left of the misfit may be all of the loop. */
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
                .best = KM_ARENA_NEW(&scratch, double, size)};
  km_status status = scratch.failed ? km_fail(error, KM_MEMORY, "out of memory while assembling")
                                    : assemble_all(m, s, &a, &total, error);
  km_arena_free(&scratch);
  if (out)
    *out = total;
  return status;
}
