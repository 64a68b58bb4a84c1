/* Motion of a driver on the circuit of a configuration (space/driver_circuit.h). */
#include "space/driver_circuit.h"

#include "base/event_locator.h"
#include "base/number/vectors.h"
#include "continuation/arc_motion.h"

#include <string.h>

static const double far_slide = 100.0;        /* displacement of a slide at infinity, sizes of the part */
static const double longest_circuit = 2000.0; /* arc length in one sense */
static const double same_place = 1e-6;        /* distance from the start of a motion that returned: radians, sizes */

km_status km_driver_circuit_create(km_driver_surface *f, int driver, km_arena *arena, km_driver_circuit *out,
                                   km_error *error) {
  km_status status = km_driver_surface_create(f, &driver, 1, arena, error);
  if (status)
    return status;
  if (f->part[0].substructure < 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" is in no loop; expected the driver of one",
                   f->m->model->coordinates[driver].label);
  *out = (km_driver_circuit){.f = f,
                             .rates = KM_ARENA_NEW(arena, double, (size_t)f->m->coordinate_count),
                             .place = KM_ARENA_NEW(arena, double, f->saved_size),
                             .now = KM_ARENA_NEW(arena, double, f->saved_size),
                             .sample = KM_ARENA_NEW(arena, double, f->saved_size),
                             .first_step = KM_ARENA_NEW(arena, double, (size_t)f->columns),
                             .starts = KM_ARENA_NEW(arena, double, KM_MOST_CIRCUIT_STARTS * f->saved_size)};
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory for the circuit of a driver") : KM_OK;
}

static int driver_of(const km_driver_circuit *g) {
  return km_driver_surface_coordinate(g->f, g->f->control[0]);
}

/* A motion whose driver's rate is sought along its arc. */
typedef struct sampled_motion {
  km_driver_circuit *g;
  km_arc_motion *motion;
} sampled_motion;

/* Rate of the driver at arc length s from the present configuration; NaN where it isn't reached. */
static double driver_rate(double s, void *context) {
  const sampled_motion *at = context;
  bool is_reached = km_arc_motion_sample(at->motion, s, at->g->rates);
  km_arc_motion_restore(at->motion);
  return is_reached ? at->g->rates[driver_of(at->g)] : nan("");
}

/* Moves to the dead point between the present configuration, where the driver's rate is `after`, and the one `length`
 * before it. False: it isn't reached, or within the part `beyond` of the way. */
static bool move_to_dead_point(km_driver_circuit *g, km_arc_motion *motion, double length, double before, double after,
                               double beyond) {
  sampled_motion at = {g, motion};
  double root = km_locate_root(driver_rate, &at, -length, 0.0, before, after);
  return root <= -beyond && km_arc_motion_sample(motion, root, g->rates);
}

static void note_start(km_driver_circuit *g, const double *saved) {
  if (g->start_count < KM_MOST_CIRCUIT_STARTS)
    memcpy(g->starts + (size_t)g->start_count++ * g->f->saved_size, saved, g->f->saved_size * sizeof *saved);
}

/* Notes the dead point of the last step. */
static void note_dead_point(km_driver_circuit *g, km_arc_motion *motion, double length, double before, double after,
                            double beyond, km_driver_swing *swing) {
  if (move_to_dead_point(g, motion, length, before, after, beyond)) {
    double q = g->f->s->q[driver_of(g)];
    km_driver_surface_save(g->f, g->sample);
    note_start(g, g->sample);
    swing->low = fmin(swing->low, q);
    swing->high = fmax(swing->high, q);
    ++swing->dead_points;
  }
  km_arc_motion_restore(motion);
}

/* True if a slide of the part is so far that the motion goes to infinity. */
static bool is_far(const km_driver_circuit *g) {
  const km_substructure *sub = &g->f->m->substructures[g->f->part[0].substructure];
  for (int k = 0; k < sub->columns; ++k) {
    int c = g->f->m->column_coordinate[sub->column_start + k];
    if (km_model_coordinate_is_length(g->f->m->model, c) && fabs(g->f->s->q[c]) > far_slide * sub->size)
      return true;
  }
  return false;
}

/* Step from the start to the state's configuration but for spins of rods, to g->f->step. Returns its length. */
static double difference_from_start(km_driver_circuit *g) {
  km_driver_surface_save(g->f, g->now);
  km_driver_surface_stop_spins(g->f);
  double distance = km_driver_surface_difference(g->f, g->place, g->f->step);
  km_driver_surface_restore(g->f, g->now);
  return distance;
}

/* Part of that step along the first one. */
static double along_first_step(const km_driver_circuit *g) {
  return km_dot(g->first_step, g->f->step, g->f->columns);
}

/* That part at arc length s from the present configuration; NaN where it isn't reached. */
static double along_at(double s, void *context) {
  const sampled_motion *at = context;
  bool is_reached = km_arc_motion_sample(at->motion, s, at->g->rates);
  double along = is_reached && difference_from_start(at->g) >= 0.0 ? along_first_step(at->g) : nan("");
  km_arc_motion_restore(at->motion);
  return along;
}

/* True if the last step of a motion with spinning rods, of this length, passed its start. *beyond: how far. `before`:
 * the part along the first step where the last one began; it is then that of its end. */
static bool has_returned(km_driver_circuit *g, km_arc_motion *motion, double step, double *before, double *beyond) {
  difference_from_start(g);
  double start = *before, after = along_first_step(g);
  *before = after;
  if (!(start < 0.0 && after >= 0.0))
    return false;
  sampled_motion at = {g, motion};
  double root = km_locate_root(along_at, &at, -step, 0.0, start, after);
  bool is_there = km_arc_motion_sample(motion, root, g->rates) && difference_from_start(g) <= same_place;
  km_arc_motion_restore(motion);
  *beyond = is_there ? -root : 0.0;
  return is_there;
}

/* Follows a motion until it closes or ends. *is_closed: it closed. */
static void follow_motion(km_driver_circuit *g, km_arc_motion *motion, km_driver_swing *swing, bool *is_closed) {
  int d = driver_of(g);
  double start = g->f->s->q[d], first = km_arc_motion_length(motion), last = first;
  km_arc_motion_tangent(motion, g->rates);
  double before = g->rates[d], earlier = before, along = 0.0;
  for (bool is_moving = true; is_moving && !*is_closed;) {
    km_driver_surface_save(g->f, g->sample);
    is_moving = !km_arc_motion_advance(motion, km_longest_arc_step) && !is_far(g) &&
                km_arc_motion_length(motion) < longest_circuit;
    km_arc_motion_tangent(motion, g->rates);
    double now = km_arc_motion_length(motion), after = g->rates[d], beyond = 0.0;
    if (g->f->rod_count > 0 && last == first) {
      difference_from_start(g);
      memcpy(g->first_step, g->f->step, (size_t)g->f->columns * sizeof *g->first_step);
    }
    *is_closed =
        km_arc_motion_closed(motion) || (g->f->rod_count > 0 && has_returned(g, motion, now - last, &along, &beyond));
    if (before * after < 0.0)
      note_dead_point(g, motion, now - last, before, after, beyond, swing);
    else if (fabs(before) < fabs(after) && fabs(before) <= fabs(earlier) && before * earlier > 0.0)
      note_start(g, g->sample);
    earlier = before;
    before = after;
    last = now;
  }
  double end = g->f->s->q[d];
  if (is_far(g) && fabs(end) > far_slide * g->f->size) /* the driver itself goes to infinity */
    end = copysign(HUGE_VAL, end);
  if (is_far(g) || !*is_closed) {
    swing->low = fmin(swing->low, end);
    swing->high = fmax(swing->high, end);
  }
  swing->turns = *is_closed && km_coordinate_turns(g->f->m, d) && fabs(end - start) > M_PI;
}

/* The hinge or slide of the part with the largest mobility number, the first one of those that are equal to rounding:
 * coordinates of ball joints may have that of a rod's spin. */
static int fastest_coordinate(const km_driver_circuit *g) {
  const km_driver_surface *f = g->f;
  km_mobility mobility;
  bool is_known = !km_mobility_compute(f->m, f->s, &mobility);
  int best = driver_of(g);
  for (int k = km_driver_surface_joints(f) - 1; k >= 0 && is_known; --k) {
    int c = km_driver_surface_coordinate(f, k);
    if (f->m->ball_of[c] < 0 && km_mobility_number(f->s, c) * 1.000001 > km_mobility_number(f->s, best))
      best = c;
  }
  return best;
}

km_status km_driver_circuit_follow(km_driver_circuit *g, km_driver_swing *swing, km_error *error) {
  bool is_closed = false;
  km_status status = KM_OK;
  *swing = (km_driver_swing){.low = HUGE_VAL, .high = -HUGE_VAL};
  g->start_count = 0;
  km_driver_surface_stop_spins(g->f);
  km_driver_surface_save(g->f, g->place);
  for (double sense = 1.0; !status && !is_closed && sense >= -1.0; sense -= 2.0) {
    km_arc_motion *motion = NULL;
    km_driver_surface_restore(g->f, g->place);
    km_state_invalidate_pivots(g->f->s, g->f->part[0].substructure);
    status = km_arc_motion_create(g->f->m, g->f->s, fastest_coordinate(g), sense, true, &motion, error);
    if (!status)
      follow_motion(g, motion, swing, &is_closed);
    km_arc_motion_free(motion);
  }
  km_driver_surface_restore(g->f, g->place);
  return status == KM_NO_RESULT ? KM_OK : status;
}
