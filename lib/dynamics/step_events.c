/* Values that coordinates pass within a step: those that are asked for, and those at which forces change. */
#include "dynamics/simulation.h"

#include <string.h>

/* How far a coordinate is beyond a value. */
static double beyond(const km_simulation *run, const double *y, int coordinate, double value) {
  int place = run->place[coordinate];
  return y[place] + run->shift[place] - value;
}

static double beyond_at(km_simulation *run, double time, int coordinate, double value) {
  return km_simulation_between(run, time, run->at) ? beyond(run, run->at, coordinate, value) : nan("");
}

/* Where a coordinate passes the value between two times of the last step, at which it is `fa` and `fb` beyond it, by bisection
 * and secants in turn. */
static double locate(km_simulation *run, const km_corner *at, double a, double fa, double b, double fb) {
  for (int i = 0; i < 100 && b - a > 1e-15 * (fabs(a) + fabs(b)); ++i) {
    double t = i % 3 == 2 ? 0.5 * (a + b) : a - fa * (b - a) / (fb - fa);
    if (!(t > a && t < b))
      t = 0.5 * (a + b);
    double f = beyond_at(run, t, at->coordinate, at->value);
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

/* Golden sections towards the least of `sign` times the coordinate between two times: the first one found at which it is beyond the
 * value by more than `depth`. Infinity: it never is. */
static double deepest(km_simulation *run, const km_corner *at, double sign, double depth, double a, double b) {
  enum { SECTIONS = 40 };
  static const double golden = 0.38196601125010515;
  double t[2] = {a + golden * (b - a), b - golden * (b - a)}, f[2];
  for (int i = 0; i < 2; ++i)
    f[i] = sign * beyond_at(run, t[i], at->coordinate, at->value);
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
    f[less] = sign * beyond_at(run, t[less], at->coordinate, at->value);
  }
  return HUGE_VAL;
}

/* A time within the last step at which a coordinate is on the other side of the value than at both ends, by more than `depth`. */
static double excursion(km_simulation *run, const km_corner *at, double depth) {
  enum { PARTS = 8 };
  double h = (run->time - run->last_time) / PARTS, f[PARTS + 1];
  f[0] = beyond(run, run->good, at->coordinate, at->value);
  f[PARTS] = beyond(run, run->y, at->coordinate, at->value);
  double sign = f[0] > 0.0 || (f[0] == 0.0 && f[PARTS] > 0.0) ? 1.0 : -1.0;
  int least = 0;
  for (int k = 1; k < PARTS; ++k) {
    f[k] = beyond_at(run, run->last_time + k * h, at->coordinate, at->value);
    if (sign * f[k] < -depth)
      return run->last_time + k * h;
    least = sign * f[k] < sign * f[least] ? k : least;
  }
  if (least == 0 || sign * f[PARTS] <= sign * f[least])
    return HUGE_VAL;
  return deepest(run, at, sign, depth, run->last_time + (least - 1) * h, run->last_time + (least + 1) * h);
}

/* Can the coordinate have passed the value and come back? By the rates at both ends of the step. */
static bool may_have_passed(const km_simulation *run, const km_corner *at) {
  int rate = run->rate_start + at->coordinate;
  double one = beyond(run, run->good, at->coordinate, at->value);
  double other = beyond(run, run->y, at->coordinate, at->value);
  double h = run->time - run->last_time;
  double way = h * (fabs(run->good[rate] + run->shift[rate]) + fabs(run->y[rate] + run->shift[rate]));
  return one * other >= 0.0 && fmin(fabs(one), fabs(other)) <= way + fabs(other - one);
}

/* Of a corner that the coordinate has come back to the same side of. */
static double passed_over(km_simulation *run, int corner, int coordinate) {
  if (corner < 0 || corner >= run->corners.count || run->corners.corners[corner].coordinate != coordinate)
    return HUGE_VAL;
  const km_corner *at = &run->corners.corners[corner];
  double error = run->tolerance[run->place[coordinate]]; /* how deep it is isn't known any better */
  return may_have_passed(run, at) ? excursion(run, at, error) : HUGE_VAL;
}

/* Whatever passes a corner and comes back has passed the nearest one beyond both ends of the step, or at one of them. */
double km_simulation_passed_over(km_simulation *run) {
  const km_corners *all = &run->corners;
  double first = HUGE_VAL;
  for (int i = 0; i < all->count; i = km_corners_above(all, all->corners[i].coordinate, HUGE_VAL)) {
    int c = all->corners[i].coordinate;
    double one = beyond(run, run->good, c, 0.0), other = beyond(run, run->y, c, 0.0);
    int above = km_corners_above(all, c, nextafter(fmax(one, other), -HUGE_VAL));
    int below = km_corners_above(all, c, fmin(one, other)) - 1;
    first = fmin(first, fmin(passed_over(run, above, c), passed_over(run, below, c)));
  }
  return first;
}

void km_crossings_begin(km_simulation *run) {
  for (int i = 0; i < run->def.crossing_count; ++i)
    run->side[i] = beyond(run, run->y, run->crossings[i].coordinate, run->crossings[i].value);
}

void km_crossings_tell(km_simulation *run) {
  run->stop = HUGE_VAL;
  while (run->told < run->met_count && run->met[run->told].time <= run->stop) {
    const km_crossing_met *met = &run->met[run->told++];
    if (run->crossings[met->crossing].stops)
      run->stop = met->time;
  }
}

/* Among those of the last step, which begin at `first`, by time. False when out of memory. */
static bool add(km_simulation *run, size_t first, km_crossing_met met) {
  if (!km_reserve((void **)&run->met, &run->met_room, run->met_count + 1, sizeof *run->met))
    return false;
  size_t at = run->met_count++;
  for (; at > first && run->met[at - 1].time > met.time; --at)
    run->met[at] = run->met[at - 1];
  run->met[at] = met;
  return true;
}

/* Both, of a coordinate that comes back within the step. */
static bool add_pair(km_simulation *run, size_t first, int crossing, const km_corner *at, double now) {
  double t = may_have_passed(run, at) ? excursion(run, at, 0.0) : HUGE_VAL;
  if (t == HUGE_VAL)
    return true;
  double f = beyond_at(run, t, at->coordinate, at->value);
  double there = locate(run, at, run->last_time, run->side[crossing], t, f);
  double back = locate(run, at, t, f, run->time, now);
  int sense = now > 0.0 ? 1 : -1;
  return add(run, first, (km_crossing_met){crossing, there, -sense}) &&
         add(run, first, (km_crossing_met){crossing, back, sense});
}

bool km_crossings_find(km_simulation *run) {
  size_t first = run->met_count;
  bool whole = true;
  for (int i = 0; i < run->def.crossing_count && whole; ++i) {
    const km_corner at = {run->crossings[i].coordinate, run->crossings[i].value};
    double now = beyond(run, run->y, at.coordinate, at.value);
    if (run->side[i] == 0.0) /* it began there, and hadn't left */
      run->side[i] = now;
    if (now == 0.0 || run->side[i] == now) /* it hasn't passed yet */
      continue;
    if ((now > 0.0) == (run->side[i] > 0.0)) {
      whole = add_pair(run, first, i, &at, now);
    } else {
      double time = locate(run, &at, run->last_time, run->side[i], run->time, now);
      whole = add(run, first, (km_crossing_met){i, time, now > 0.0 ? 1 : -1});
    }
    run->side[i] = now;
  }
  km_crossings_tell(run);
  return whole;
}
