/* Following a motion by arc length: predictor, corrector, step control and limits. */
#include "kmech/follow.h"

#include "base/check.h"
#include "kinematics/branches.h"
#include "kinematics/closure.h"
#include "kinematics/curve.h"
#include "kinematics/follow.h"
#include "kinematics/loops.h"

#include <string.h>

/* Predictor-corrector on the configuration manifold of one substructure. Symbols: t tangent of unit length |D t|,
 * h a step of arc length, g = det(pivot block) / t_i of the pivots at hand (i the independent coordinate), which
 * passes through 0 at a branch point: up to a constant it is det of J bordered by t. */

static const double longest = 0.05;  /* of a step: the arc of the cubic between two poses errs by about h⁵/1000 */
static const double shortest = 1e-9; /* of a step: below, the motion ends */
static const double furthest_bend = 0.98; /* least cosine between the tangents of a step */
static const double singular = 1e-7;      /* last pivot, relative: closer to a singular pose the tangent is noise */
static const double narrow = 4e-3;        /* width to which a branch point is bracketed before it is interpolated */
static const double closing = 1e-9;       /* distance at which a cycle counts as closed */

static const km_substructure *sub_of(const km_follow *f) {
  return &f->mechanism->substructures[f->substructure];
}
static const double *weight_of(const km_follow *f) {
  return f->mechanism->column_weight + sub_of(f)->column_start;
}

static double weighted(const km_follow *f, const double *a, const double *b) {
  return km_step_dot(f->mechanism, sub_of(f), a, b);
}

/* The part of `t` that the loops allow, at unit length; false if hardly anything is left. */
static bool project(km_follow *f, const double *from, double *t) {
  const km_substructure *sub = sub_of(f);
  const km_partition *p = &f->state->partition[f->substructure];
  const double *weight = weight_of(f);
  int freedom = km_partition_freedom(p);
  const double *Z = km_state_null(f->mechanism, f->state, f->substructure, freedom);
  if (!Z)
    return false;
  memset(f->scratch, 0, (size_t)sub->columns * sizeof *f->scratch);
  for (int i = 0; i < freedom; ++i) {
    const double *z = Z + (size_t)i * (size_t)sub->columns;
    double dot = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      dot += z[k] * weight[k] * from[k];
    for (int k = 0; k < sub->columns; ++k)
      f->scratch[k] += dot * z[k];
  }
  double size = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    size += f->scratch[k] * f->scratch[k];
  size = sqrt(size);
  for (int k = 0; k < sub->columns; ++k)
    t[k] = f->scratch[k] / (size * weight[k]);
  return size > 1e-6;
}

/* Length of the cubic from one pose to the next, whose tangents t0, t1 are per unit length: the length that
 * reproduces itself; negative where the move runs against the tangents. Five-point Gauss-Legendre. */
double km_follow_arc(const km_follow *f, const double *move, const double *t0, const double *t1) {
  static const double node[5] = {0.5, 0.23076534494715845, 0.7692346550528415, 0.046910077030668, 0.953089922969332};
  static const double share[5] = {0.28444444444444444, 0.23931433524968324, 0.23931433524968324, 0.11846344252809454,
                                  0.11846344252809454};
  const double *weight = weight_of(f);
  double sign = weighted(f, move, t0) < 0.0 ? -1.0 : 1.0, length = sign * sqrt(weighted(f, move, move));
  for (int pass = 0; pass < 4; ++pass) {
    double sum = 0.0;
    for (int i = 0; i < 5; ++i) {
      double u = node[i], d01 = 6 * u * (1 - u), d10 = (1 - u) * (1 - 3 * u), d11 = u * (3 * u - 2), square = 0.0;
      for (int k = 0; k < sub_of(f)->columns; ++k) {
        double d = weight[k] * (d01 * move[k] + length * (d10 * t0[k] + d11 * t1[k]));
        square += d * d;
      }
      sum += share[i] * sqrt(square);
    }
    length = sign * sum;
  }
  return length;
}

/* The cubic through the last two poses and their tangents, continued by h; with freedoms that are left to the predictor
 * that would be unstable (its other root is -5), and Adams-Bashforth's second serves. Without a last pose, the tangent.
 */
static void predict(const km_follow *f, double h, double *move) {
  int columns = sub_of(f)->columns;
  bool known = f->last_h != 0.0 && fabs(h) <= 4.0 * fabs(f->last_h);
  if (known && f->freedom == 1) {
    km_curve_ahead(columns, f->last_h, f->last_move, f->last_t, f->t, h, move);
    return;
  }
  double slope = known ? 0.5 * h / f->last_h : 0.0;
  for (int k = 0; k < columns; ++k)
    move[k] = h * (f->t[k] + slope * (f->t[k] - f->last_t[k]));
}

/* From the saved pose by a step whose length is about h. On success the state stands there, f->next_t is its
 * tangent, f->move the way and *length its arc; else the state is back. */
static bool step(km_follow *f, double h, double *length) {
  const km_substructure *sub = sub_of(f);
  km_closure evidence;
  predict(f, h, f->move);
  km_state_restore(f->state, sub, f->here);
  km_state_move(f->mechanism, f->state, sub, f->move);
  bool accepted = false;
  if (km_loops_close(f->mechanism, f->state, f->substructure, KM_NO_DRIVER, &evidence) == KM_CLOSED &&
      evidence.correction <= 0.2 * fabs(h) + 1e-9 && project(f, f->t, f->next_t)) {
    const km_partition *p = &f->state->partition[f->substructure];
    bool regular = km_partition_freedom(p) == f->freedom && p->last_pivot >= singular * p->scale;
    bool smooth = weighted(f, f->t, f->next_t) >= furthest_bend;
    accepted = regular && smooth;
  }
  if (!accepted) {
    km_state_restore(f->state, sub, f->here);
    km_state_forget_pivots(f->state, f->substructure);
    return false;
  }
  km_state_difference(f->state, sub, f->here, f->move);
  *length = km_follow_arc(f, f->move, f->t, f->next_t);
  return true;
}

/* The secant method on the step. */
bool km_follow_step(km_follow *f, double length, double *reached) {
  double h = length;
  for (int i = 0; i < 8; ++i) {
    if (!step(f, h, reached))
      return false;
    if (fabs(*reached - length) <= 1e-14 + 1e-11 * fabs(length))
      return true;
    h *= length / *reached;
  }
  return true;
}

static void remember(km_follow *f) {
  km_state_save(f->state, sub_of(f), f->here);
  km_partition_copy_pivots(&f->reference, &f->state->partition[f->substructure]);
  f->g = f->freedom == 1 ? km_follow_g(f, f->t) : 0.0;
}

/* What the cycle has to come back to. */
static void set_origin(km_follow *f) {
  size_t columns = (size_t)sub_of(f)->columns;
  memcpy(f->origin_t, f->t, columns * sizeof *f->t);
  memcpy(f->origin, f->here, KM_SAVED_PER_COLUMN * columns * sizeof *f->here);
  f->origin_s = f->s;
  f->origin_waits = false;
}

static void accept(km_follow *f, double length) {
  double *spare = f->last_t;
  f->last_t = f->t;
  f->t = f->next_t;
  f->next_t = spare;
  memcpy(f->last_move, f->move, (size_t)sub_of(f)->columns * sizeof *f->move);
  f->last_h = length;
  f->s += length;
  remember(f);
  if (f->origin_waits)
    set_origin(f);
}

/* The way from the start pose to this one, full turns of hinges left out. */
static void from_start(km_follow *f, double *way) {
  km_state_difference(f->state, sub_of(f), f->origin, way);
  for (int k = 0; k < sub_of(f)->columns; ++k)
    if (km_coordinate_turns(f->mechanism, f->mechanism->column_coordinate[sub_of(f)->column_start + k]))
      way[k] -= 2.0 * M_PI * round(way[k] / (2.0 * M_PI));
}

/* Does the step just taken, `length` long, pass the start for the first time? */
static bool passes_start(km_follow *f, double length) {
  double *way = f->scratch;
  if (f->cycle > 0.0)
    return false;
  from_start(f, way);
  double after = weighted(f, f->origin_t, way);
  return f->s - f->origin_s + length > 2.0 * longest && after >= -1e-12 && after <= 1.5 * length &&
         weighted(f, f->origin_t, f->next_t) > 0.9 && weighted(f, way, way) < 4.0 * length * length;
}

/* Goes to where the start must be, by the secant method on the distance along its tangent; true if it is there. */
static bool meet_start(km_follow *f, double length) {
  double *way = f->scratch, reached = length;
  from_start(f, way);
  for (int i = 0; i < 12; ++i) {
    double along = weighted(f, f->origin_t, way);
    if (i > 0 && fabs(along) < 1e-14)
      break;
    if (reached - along <= 0.0 || !km_follow_step(f, reached - along, &reached))
      return false;
    from_start(f, way);
  }
  if (weighted(f, way, way) > closing * closing)
    return false;
  accept(f, reached);
  f->cycle = f->s - f->origin_s;
  f->closed = true;
  return true;
}

/* On the step of that length. */
static int limit_passed(const km_follow *f, double length) {
  if (f->ignore_limits)
    return -1;
  int passed = km_state_limit_passed(f->state, sub_of(f), f->here);
  return passed >= 0 ? passed : km_state_limit_touched(f->state, sub_of(f), f->here, f->t, f->next_t, length);
}

/* Goes as far as the limit of coordinate c allows, less than `length`. */
static void stop_at_limit(km_follow *f, int c, double length) {
  double inside = 0.0, outside = length, reached;
  f->limit = c;
  for (int i = 0; i < 60 && outside - inside > 1e-11; ++i) {
    double middle = 0.5 * (inside + outside);
    if (km_follow_step(f, middle, &reached) && limit_passed(f, middle) < 0)
      inside = middle;
    else
      outside = middle;
  }
  if (inside > 0.0 && km_follow_step(f, inside, &reached))
    accept(f, reached);
  else
    km_state_restore(f->state, sub_of(f), f->here);
}

/* One controlled step of at most `most`; false if the motion can't go on. */
static bool one_step(km_follow *f, double most) {
  double first = most / ceil(most / f->largest * (1.0 - 1e-9)); /* equal steps leave no crumb at the end */
  for (double h = first; h >= fmin(shortest, most); h *= 0.5) {
    double length;
    if (!(h == most ? km_follow_step(f, h, &length) : step(f, h, &length)) || length > most * (1.0 + 1e-9))
      continue;
    if (f->freedom == 1) {
      double g = km_follow_saved_g(f);
      if (g * f->g < 0.0 && length > narrow)
        continue;
      if (g * f->g < 0.0) {
        km_follow_locate_branch(f, length, g);
        if (!km_follow_step(f, length, &length))
          continue;
      }
    }
    if (passes_start(f, length)) {
      if (meet_start(f, length))
        return true;
      if (!km_follow_step(f, length, &length))
        continue;
    }
    int limit = limit_passed(f, length);
    if (limit >= 0) {
      stop_at_limit(f, limit, length);
      return false;
    }
    accept(f, length);
    f->largest = fmin(longest, h == first ? 2.0 * f->largest : h);
    return true;
  }
  return false;
}

km_status km_follow_advance(km_follow *f, double length) {
  if (!f || !isfinite(length) || !(length > 0.0))
    return KM_USAGE;
  double target = f->s + length;
  f->branched = false;
  while (!f->closed && !f->branched && target - f->s > 1e-10 * length)
    if (!one_step(f, target - f->s))
      return KM_PARTIAL;
  return KM_OK;
}

static bool allocate(km_follow *f, const km_substructure *sub) {
  size_t n = (size_t)sub->columns;
  double **vectors[] = {&f->t,      &f->next_t, &f->last_t,   &f->last_move, &f->move,
                        &f->near_t, &f->far_t,  &f->origin_t, &f->scratch,   &f->branch_t};
  double **poses[] = {&f->here, &f->near, &f->far, &f->origin, &f->branch_pose};
  for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
    *vectors[i] = KM_ARENA_NEW(&f->arena, double, n);
  for (size_t i = 0; i < sizeof poses / sizeof *poses; ++i)
    *poses[i] = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_partition_reserve_like(&f->reference, &f->state->partition[f->substructure], sub->rows, sub->columns,
                                   &f->arena);
}

/* The direction in which column k moves with `sign` and the others move least. */
static bool first_tangent(km_follow *f, int column, double sign) {
  memset(f->move, 0, (size_t)sub_of(f)->columns * sizeof *f->move);
  f->move[column] = sign;
  return project(f, f->move, f->t);
}

static int liveliest(const km_follow *f) {
  const km_mechanism *m = f->mechanism;
  int best = 0;
  for (int k = 1; k < sub_of(f)->columns; ++k)
    if (f->state->numbers[m->column_coordinate[sub_of(f)->column_start + k]] >
        1.000001 * f->state->numbers[m->column_coordinate[sub_of(f)->column_start + best]])
      best = k;
  return best;
}

/* The first substructure that moves, for a direction that names none. */
static int first_moving(const km_mechanism *m, km_state *s) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_loops_update(m, s, &m->substructures[i]);
    km_pivot(m, s, i, KM_NO_DRIVER, km_rank_tolerance(m, &m->substructures[i], 0.0));
    if (km_partition_freedom(&s->partition[i]) > 0)
      return i;
  }
  return -1;
}

static km_status start(km_follow *f, int coordinate, double sign, km_error *error) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = sub_of(f);
  if (!allocate(f, sub))
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  km_loops_update(m, f->state, sub);
  km_pivot(m, f->state, f->substructure, KM_NO_DRIVER, km_rank_tolerance(m, sub, 0.0));
  f->freedom = km_partition_freedom(&f->state->partition[f->substructure]);
  int column = coordinate >= 0 ? m->column_of[coordinate] : liveliest(f);
  if (f->freedom == 0 || !first_tangent(f, column, sign))
    return km_fail(error, KM_NO_RESULT, "nothing moves: %s",
                   f->freedom ? "the joint that should is at a toggle" : "the mechanism is a structure at this pose");
  remember(f);
  set_origin(f);
  return KM_OK;
}

/* At a branch point the null space mixes the motions that meet there. */
static km_status leave_branch(km_follow *f, km_error *error) {
  double *directions = KM_NEW(double, KM_MOST_BRANCHES *(size_t)sub_of(f)->columns);
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  f->start_branches = km_branch_directions(f->mechanism, f->state, f->substructure, directions);
  if (f->start_branches > 0)
    km_follow_set_out(f, directions, f->start_branches);
  km_free(directions);
  return f->start_branches < 0 ? km_fail(error, KM_MEMORY, "out of memory for the branch points") : KM_OK;
}

km_status km_follow_create(const km_mechanism *m, km_state *s, int coordinate, double sign, bool ignore_limits,
                           km_follow **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = coordinate == -1 ? KM_OK : km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  int substructure = coordinate >= 0 ? m->substructure_of[coordinate] : first_moving(m, s);
  if (coordinate >= 0 && (substructure < 0 || m->held[coordinate]))
    return km_fail(error, KM_USAGE, "joint \"%s\" is %s; expected a free joint of a loop",
                   m->model->coordinates[coordinate].label, m->held[coordinate] ? "held" : "in no loop");
  if (substructure < 0)
    return km_fail(error, KM_NO_RESULT, "nothing moves: the mechanism has no loop with a freedom at this pose");
  km_follow *f = KM_NEW(km_follow, 1);
  if (!f)
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  *f = (km_follow){.mechanism = m,
                   .state = s,
                   .substructure = substructure,
                   .largest = longest,
                   .ignore_limits = ignore_limits,
                   .limit = -1};
  km_status status = start(f, coordinate, sign < 0.0 ? -1.0 : 1.0, error);
  if (!status)
    status = leave_branch(f, error);
  if (status)
    km_follow_free(f);
  else
    *out = f;
  return status;
}

void km_follow_free(km_follow *f) {
  if (!f)
    return;
  km_arena_free(&f->arena);
  km_free(f);
}

int km_follow_start_branches(const km_follow *f) {
  if (!f)
    return 0;
  return f->start_branches;
}

int km_follow_substructure(const km_follow *f) {
  if (!f)
    return -1;
  return f->substructure;
}
double km_follow_length(const km_follow *f) {
  if (!f)
    return nan("");
  return f->s;
}
bool km_follow_closed(const km_follow *f) {
  if (!f)
    return false;
  return f->closed;
}

double km_follow_cycle(const km_follow *f) {
  if (!f)
    return 0.0;
  return f->cycle;
}

void km_follow_go_round(km_follow *f) {
  if (!f)
    return;
  f->closed = false;
}
int km_follow_limit(const km_follow *f) {
  if (!f)
    return -1;
  return f->limit;
}

static void write_rates(const km_follow *f, const double *t, double *rates) {
  const km_mechanism *m = f->mechanism;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  for (int k = 0; k < sub_of(f)->columns; ++k) {
    int c = m->column_coordinate[sub_of(f)->column_start + k];
    rates[c] = t[k] * m->unit[c];
  }
}

void km_follow_tangent(const km_follow *f, double *rates) {
  if (!f || !rates)
    return;
  write_rates(f, f->t, rates);
}

bool km_follow_visit(km_follow *f, double offset, double *rates) {
  if (!f || !rates || !isfinite(offset))
    return false;
  double reached;
  bool there = km_follow_step(f, offset, &reached);
  if (there)
    write_rates(f, f->next_t, rates);
  km_state_forget_pivots(f->state, f->substructure);
  return there;
}

void km_follow_return(km_follow *f) {
  if (!f)
    return;
  km_state_restore(f->state, sub_of(f), f->here);
  km_loops_update(f->mechanism, f->state, sub_of(f));
  km_state_forget_pivots(f->state, f->substructure);
}
