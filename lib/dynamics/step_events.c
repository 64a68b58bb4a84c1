/* Event location within a step: crossings of stated values, and corners of force laws that a step passed over
 * (docs/theory.md 11.6). */
#include "dynamics/simulation.h"

#include "base/event_locator.h"

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
  km_dynamics *d = run->dynamics;
  km_simulation_unpack(run, y, time);
  km_tree_update(d, run->state);
  km_dynamics_locate_bodies(d);
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

/* Locates the passage of a coordinate through a value between two times, with the differences fa and fb there. */
static double locate(km_simulation *run, const km_corner *at, double a, double fa, double b, double fb) {
  signed_difference q = {run, at, 1.0};
  return km_locate_root(evaluate_at, &q, a, b, fa, fb);
}

/* Time within the last step at which a coordinate is on the other side of the value than at both ends, by more than
 * `depth`: eight samples, then the minimum. Infinity: none. */
static double find_excursion(km_simulation *run, const km_corner *at, double depth) {
  enum { PARTS = 8 };
  static const double width = 1e-8; /* relative: the minimum is known to the square of it */
  double h = (run->time - run->last_time) / PARTS, f[PARTS + 1];
  f[0] = difference(run, run->accepted, at->coordinate, at->value);
  f[PARTS] = difference(run, run->y, at->coordinate, at->value);
  double sign = f[0] > 0.0 || (f[0] == 0.0 && f[PARTS] > 0.0) ? 1.0 : -1.0;
  int least = 0;
  for (int k = 1; k < PARTS; ++k) {
    f[k] = difference_at(run, run->last_time + k * h, at->coordinate, at->value);
    if (sign * f[k] < -depth)
      return run->last_time + k * h;
    least = sign * f[k] < sign * f[least] ? k : least;
  }
  if (least == 0 || sign * f[PARTS] <= sign * f[least])
    return HUGE_VAL;
  signed_difference q = {run, at, sign};
  const double s = run->last_time + least * h;
  km_minimum_bracket b = {s - h, sign * f[least - 1], s, sign * f[least], s + h, sign * f[least + 1]};
  km_locate_minimum(evaluate_at, &q, width * h, -depth, &b);
  return b.f < -depth ? b.s : HUGE_VAL;
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
static double time_passed_over(km_simulation *run, int corner, int coordinate) {
  if (corner < 0 || corner >= run->corners.count || run->corners.corners[corner].coordinate != coordinate)
    return HUGE_VAL;
  const km_corner *at = &run->corners.corners[corner];
  double error = run->tolerance[run->value_index[coordinate]]; /* the coordinate isn't known more accurately */
  return can_have_passed(run, at) ? find_excursion(run, at, error) : HUGE_VAL;
}

/* A coordinate that passes a corner and returns has passed the closest corner beyond both ends of the step. */
double km_simulation_passed_over(km_simulation *run) {
  const km_corners *all = &run->corners;
  double first = HUGE_VAL;
  for (int i = 0; i < all->count; i = km_corners_above(all, all->corners[i].coordinate, HUGE_VAL)) {
    int c = all->corners[i].coordinate;
    double one = difference(run, run->accepted, c, 0.0), other = difference(run, run->y, c, 0.0);
    int above = km_corners_above(all, c, nextafter(fmax(one, other), -HUGE_VAL));
    int below = km_corners_above(all, c, fmin(one, other)) - 1;
    first = fmin(first, fmin(time_passed_over(run, above, c), time_passed_over(run, below, c)));
  }
  return first;
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

/* Adds both crossings of a coordinate that passes the value and returns within the step. */
static bool add_pair(km_simulation *run, size_t first, int crossing, const km_corner *at, double now) {
  double t = can_have_passed(run, at) ? find_excursion(run, at, 0.0) : HUGE_VAL;
  if (t == HUGE_VAL)
    return true;
  double f = difference_at(run, t, at->coordinate, at->value);
  double there = locate(run, at, run->last_time, run->side[crossing], t, f);
  double back = locate(run, at, t, f, run->time, now);
  int sense = now > 0.0 ? 1 : -1;
  return add(run, first, (km_crossing_met){crossing, there, -sense}) &&
         add(run, first, (km_crossing_met){crossing, back, sense});
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
      timed_crossing q = {run, i};
      double time = km_locate_root(evaluate_crossing, &q, run->last_time, run->time, run->side[i], now);
      is_ok = add(run, first, (km_crossing_met){i, time, now > 0.0 ? 1 : -1});
    } else if (!run->crossings[i].function) {
      const km_corner at = {run->crossings[i].coordinate, run->crossings[i].value};
      is_ok = add_pair(run, first, i, &at, now);
    }
    run->side[i] = now;
  }
  km_crossings_report(run);
  return is_ok;
}
