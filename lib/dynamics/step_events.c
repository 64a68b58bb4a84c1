/* Event location within a step: crossings of stated values, and corners of force laws that a step passed over
 * (docs/theory.md 11.6). */
#include "dynamics/simulation.h"

#include <string.h>

/* Coordinate minus value. */
static double difference(const km_simulation *run, const double *y, int coordinate, double value) {
  int value_index = run->value_index[coordinate];
  return y[value_index] + run->shift[value_index] - value;
}

static double difference_at(km_simulation *run, double time, int coordinate, double value) {
  return km_simulation_interpolate(run, time, run->at) ? difference(run, run->at, coordinate, value) : nan("");
}

/* Locates the passage of a coordinate through a value between two times, with the differences fa and fb there:
 * secants, every third step bisection. */
static double locate(km_simulation *run, const km_corner *at, double a, double fa, double b, double fb) {
  for (int i = 0; i < 100 && b - a > 1e-15 * (fabs(a) + fabs(b)); ++i) {
    double t = i % 3 == 2 ? 0.5 * (a + b) : a - fa * (b - a) / (fb - fa);
    if (!(t > a && t < b))
      t = 0.5 * (a + b);
    double f = difference_at(run, t, at->coordinate, at->value);
    if (isnan(f))
      break;
    if ((f > 0.0) == (fa > 0.0)) {
      a = t;
      fa = f;
    } else {
      b = t;
      fb = f;
    }
  }
  return b;
}

/* Golden-section search for the minimum of sign · coordinate between two times; returns the first time at which it
 * is beyond the value by more than `depth`. Infinity: none. */
static double golden_section(km_simulation *run, const km_corner *at, double sign, double depth, double a, double b) {
  enum { SECTIONS = 40 };
  static const double golden = 0.38196601125010515;
  double t[2] = {a + golden * (b - a), b - golden * (b - a)}, f[2];
  for (int i = 0; i < 2; ++i)
    f[i] = sign * difference_at(run, t[i], at->coordinate, at->value);
  for (int i = 0; i < SECTIONS; ++i) {
    int less = f[1] < f[0];
    if (f[less] < -depth)
      return t[less];
    if (less) {
      a = t[0];
      t[0] = t[1];
      f[0] = f[1];
    } else {
      b = t[1];
      t[1] = t[0];
      f[1] = f[0];
    }
    t[less] = less ? b - golden * (b - a) : a + golden * (b - a);
    f[less] = sign * difference_at(run, t[less], at->coordinate, at->value);
  }
  return HUGE_VAL;
}

/* Time within the last step at which a coordinate is on the other side of the value than at both ends, by more than
 * `depth`: eight samples, then golden sections. */
static double find_excursion(km_simulation *run, const km_corner *at, double depth) {
  enum { PARTS = 8 };
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
  return golden_section(run, at, sign, depth, run->last_time + (least - 1) * h, run->last_time + (least + 1) * h);
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
  for (int i = 0; i < run->def.crossing_count; ++i)
    run->side[i] = difference(run, run->y, run->crossings[i].coordinate, run->crossings[i].value);
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

/* Finds all crossings of the last step: changes of sign, and passages there and back. */
bool km_crossings_find(km_simulation *run) {
  size_t first = run->crossings_met_count;
  bool is_ok = true;
  for (int i = 0; i < run->def.crossing_count && is_ok; ++i) {
    const km_corner at = {run->crossings[i].coordinate, run->crossings[i].value};
    double now = difference(run, run->y, at.coordinate, at.value);
    if (run->side[i] == 0.0) /* it began at the value and hadn't left it */
      run->side[i] = now;
    if (now == 0.0 || run->side[i] == now) /* not passed yet */
      continue;
    if ((now > 0.0) == (run->side[i] > 0.0)) {
      is_ok = add_pair(run, first, i, &at, now);
    } else {
      double time = locate(run, &at, run->last_time, run->side[i], run->time, now);
      is_ok = add(run, first, (km_crossing_met){i, time, now > 0.0 ? 1 : -1});
    }
    run->side[i] = now;
  }
  km_crossings_report(run);
  return is_ok;
}
