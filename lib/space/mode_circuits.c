/* Circuits of assembly modes (docs/theory.md 4.18).
 *
 *   c(s)      curve of the closed configurations with the locked coordinates free, s its arc length
 *   g(s)    = q_d(c(s)) − h, d the first locked coordinate, h its value; hinges modulo 2π
 *   crossing: root of g, from the cubic Hermite polynomial between two configurations, then Newton's method on s;
 *             the mode with the same poses of all bodies is met
 *   circuit : modes that are connected by curves, and by branch points on them
 *
 * A curve ends where it closes, or at infinity: a slide farther than FAR_SLIDE sizes. A curve that is not closed is
 * followed in both senses, and every other branch of each branch point is followed too. */
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/number/union_find.h"
#include "continuation/arc_motion.h"
#include "kinematics/body_poses.h"
#include "kinematics/modes/mode_identity.h"
#include "kinematics/modes/mode_normalisation.h"
#include "kmech/continuation.h"
#include "kmech/mobility.h"
#include "kmech/space.h"
#include "local/bifurcation.h"

#include <string.h>

enum {
  MOST_BRANCH_POINTS = 200, /* branch points of all curves */
  MOST_REFINEMENTS = 8      /* Newton steps to a crossing */
};
static const double share_of_modes = 0.8;      /* models/ spend 0.5 to 1 of the time on modes */
static const double far_slide = 100.0;         /* displacement of a slide at infinity, sizes of the substructure */
static const double longest_curve = 5000.0;    /* arc length of a curve in one sense */
static const double shortest_return = 0.1;     /* least arc length of a closed curve */
static const double least_mobility = 1e-9;     /* mobility number below which a coordinate is at a dead point */
static const double crossing_residual = 1e-11; /* |g| at a crossing: radians, sizes */

/* A mode's configuration. */
typedef struct mode_place {
  double *saved;  /* as km_state_save */
  km_pose *pose;  /* [body] */
  int mover;      /* coordinate that starts the motion: the locked one, unless it is at a dead point */
  bool is_passed; /* a curve has met the mode */
} mode_place;

/* A branch point. Its place in the union-find forest is behind the modes. */
typedef struct branch_point {
  double *saved; /* as km_state_save */
  km_pose *pose; /* [body] */
  double *directions;
  int count, next; /* directions; the next one to follow */
} branch_point;

typedef struct circuit_search {
  const km_mechanism *m;
  const km_all_modes *modes;
  km_state *s;
  int substructure, coordinate;
  double target, period; /* h; 2π for a hinge, else 0 */
  km_arena arena;
  km_body_placement *placements;
  mode_place *places; /* [mode] */
  int *parent;        /* [modes + MOST_BRANCH_POINTS] union-find forest */
  double *rates;      /* [coordinate] */
  branch_point *branches;
  int branch_count;
  bool lost;  /* a curve was not followed to its end */
  int passed; /* modes before the present one */
  km_progress progress;
  void *context;
} circuit_search;

/* State of a curve at a step's end. */
typedef struct curve_sample {
  double s, g, rate;
} curve_sample;

const char *km_circuit_gap_name(km_circuit_gap gap) {
  static const char *const names[] = {"none", "freedoms", "self-motion", "ball", "lost", "stopped"};
  return gap >= KM_CIRCUIT_GAP_NONE && gap <= KM_CIRCUIT_GAP_STOPPED ? names[gap] : "";
}

static const km_substructure *substructure_of(const circuit_search *f) {
  return &f->m->substructures[f->substructure];
}

/* ---- Connected nodes. */

static void connect(circuit_search *f, int a, int b) {
  f->parent[km_set_root(f->parent, a)] = km_set_root(f->parent, b);
}

/* ---- Crossings of the driver's value. */

static curve_sample sample(circuit_search *f, const km_arc_motion *motion) {
  km_arc_motion_tangent(motion, f->rates);
  return (curve_sample){km_arc_motion_length(motion), f->s->q[f->coordinate] - f->target, f->rates[f->coordinate]};
}

/* Cubic with values and slopes at 0 and 1. */
static double cubic(const curve_sample *a, const curve_sample *b, double u) {
  double h = b->s - a->s, v = 1.0 - u;
  return v * v * ((1.0 + 2.0 * u) * a->g + u * h * a->rate) + u * u * ((1.0 + 2.0 * v) * b->g - v * h * b->rate);
}

/* Sorts out the extrema of the cubic in (0, 1): ends of its monotonic parts, u[4]. Returns the number of parts. */
static int monotonic_parts(const curve_sample *a, const curve_sample *b, double *u) {
  double h = b->s - a->s, rise = b->g - a->g;
  double c = h * a->rate, q = 3.0 * rise - h * (2.0 * a->rate + b->rate), p = h * (a->rate + b->rate) - 2.0 * rise;
  double discriminant = q * q - 3.0 * p * c;
  int n = 0;
  u[n++] = 0.0;
  if (discriminant > 0.0) { /* c + 2 q u + 3 p u² = 0, without cancellation */
    double w = -(q + copysign(sqrt(discriminant), q)), first = w / (3.0 * p), second = c / w;
    double low = fmin(first, second), high = fmax(first, second);
    if (low > 0.0 && low < 1.0)
      u[n++] = low;
    if (high > 0.0 && high < 1.0)
      u[n++] = high;
  }
  u[n] = 1.0;
  return n;
}

/* Bisects the cubic minus `level` between u and v. */
static double bisect(const curve_sample *a, const curve_sample *b, double level, double u, double v) {
  bool is_positive = cubic(a, b, u) > level;
  for (int i = 0; i < 40; ++i) {
    double middle = 0.5 * (u + v);
    if ((cubic(a, b, middle) > level) == is_positive)
      u = middle;
    else
      v = middle;
  }
  return 0.5 * (u + v);
}

/* Moves the state from the curve's present configuration to g = level near arc length s. */
static bool refine(circuit_search *f, km_arc_motion *motion, double s, double level, double *rate) {
  double scale = f->period > 0.0 ? 1.0 : substructure_of(f)->size;
  for (int i = 0; i < MOST_REFINEMENTS; ++i) {
    if (!km_arc_motion_sample(motion, s - km_arc_motion_length(motion), f->rates))
      return false;
    double g = f->s->q[f->coordinate] - f->target - level;
    *rate = f->rates[f->coordinate];
    if (fabs(g) <= crossing_residual * scale)
      return true;
    km_arc_motion_restore(motion);
    s -= g / *rate;
  }
  return false;
}

/* Returns the mode with the state's poses; −1: none, such as one outside the limits. */
static int find_mode(circuit_search *f) {
  km_poses_compute(f->m, f->s);
  for (int i = 0; i < f->modes->count; ++i)
    if (km_is_same_mode(f->m, f->placements, f->places[i].pose, f->s->pose, substructure_of(f)->size, km_root_rounding))
      return i;
  return -1;
}

/* Connects `node` with the modes between two samples. True if the mode `start` is met again with the sense of
 * `start_rate`. */
static bool meet_modes(circuit_search *f, km_arc_motion *motion, const curve_sample *a, const curve_sample *b, int node,
                       double start_rate) {
  double ends[4];
  bool is_back = false;
  int parts = monotonic_parts(a, b, ends);
  for (int k = 0; k < parts; ++k) {
    double low = cubic(a, b, ends[k]), high = cubic(a, b, ends[k + 1]);
    int turn = f->period > 0.0 ? (int)ceil(fmin(low, high) / f->period) : 0;
    for (double level = turn * f->period; (low <= level) != (high <= level); level = ++turn * f->period) {
      double rate;
      double s = a->s + (b->s - a->s) * bisect(a, b, level, ends[k], ends[k + 1]);
      int mode = refine(f, motion, s, level, &rate) ? find_mode(f) : -1;
      km_arc_motion_restore(motion);
      if (mode >= 0) {
        connect(f, node, mode);
        f->places[mode].is_passed = true;
        is_back = is_back || (mode == node && rate * start_rate > 0.0 && s > shortest_return);
      }
      if (f->period == 0.0)
        break;
    }
  }
  return is_back;
}

/* ---- Branch points. */

/* Notes the state's configuration as a branch point on the curve of `node`. False when out of memory. */
static bool add_branch_point(circuit_search *f, int node) {
  const km_substructure *sub = substructure_of(f);
  size_t columns = (size_t)sub->columns, bodies = (size_t)f->m->model->body_count;
  int modes = f->modes->count;
  km_poses_compute(f->m, f->s);
  for (int i = 0; i < f->branch_count; ++i)
    if (km_is_same_mode(f->m, f->placements, f->branches[i].pose, f->s->pose, sub->size, km_root_rounding)) {
      connect(f, node, modes + i);
      return true;
    }
  f->lost = f->lost || f->branch_count == MOST_BRANCH_POINTS;
  if (f->branch_count == MOST_BRANCH_POINTS)
    return true;
  branch_point *point = &f->branches[f->branch_count];
  *point = (branch_point){.saved = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *columns),
                          .pose = KM_ARENA_NEW(&f->arena, km_pose, bodies),
                          .directions = KM_ARENA_NEW(&f->arena, double, KM_MAX_BRANCHES *columns)};
  if (f->arena.failed)
    return false;
  memcpy(point->pose, f->s->pose, bodies * sizeof *point->pose);
  km_state_save(f->s, sub, point->saved);
  point->count = km_branch_directions(f->m, f->s, f->substructure, point->directions);
  connect(f, node, modes + f->branch_count);
  ++f->branch_count;
  return point->count >= 0;
}

/* Notes the branch point that the last advance passed. */
static bool note_branch_point(circuit_search *f, km_arc_motion *motion, int node) {
  km_branch_point point;
  if (!km_arc_motion_branch(motion, &point))
    return true;
  km_arc_motion_move_to_branch_point(motion, f->s->work);
  bool is_ok = add_branch_point(f, node);
  km_arc_motion_restore(motion);
  return is_ok;
}

/* ---- Curves. */

/* True if a slide of the substructure is so far that the curve goes to infinity. */
static bool is_far(const circuit_search *f) {
  const km_substructure *sub = substructure_of(f);
  for (int k = 0; k < sub->columns; ++k) {
    int c = f->m->column_coordinate[sub->column_start + k];
    if (km_model_coordinate_is_length(f->m->model, c) && fabs(f->s->q[c]) > far_slide * sub->size)
      return true;
  }
  return false;
}

/* Follows a motion until its curve closes or ends. `*is_closed`: it returned to its start. */
static km_status follow(circuit_search *f, km_arc_motion *motion, int node, bool *is_closed, km_error *error) {
  curve_sample before = sample(f, motion);
  double start_rate = before.rate;
  *is_closed = false;
  while (!*is_closed) {
    km_status status = km_arc_motion_advance(motion, km_longest_arc_step);
    if (!note_branch_point(f, motion, node))
      return km_fail(error, KM_MEMORY, "out of memory for the circuits");
    curve_sample after = sample(f, motion);
    bool is_back = after.s > before.s && meet_modes(f, motion, &before, &after, node, start_rate);
    *is_closed = is_back || km_arc_motion_closed(motion);
    if (*is_closed || is_far(f))
      return KM_OK;
    f->lost = f->lost || status || after.s > longest_curve;
    if (status || after.s > longest_curve)
      return KM_OK;
    if (f->progress && !f->progress(f->context, (double)f->passed / f->modes->count))
      return km_fail(error, KM_CANCELLED, "stopped while the circuits were followed");
    before = after;
  }
  return KM_OK;
}

/* Follows the curve through the configuration `saved` that `coordinate` starts, or along a direction of a branch point;
 * in both senses unless it closes. */
static km_status follow_both(circuit_search *f, const double *saved, int coordinate, double *direction, int node,
                             km_error *error) {
  const km_substructure *sub = substructure_of(f);
  bool is_closed = false;
  km_status status = KM_OK;
  for (double sense = 1.0; !status && !is_closed && sense >= -1.0; sense -= 2.0) {
    km_arc_motion *motion;
    km_state_restore(f->s, sub, saved);
    km_state_invalidate_pivots(f->s, f->substructure);
    status = km_arc_motion_create(f->m, f->s, coordinate, sense, true, &motion, error);
    if (status == KM_NO_RESULT) {
      f->lost = true;
      return KM_OK;
    }
    if (!status && !direction && km_arc_motion_start_branches(motion) > 0 && !add_branch_point(f, node))
      status = km_fail(error, KM_MEMORY, "out of memory for the circuits");
    for (int k = 0; !status && direction && sense < 0.0 && k < sub->columns; ++k)
      direction[k] = -direction[k];
    if (!status && direction)
      km_arc_motion_start_branch(motion, direction, 1);
    if (!status)
      status = follow(f, motion, node, &is_closed, error);
    km_arc_motion_free(motion);
  }
  return status;
}

/* Returns the coordinate that moves most in a direction. */
static int fastest_coordinate(const circuit_search *f, const double *direction) {
  const km_substructure *sub = substructure_of(f);
  int best = 0;
  for (int k = 1; k < sub->columns; ++k)
    if (fabs(direction[k]) > fabs(direction[best]))
      best = k;
  return f->m->column_coordinate[sub->column_start + best];
}

/* Follows the branches of all branch points. */
static km_status follow_branches(circuit_search *f, km_error *error) {
  km_status status = KM_OK;
  size_t columns = (size_t)substructure_of(f)->columns;
  for (int i = 0; !status && i < f->branch_count; ++i)
    while (!status && f->branches[i].next < f->branches[i].count) {
      branch_point *point = &f->branches[i];
      double *direction = point->directions + columns * (size_t)point->next++;
      status = follow_both(f, point->saved, fastest_coordinate(f, direction), direction, f->modes->count + i, error);
    }
  return status;
}

static km_status follow_modes(circuit_search *f, km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; !status && i < f->modes->count; ++i)
    if (!f->places[i].is_passed) {
      f->passed = i;
      status = follow_both(f, f->places[i].saved, f->places[i].mover, NULL, i, error);
      f->places[i].is_passed = true;
      if (!status)
        status = follow_branches(f, error);
    }
  return status;
}

/* ---- The modes, and the result. */

/* Returns the locked coordinate, or at its dead point the one with the largest mobility number. */
static int choose_mover(const circuit_search *f) {
  const km_substructure *sub = substructure_of(f);
  if (f->coordinate >= 0 && km_mobility_number(f->s, f->coordinate) > least_mobility)
    return f->coordinate;
  int best = f->m->column_coordinate[sub->column_start];
  for (int k = 1; k < sub->columns; ++k) {
    int c = f->m->column_coordinate[sub->column_start + k];
    if (km_mobility_number(f->s, c) > km_mobility_number(f->s, best))
      best = c;
  }
  return best;
}

/* Moves the state to a mode and notes its place. */
static km_status load_mode(circuit_search *f, int i, km_error *error) {
  size_t bodies = (size_t)f->m->model->body_count;
  mode_place *place = &f->places[i];
  km_assembly evidence;
  km_mobility mobility;
  *place = (mode_place){
      .pose = KM_ARENA_NEW(&f->arena, km_pose, bodies),
      .saved = KM_ARENA_NEW(&f->arena, double, (size_t)(KM_SAVED_PER_COLUMN * substructure_of(f)->columns))};
  if (f->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the circuits");
  const double *coordinates = f->modes->coordinates + (size_t)i * (size_t)f->m->coordinate_count;
  km_status status = km_state_set_coordinates(f->m, f->s, coordinates, error);
  if (!status)
    status = km_assemble(f->m, f->s, &evidence, error);
  if (!status && km_mobility_compute(f->m, f->s, &mobility))
    status = km_fail(error, KM_MEMORY, "out of memory for the circuits");
  if (status)
    return status;
  km_poses_compute(f->m, f->s);
  memcpy(place->pose, f->s->pose, bodies * sizeof *place->pose);
  km_state_save(f->s, substructure_of(f), place->saved);
  place->mover = choose_mover(f);
  return KM_OK;
}

/* Notes the places of all modes; finds the least freedom of the bodies over them. */
static km_status load_modes(circuit_search *f, int *freedom, km_error *error) {
  size_t count = (size_t)f->modes->count;
  f->places = KM_ARENA_NEW(&f->arena, mode_place, count);
  f->parent = KM_ARENA_NEW(&f->arena, int, count + MOST_BRANCH_POINTS);
  f->rates = KM_ARENA_NEW(&f->arena, double, (size_t)f->m->coordinate_count);
  f->branches = KM_ARENA_NEW(&f->arena, branch_point, MOST_BRANCH_POINTS);
  f->placements = KM_ARENA_NEW(&f->arena, km_body_placement, (size_t)f->m->model->body_count);
  if (f->arena.failed || !km_body_placements(f->m, f->placements))
    return km_fail(error, KM_MEMORY, "out of memory for the circuits");
  km_sets_reset(f->parent, f->modes->count + MOST_BRANCH_POINTS);
  int least = substructure_of(f)->columns;
  km_status status = KM_OK;
  for (int i = 0; !status && i < f->modes->count; ++i) {
    status = load_mode(f, i, error);
    int own = km_factor_freedom(f->s->factor[f->substructure]);
    least = own < least ? own : least;
  }
  if (status)
    return status;
  km_passive_freedoms passive;
  status = km_passive_freedoms_find(f->m, f->s, NULL, NULL, &passive, error);
  for (int i = 0; !status && i < passive.count; ++i)
    if (passive.items[i].substructure == f->substructure)
      least -= passive.items[i].freedoms;
  km_passive_freedoms_free(&passive);
  *freedom = least;
  return status;
}

/* Numbers the circuits in the order of their first modes. */
static void number_circuits(circuit_search *f, km_mode_circuits *out) {
  for (int i = 0; i < f->modes->count; ++i) {
    for (int k = 0; k < i && out->circuit[i] == 0; ++k)
      if (km_set_root(f->parent, k) == km_set_root(f->parent, i))
        out->circuit[i] = out->circuit[k];
    if (out->circuit[i] == 0)
      out->circuit[i] = ++out->count;
  }
}

/* Returns the first locked coordinate that is no component of a ball joint; −1: none. */
static int choose_coordinate(const km_mechanism *m, const km_all_modes_def *def) {
  for (int i = 0; i < def->locked_count; ++i)
    if (m->ball_of[def->locked[i]] < 0)
      return def->locked[i];
  return -1;
}

static km_status find_circuits(circuit_search *f, km_mode_circuits *out, km_error *error) {
  int freedom = 0;
  km_status status = load_modes(f, &freedom, error);
  if (status)
    return status;
  out->freedom = freedom;
  out->gap = f->modes->gap == KM_GAP_MOVES       ? KM_CIRCUIT_GAP_SELF_MOTION
             : freedom > 1                       ? KM_CIRCUIT_GAP_FREEDOMS
             : freedom == 1 && f->coordinate < 0 ? KM_CIRCUIT_GAP_BALL
                                                 : KM_CIRCUIT_GAP_NONE;
  if (out->gap)
    return KM_OK;
  if (freedom == 1) {
    f->target = f->s->q[f->coordinate];
    f->period = km_coordinate_turns(f->m, f->coordinate) ? 2.0 * M_PI : 0.0;
    status = follow_modes(f, error);
  }
  if (!status)
    number_circuits(f, out);
  if (!status && f->lost)
    out->gap = KM_CIRCUIT_GAP_LOST;
  return status;
}

km_status km_mode_circuits_find(const km_mechanism *m, const km_state *s, const km_all_modes_def *def,
                                const km_all_modes *modes, km_progress progress, void *context, km_mode_circuits *out,
                                km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_mode_circuits){0};
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(def != NULL && modes != NULL, "definition and list of the modes", error);
  if (!status)
    status = km_check_list(def->locked, def->locked_count, "locked coordinates", error);
  for (int i = 0; !status && i < def->locked_count; ++i)
    status = km_check_index(def->locked[i], m->coordinate_count, "coordinate", error);
  if (!status && modes->count > 0)
    status = km_check_given(modes->coordinates != NULL, "coordinates of the modes", error);
  if (!status && modes->count > 0)
    status = km_check_index(modes->substructure, m->topology.substructure_count, "part of the mechanism", error);
  if (status || modes->count <= 0)
    return status;
  circuit_search f = {.m = m,
                      .modes = modes,
                      .substructure = modes->substructure,
                      .coordinate = choose_coordinate(m, def),
                      .progress = progress,
                      .context = context};
  out->circuit = KM_NEW(int, (size_t)modes->count);
  status = out->circuit ? km_state_create(m, &f.s, error) : km_fail(error, KM_MEMORY, "out of memory for the circuits");
  if (!status) {
    km_state_copy(m, f.s, s);
    km_state_unlock(f.s);
    status = find_circuits(&f, out, error);
  }
  if (status == KM_CANCELLED)
    out->gap = KM_CIRCUIT_GAP_STOPPED;
  km_arena_free(&f.arena);
  km_state_free(f.s);
  return status;
}

void km_mode_circuits_free(km_mode_circuits *circuits) {
  if (!circuits)
    return;
  km_free(circuits->circuit);
  *circuits = (km_mode_circuits){0};
}

km_status km_modes_and_circuits_find(const km_mechanism *m, const km_state *s, const km_all_modes_def *def,
                                     km_progress progress, void *context, km_all_modes *modes,
                                     km_mode_circuits *circuits, km_error *error) {
  if (!modes || !circuits)
    return km_check_given(false, "place for modes or circuits", error);
  *modes = (km_all_modes){0};
  *circuits = (km_mode_circuits){0};
  km_progress_stage stage = {.progress = progress, .context = context};
  km_progress_stage_next(&stage, share_of_modes);
  km_status status = km_all_modes_find(m, s, def, km_progress_stage_report, &stage, modes, error);
  km_progress_stage_next(&stage, 1.0);
  if (status == KM_CANCELLED)
    circuits->gap = KM_CIRCUIT_GAP_STOPPED;
  return status ? status : km_mode_circuits_find(m, s, def, modes, km_progress_stage_report, &stage, circuits, error);
}
