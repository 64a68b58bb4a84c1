/* Event location within a step: crossings of stated values, and corners of force laws that a step passed over
 * (docs/theory.md 11.6). */
#include "dynamics/simulation.h"

#include "base/event_locator.h"

#include <math.h>
#include <string.h>

/* Coordinate minus value. */
static double difference(const km_simulation *run, const double *y, int coordinate, double value) {
  int value_index = run->value_index[coordinate];
  return y[value_index] + run->shift[value_index] - value;
}

static double difference_at(km_simulation *run, double time, int coordinate, double value) {
  return km_simulation_interpolate(run, time, run->at) ? difference(run, run->at, coordinate, value) : nan("");
}

/* Function of crossing i minus its value, at a vector: of the coordinate, or the program's at that motion. */
static double crossing_difference(km_simulation *run, int i, const double *y, double time) {
  const km_crossing *crossing = &run->crossings[i];
  if (!crossing->function)
    return difference(run, y, crossing->coordinate, crossing->value);
  const km_dynamics *d = run->dynamics;
  km_simulation_locate_bodies(run, y, time);
  const km_motion_sample sample = km_user_sample(d->mechanism, run->state, d->forces);
  return crossing->function(crossing->context, &sample) - crossing->value;
}

/* A crossing as a function of time within the last step. */
typedef struct timed_crossing {
  km_simulation *run;
  int index;
} timed_crossing;

static double evaluate_crossing(double time, void *context) {
  const timed_crossing *q = context;
  return km_simulation_interpolate(q->run, time, q->run->at) ? crossing_difference(q->run, q->index, q->run->at, time)
                                                             : nan("");
}

/* sign · (coordinate − value) within the last step, as a function of time. */
typedef struct signed_difference {
  km_simulation *run;
  const km_corner *at;
  double sign;
} signed_difference;

static double evaluate_at(double time, void *context) {
  const signed_difference *q = context;
  return q->sign * difference_at(q->run, time, q->at->coordinate, q->at->value);
}

/* Time within the last step at which a coordinate is on the other side of the value than at both ends, by more than
 * `depth`. Infinity: none. */
static double find_excursion(km_simulation *run, const km_corner *at, double depth) {
  double one = difference(run, run->accepted, at->coordinate, at->value);
  double other = difference(run, run->y, at->coordinate, at->value);
  double sign = one > 0.0 || (one == 0.0 && other > 0.0) ? 1.0 : -1.0;
  signed_difference q = {run, at, sign};
  return km_locate_excursion(evaluate_at, &q, run->last_time, run->time, sign * one, sign * other, depth);
}

/* True if the coordinate can have passed the value and returned, judged by the rates at both ends of the step. */
static bool can_have_passed(const km_simulation *run, const km_corner *at) {
  int rate = run->rate_start + at->coordinate;
  double one = difference(run, run->accepted, at->coordinate, at->value);
  double other = difference(run, run->y, at->coordinate, at->value);
  double h = run->time - run->last_time;
  double distance = h * (fabs(run->accepted[rate] + run->shift[rate]) + fabs(run->y[rate] + run->shift[rate]));
  return one * other >= 0.0 && fmin(fabs(one), fabs(other)) <= distance + fabs(other - one);
}

/* Time at which the step passed over a corner and returned; infinity: it didn't. */
static double time_passed_over(km_simulation *run, int coordinate, double value) {
  if (!isfinite(value))
    return HUGE_VAL;
  const km_corner at = {coordinate, value, 0.0};
  double error = run->tolerance[run->value_index[coordinate]]; /* the coordinate isn't known more accurately */
  return can_have_passed(run, &at) ? find_excursion(run, &at, error) : HUGE_VAL;
}

/* Time at which a coordinate passes the first of two or more corners in the step, because a law between them may have
 * been evaluated nowhere; infinity: it passes at most one. */
static double time_of_two_corners(km_simulation *run, int c, double one, double other) {
  const km_corners *all = &run->corners;
  double error = run->tolerance[run->value_index[c]], first, second;
  if (other > one) {
    first = km_corners_above(all, c, one + error);
    second = km_corners_above(all, c, first);
  } else {
    first = km_corners_up_to(all, c, one - error);
    second = km_corners_up_to(all, c, nextafter(first, -HUGE_VAL));
  }
  if (!isfinite(second) || (other - second) * (second - first) <= 0.0)
    return HUGE_VAL;
  const km_corner at = {c, first, 0.0};
  signed_difference q = {run, &at, 1.0};
  return km_locate_root(evaluate_at, &q, run->last_time, run->time, one - first, other - first);
}

/* A coordinate that passes a corner and returns has passed the closest corner beyond both ends of the step. */
double km_simulation_passed_over(km_simulation *run) {
  const km_corners *all = &run->corners;
  double time = HUGE_VAL;
  for (int i = 0; i < all->count; ++i) {
    int c = all->corners[i].coordinate;
    if (c == KM_CORNER_TIME || (i > 0 && all->corners[i - 1].coordinate == c))
      continue;
    double one = difference(run, run->accepted, c, 0.0), other = difference(run, run->y, c, 0.0);
    double above = km_corners_above(all, c, nextafter(fmax(one, other), -HUGE_VAL));
    double below = km_corners_up_to(all, c, fmin(one, other));
    time = fmin(time, fmin(time_passed_over(run, c, above), time_passed_over(run, c, below)));
    time = fmin(time, time_of_two_corners(run, c, one, other));
  }
  return time;
}

void km_crossings_begin(km_simulation *run) {
  for (int i = 0; i < run->def.crossing_count; ++i) {
    const km_crossing *crossing = &run->crossings[i];
    double error = crossing->function ? 0.0 : run->tolerance[run->value_index[crossing->coordinate]];
    run->side[i] = crossing_difference(run, i, run->y, run->time);
    if (fabs(run->side[i]) <= error)
      run->side[i] = 0.0;
  }
  for (size_t k = run->reported; k > 0 && run->crossings_met[k - 1].time == run->time; --k)
    run->side[run->crossings_met[k - 1].crossing] = 0.0;
}

void km_crossings_report(km_simulation *run) {
  run->stop = HUGE_VAL;
  while (run->reported < run->crossings_met_count && run->crossings_met[run->reported].time <= run->stop) {
    const km_crossing_met *crossings_met = &run->crossings_met[run->reported++];
    if (run->crossings[crossings_met->crossing].stops)
      run->stop = crossings_met->time;
  }
}

/* Inserts a crossing among those of the last step, which begin at `first`, sorted by time. False: out of memory. */
static bool add(km_simulation *run, size_t first, km_crossing_met crossings_met) {
  if (!km_reserve((void **)&run->crossings_met, &run->crossings_met_capacity, run->crossings_met_count + 1,
                  sizeof *run->crossings_met))
    return false;
  size_t at = run->crossings_met_count++;
  for (; at > first && run->crossings_met[at - 1].time > crossings_met.time; --at)
    run->crossings_met[at] = run->crossings_met[at - 1];
  run->crossings_met[at] = crossings_met;
  return true;
}

/* Locates the passage of crossing i between two times, with the differences fa and fb there. */
static double locate(km_simulation *run, int i, double a, double fa, double b, double fb) {
  timed_crossing q = {run, i};
  return km_locate_root(evaluate_crossing, &q, a, b, fa, fb);
}

/* Adds both crossings of a coordinate that passes the value and returns within the step. */
static bool add_pair(km_simulation *run, size_t first, int i, double now) {
  const km_corner at = {run->crossings[i].coordinate, run->crossings[i].value, 0.0};
  double t = can_have_passed(run, &at) ? find_excursion(run, &at, 0.0) : HUGE_VAL;
  if (t == HUGE_VAL)
    return true;
  double f = difference_at(run, t, at.coordinate, at.value);
  double there = locate(run, i, run->last_time, run->side[i], t, f);
  double back = locate(run, i, t, f, run->time, now);
  int sense = now > 0.0 ? 1 : -1;
  return add(run, first, (km_crossing_met){i, there, -sense}) && add(run, first, (km_crossing_met){i, back, sense});
}

/* Finds all crossings of the last step: changes of sign, and a coordinate's passages there and back. */
bool km_crossings_find(km_simulation *run) {
  size_t first = run->crossings_met_count;
  bool is_ok = true;
  for (int i = 0; i < run->def.crossing_count && is_ok; ++i) {
    double now = crossing_difference(run, i, run->y, run->time);
    if (run->side[i] == 0.0) /* it began at the value and hadn't left it */
      run->side[i] = now;
    if (now == 0.0 || run->side[i] == now) /* not passed yet */
      continue;
    if ((now > 0.0) != (run->side[i] > 0.0)) {
      double time = locate(run, i, run->last_time, run->side[i], run->time, now);
      is_ok = add(run, first, (km_crossing_met){i, time, now > 0.0 ? 1 : -1});
    } else if (!run->crossings[i].function) {
      is_ok = add_pair(run, first, i, now);
    }
    run->side[i] = now;
  }
  km_crossings_report(run);
  return is_ok;
}
