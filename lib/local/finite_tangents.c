/* Tells tangents that a motion follows from those along which the loops only seem to close.
 *
 * Analytic equations that meet to order n along a curve leave a misfit C tⁿ⁺¹; a motion leaves none, however far it is
 * followed, and data rounded by ε leave about ε. So a tangent is followed a long way, the misfit is compared with what
 * the file may leave, and its growth from half the way to the whole tells a power of t from rounding. */
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/partition_stash.h"
#include "local/tangent_cone.h"

static const double first_step = 1e-3;    /* scaled: radians or substructure sizes, of the fastest coordinate */
static const double longest_step = 0.05;  /* the same */
static const double shortest_step = 1e-6; /* the same */
static const double short_way = 4e-3;     /* the same: what ends before this never was one */
static const double whole_way = 0.3;      /* the same */
static const double chord_way = 0.02;     /* the same: the way's chord up to there is kept */
static const double noise = 1e-11;        /* a misfit that closing may leave */
static const double rising = 1.5;         /* a power of the way, for a misfit far above what the file may leave */
static const double far_above = 100.0;    /* times what the file may leave */
static const double steep = 3.5;          /* a power that rounding doesn't make, for exact data */
static const double highest_power = 12.0; /* what rises more steeply has left the curve */
static const double grain = 30.0;         /* times the pose's misfit: less than that is no step */

enum { MOST_SAMPLES = 400 };

/* The misfit along the way: its largest value but one up to each place, since a single one may be a bad closure. */
typedef struct record {
  int count;
  double largest, way[MOST_SAMPLES], worst[MOST_SAMPLES];
} record;

static void note(record *r, double way, double misfit) {
  double last = r->count ? r->worst[r->count - 1] : 0.0;
  r->way[r->count] = way;
  r->worst[r->count++] = fmax(last, fmin(misfit, r->largest));
  r->largest = fmax(r->largest, misfit);
}

/* The steepest power of the way with which the misfit grew, from half of a place to the place, where it stands out. */
static double power(const record *r, double start) {
  double most = 0.0;
  for (int i = 1; i < r->count; ++i) {
    int half = i;
    while (half >= 0 && r->way[half] > 0.5 * r->way[i])
      --half;
    if (half < 0 || r->worst[i] < noise || r->worst[i] < 1e3 * start)
      continue;
    double before = fmax(r->worst[half], 1e-3 * noise);
    most = fmax(most, log(r->worst[i] / before) / log(r->way[i] / r->way[half]));
  }
  return most;
}

/* The column that moves most, and by how much. */
static double fastest(const double *move, int columns, int *column) {
  double most = 0.0;
  *column = 0;
  for (int k = 0; k < columns; ++k)
    if (fabs(move[k]) > most) {
      most = fabs(move[k]);
      *column = k;
    }
  return most;
}

/* The column that is held next: the fastest, but not another one without need, so that the pivots stay. */
static int choose_driver(const km_tangents *f, int driver) {
  int column;
  double most = fastest(f->move, f->sub->columns, &column);
  return driver >= 0 && fabs(f->move[driver]) > 0.3 * most ? driver : column;
}

/* How far the misfit of the pose can move it where other rows become the primary ones. */
static double slack(const km_tangents *f) {
  const km_partition *p = &f->s->partition[f->index];
  return p->rank ? 3.0 * f->residual * p->scale / p->smallest_pivot : 0.0;
}

/* Of many motions the rows are enough to go on. */
static bool rows_are_enough(const km_partition *p) {
  return p->sparse && km_partition_freedom(p) > KM_MAX_BASIS_FREEDOM;
}

/* From here on pivots tell rows alone where these are enough. `kept`: the primary rows at hand are tried before others. */
static void ask_for_rows(const km_tangents *f, bool kept) {
  km_partition *p = &f->s->partition[f->index];
  p->rows_only = rows_are_enough(p);
  p->kept_row_tolerance = kept && p->rows_only ? km_rank_tolerance(f->m, f->sub, 0.0) : 0.0;
}

static void ask_for_all(const km_tangents *f) {
  km_partition *p = &f->s->partition[f->index];
  p->rows_only = false;
  p->kept_row_tolerance = 0.0;
}

/* Do these pivots tell all that the next step asks for? Further on more rows may be independent, and fewer motions left: of rows that
 * are kept, closing asks that where it has found the pose. */
static bool pivots_may_stay(const km_partition *p) {
  return (km_partition_freedom(p) <= 1 && !p->rows_only) ||
         ((km_has_full_row_rank(p) || p->rows_only) && p->rows_only == rows_are_enough(p));
}

/* Goes by `move`, on from a misfit to the next one; false, and back again, if the loops' primary equations don't close
 * nearby. */
static bool go(km_tangents *f, int driver, double way, double *misfit) {
  km_closure evidence;
  int column;
  double moved = fastest(f->move, f->sub->columns, &column);
  double most = way > 0.0 ? 3.0 * fmax(*misfit, noise) * pow(1.0 + moved / way, highest_power) : HUGE_VAL;
  km_partition *p = &f->s->partition[f->index];
  ask_for_rows(f, way > 0.0); /* those of this way, not of what was asked before */
  km_state_save(f->s, f->sub, f->last);
  km_state_move(f->m, f->s, f->sub, f->move);
  double length = km_step_length(f->m, f->sub, f->move);
  bool closed = km_close_with_driver(f->m, f->s, f->index, driver, &evidence) != KM_OPEN;
  if (closed && evidence.residual <= most && evidence.correction <= (way > 0.0 ? 0.3 : 0.05) * length + slack(f)) {
    *misfit = evidence.residual;
    if (!pivots_may_stay(p))
      km_state_invalidate_pivots(f->s, f->index);
    return true;
  }
  km_state_restore(f->s, f->sub, f->last);
  return false;
}

static void scale_move(km_tangents *f, double factor) {
  for (int c = 0; c < f->sub->columns; ++c)
    f->move[c] *= factor;
}

/* The next move, of size h, from the last one: along the tangent where the held coordinate leaves just one, else on as
 * the last went. */
static void look_ahead(km_tangents *f, int driver, double h) {
  const km_partition *p = &f->s->partition[f->index];
  int column, n = f->sub->columns;
  double *t = f->x;
  if (km_partition_freedom(p) == 1 && p->column[p->rank] == driver && !p->rows_only) {
    km_partition_null_vector(p, driver, t);
    double sign = copysign(1.0, km_step_dot(f->m, f->sub, t, f->move)), size = fastest(t, n, &column);
    for (int c = 0; c < n && isfinite(size); ++c)
      f->move[c] = sign * t[c] / size;
  }
  scale_move(f, h / fastest(f->move, n, &column));
}

bool km_tangents_are_exact(const km_tangents *f) {
  return !f->m->closure_tolerance_given && f->residual < noise;
}

static km_tangent_verdict judge(const km_tangents *f, const record *r, double tolerance, bool whole) {
  double way = r->count ? r->way[r->count - 1] : 0.0, misfit = r->count ? r->worst[r->count - 1] : 0.0;
  bool exact = km_tangents_are_exact(f);
  if (way < short_way)
    return exact ? KM_TANGENT_REFUTED : KM_TANGENT_LOST;
  double order = power(r, f->residual);
  if ((misfit > far_above * tolerance && order >= rising) || (exact && order >= steep))
    return KM_TANGENT_REFUTED;
  return whole && misfit <= tolerance ? KM_TANGENT_CONFIRMED : KM_TANGENT_UNDECIDED;
}

km_followed_tangent km_tangents_follow(km_tangents *f, const double *direction, double sign) {
  record r = {0};
  int column, columns = f->sub->columns, driver = -1;
  double start = f->residual, tolerance = fmax(f->m->closure_tolerance, 3.0 * start);
  double first = fmin(fmax(first_step, grain * start), longest_step), h = first;
  double misfit = 0.0, way = 0.0, opened = HUGE_VAL; /* where the loops open */
  km_followed_tangent result = {0};
  double size = fastest(direction, columns, &column);
  for (int c = 0; c < columns; ++c)
    f->move[c] = sign * h * direction[c] / size;
  km_partition_stash(f->s, f->index);
  km_state_restore(f->s, f->sub, f->origin);
  km_state_invalidate_pivots(f->s, f->index);
  /* Past that place it goes on, to see how they open. */
  while (way < whole_way && !(way > 2.0 * opened && misfit > far_above * tolerance) && r.count < MOST_SAMPLES &&
         h >= (way > 0.0 ? shortest_step : 0.1 * first)) {
    driver = choose_driver(f, driver);
    if (!go(f, driver, way, &misfit)) {
      scale_move(f, 0.5);
      h *= 0.5;
      continue;
    }
    km_state_difference(f->s, f->sub, f->last, f->move);
    double moved = fastest(f->move, columns, &column);
    if (way < chord_way)
      km_state_difference(f->s, f->sub, f->origin, f->chord);
    way += moved;
    note(&r, way, misfit);
    if (misfit > tolerance)
      opened = fmin(opened, way);
    else if (opened == HUGE_VAL)
      result.length += km_step_length(f->m, f->sub, f->move);
    h = fmin(1.5 * h, longest_step);
    look_ahead(f, driver, h);
  }
  ask_for_all(f);
  km_partition_unstash(f->s, f->index);
  km_state_invalidate_pivots(f->s, f->index);
  result.verdict = judge(f, &r, tolerance, way >= whole_way);
  return result;
}

bool km_tangents_have_dropped(km_tangents *f) {
  int worst;
  km_partition_stash(f->s, f->index);
  km_loops_update(f->m, f->s, f->sub);
  double residual = km_loops_residual(f->m, f->s, f->sub, &worst);
  ask_for_rows(f, true);
  km_search_pivots(f->m, f->s, f->index, KM_NO_DRIVER, km_rank_tolerance(f->m, f->sub, residual));
  bool fewer = km_partition_freedom(&f->s->partition[f->index]) < f->conditions.freedom + f->conditions.passive_count;
  ask_for_all(f);
  km_partition_unstash(f->s, f->index);
  km_state_invalidate_pivots(f->s, f->index);
  return fewer;
}
