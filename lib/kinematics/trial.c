/* Tells tangents that a motion follows from those along which the loops only seem to close.
 *
 * Analytic equations that meet to order n along a curve leave a misfit C tⁿ⁺¹; a motion leaves none, however far it is
 * followed, and data rounded by ε leave about ε. So a tangent is followed a long way, the misfit is compared with what
 * the file may leave, and its growth from half the way to the whole tells a power of t from rounding. */
#include "kinematics/closure.h"
#include "kinematics/tangents.h"

static const double first_step = 1e-3;    /* scaled: radians or substructure sizes, of the fastest coordinate */
static const double longest_step = 0.05;  /* the same */
static const double shortest_step = 1e-6; /* the same */
static const double short_way = 4e-3;     /* the same: what ends before this never was one */
static const double whole_way = 0.3;      /* the same */
static const double noise = 1e-11;        /* a misfit that closing may leave */
static const double steep = 2.5;          /* a power that no rounding makes */
static const double rising = 1.5;         /* the same for a misfit above what the file may leave */

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
    while (half > 0 && r->way[half] > 0.5 * r->way[i])
      --half;
    if (half == 0 || r->worst[i] < noise || r->worst[i] < 1e3 * start)
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

/* Goes by `move`; false, and back again, if the loops' primary equations don't close nearby. */
static bool go(km_tangents *f, bool first, double *misfit) {
  km_closure evidence;
  int driver;
  fastest(f->move, f->sub->columns, &driver);
  km_state_save(f->s, f->sub, f->last);
  km_state_move(f->m, f->s, f->sub, f->move);
  double length = km_step_length(f->m, f->sub, f->move);
  bool closed = km_close_held(f->m, f->s, f->index, driver, &evidence) != KM_OPEN;
  *misfit = evidence.residual;
  if (closed && evidence.correction <= (first ? 0.05 : 0.3) * length)
    return true;
  km_state_restore(f->s, f->sub, f->last);
  return false;
}

static void scale_move(km_tangents *f, double factor) {
  for (int c = 0; c < f->sub->columns; ++c)
    f->move[c] *= factor;
}

static km_reality judge(const record *r, double start, double tolerance, bool whole) {
  double way = r->count ? r->way[r->count - 1] : 0.0, misfit = r->count ? r->worst[r->count - 1] : 0.0;
  if (way < short_way)
    return KM_UNREAL;
  double order = power(r, start);
  if (order >= steep || (misfit > tolerance && order >= rising))
    return KM_UNREAL;
  return whole && misfit <= tolerance ? KM_REAL : KM_UNDECIDED;
}

km_way km_tangents_follow(km_tangents *f, const double *a, double sign) {
  record r = {0};
  int column, columns = f->sub->columns;
  double start = f->residual, tolerance = f->m->closure_tolerance, h = first_step, misfit, way = 0.0, opened = HUGE_VAL;
  km_way result = {0};
  km_tangents_direction(f, a, f->x);
  double size = fastest(f->x, columns, &column);
  for (int c = 0; c < columns; ++c)
    f->move[c] = sign * h * f->x[c] / size;
  km_state_restore(f->s, f->sub, f->pose);
  /* Past the place where the loops open it goes on as far again, to see how. */
  while (way < fmin(whole_way, 2.0 * opened) && r.count < MOST_SAMPLES && h >= (way > 0.0 ? shortest_step : 1e-4)) {
    if (!go(f, way == 0.0, &misfit)) {
      scale_move(f, 0.5);
      h *= 0.5;
      continue;
    }
    km_state_difference(f->s, f->sub, f->last, f->move);
    double moved = fastest(f->move, columns, &column);
    way += moved;
    note(&r, way, misfit);
    if (misfit > tolerance)
      opened = fmin(opened, way);
    else if (opened == HUGE_VAL)
      result.length += km_step_length(f->m, f->sub, f->move);
    double next = fmin(1.5 * h, longest_step);
    scale_move(f, next / moved);
    h = next;
  }
  result.reality = judge(&r, start, tolerance, way >= whole_way);
  return result;
}
