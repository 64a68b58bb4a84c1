/* Zeros, poles and peaks of n/d by its values at many poses. */
#include "support/course.h"

#include "base/memory.h"

#include <math.h>

enum { MOST_EVENTS = 200 };

course course_make(int count, const km_sweep_plan *plan, const km_sweep *motion) {
  enum { POSES = 360 }; /* share of the whole range */
  static const double longest_arc = 0.02;
  double *data = KM_NEW(double, 3 * (size_t)count);
  bool by_length = plan->arclength > 0.0;
  double range = by_length ? plan->arclength * plan->steps : fabs(plan->to - plan->from), piece = range / POSES;
  return (course){.count = count,
                  .s = data,
                  .n = data + count,
                  .d = data + 2 * count,
                  .piece = by_length ? fmin(piece, longest_arc) : piece,
                  .by_root = motion->end.stop == KM_STOP_TOGGLE && !by_length};
}

void course_free(course *c) {
  km_free(c->s);
  *c = (course){0};
}

static double place(const km_sweep_plan *plan, const km_sweep *motion, int i, int count) {
  double part = (double)i / (count - 1), end = motion->end.position;
  if (plan->arclength > 0.0)
    return part * end;
  bool root = motion->end.stop == KM_STOP_TOGGLE;
  return plan->from + (end - plan->from) * (root ? 1.0 - (1.0 - part) * (1.0 - part) : part);
}

/* To arc length s, past the end of the cycle. */
static bool follow_to(km_arc_motion *follow, double s) {
  bool there = km_arc_motion_advance(follow, s - km_arc_motion_length(follow)) == KM_OK;
  if (!km_arc_motion_closed(follow))
    return there;
  km_arc_motion_continue_past_cycle(follow);
  return km_arc_motion_length(follow) >= s || km_arc_motion_advance(follow, s - km_arc_motion_length(follow)) == KM_OK;
}

bool course_walk(fixture *f, const km_sweep_plan *plan, const km_sweep *motion, int count, course_look look,
                 void *context) {
  km_driver_motion *drive = NULL;
  km_arc_motion *follow = NULL;
  km_mobility mobility;
  bool by_length = plan->arclength > 0.0, there = true;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  if (by_length ? km_arc_motion_create(f->mechanism, f->state, -1, 1.0, false, &follow, NULL)
                : km_driver_motion_create(f->mechanism, f->state, plan->coordinate, false, &drive, NULL))
    return false;
  for (int i = 0; i < count && there; ++i) {
    double s = place(plan, motion, i, count);
    if (by_length)
      there = i == 0 || follow_to(follow, s);
    else
      there = km_driver_motion_move_to(drive, s).stop == KM_STOP_NONE || i + 1 == count;
    look(context, f, i, s);
  }
  km_driver_motion_free(drive);
  km_arc_motion_free(follow);
  return there;
}

/* An end is located to 1e-9. So far from it the root of the way is known to half a percent; what happens nearer is a
 * matter of the end's own digits. */
static double own_digits(const course *c) {
  return 1e-7 * (1.0 + fabs(c->s[c->count - 1]));
}

/* The quotient of a to b at place i, and the root of the way from there to the end. */
static double quotient(const course *c, const double *a, const double *b, int i, double *root) {
  *root = sqrt(fabs(c->s[c->count - 1] - c->s[i]));
  return a[i] / b[i];
}

/* True if x changes its sign near the end. */
static bool turns_in_own_digits(const course *c, const double *x) {
  int last = c->count - 1;
  for (int i = last; i > 0 && fabs(c->s[last] - c->s[i]) < own_digits(c); --i)
    if (x[i] * x[i - 1] < 0.0)
      return true;
  return false;
}

/* The parabola through three values x at these roots of the way, at the end. */
static double by_parabola(const double root[3], const double x[3]) {
  double end = 0.0;
  for (int k = 0; k < 3; ++k) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    end += x[k] * root[i] * root[j] / ((root[k] - root[i]) * (root[k] - root[j]));
  }
  return end;
}

/* Extrapolation by x = c + b r^m, from places at doubling distances from the end; by the parabola if x doesn't
 * follow a power. A minimum-norm path approaches its end by its own powers. */
static double by_power(const double x[3], double otherwise) {
  double twice = x[1] / x[0], four = x[2] / x[1];
  return twice > 1.2 && four > 1.2 ? (x[0] * x[2] - x[1] * x[1]) / (x[0] + x[2] - 2.0 * x[1]) : otherwise;
}

/* Extrapolated a/b at the end, in distances between the two nearest of three samples, the first of them `stride`
 * places from the end. */
static double places_left(const course *c, const double *a, const double *b, int stride) {
  double x[3], root[3];
  for (int k = 0; k < 3; ++k)
    x[k] = quotient(c, a, b, c->count - 1 - stride * (1 << k), &root[k]);
  double end = by_parabola(root, x), power = by_power(x, end);
  return fmin(fabs(end), fabs(power)) / fabs(x[1] - x[0]);
}

/* True if a/b vanishes like the square root of the distance to the end. Less than a third of the samples' distance
 * counts as zero, unless samples within the end's rounding show a remainder. */
static course_end comes_to_nothing(const course *c, const double *a, const double *b) {
  int last = c->count - 1, stride = 1;
  if (turns_in_own_digits(c, a) || turns_in_own_digits(c, b))
    return COURSE_UNCLEAR;
  while (fabs(c->s[last] - c->s[last - stride]) < own_digits(c) && 4 * (stride + 1) <= last)
    ++stride;
  double left = places_left(c, a, b, stride);
  if (left >= 3.0)
    return COURSE_BOUNDED;
  return left < 0.3 && places_left(c, a, b, 1) < 3.0 ? COURSE_UNBOUNDED : COURSE_UNCLEAR;
}

course_end course_ends(const course *c) {
  return c->by_root ? comes_to_nothing(c, c->d, c->n) : COURSE_BOUNDED;
}

typedef struct expected {
  km_force_event_kind kind;
  double low, high;
  bool weak; /* optional: too flat for 360 samples over the range, next to another event, or within the end's
              * rounding */
  bool found;
} expected;

static double force(const course *c, int i) {
  return fabs(c->n[i] / c->d[i]);
}

void course_span(const course *c, int first, int last, double *low, double *high) {
  int before = first > 0 ? first : 1;
  double a = c->s[first], b = c->s[last];
  if (c->differences && last > first) {
    a -= 0.5 * (c->s[before] - c->s[before - 1]);
    b += c->by_root && last == c->count - 1 ? 0.0 : 0.5 * (c->s[last] - c->s[last - 1]);
  }
  *low = fmin(a, b);
  *high = fmax(a, b);
}

/* Events beyond MOST_EVENTS are determined by rounding and aren't required. */
static void expect(expected *list, int *count, km_force_event_kind kind, const course *c, int first, int last,
                   bool weak) {
  expected e = {.kind = kind, .weak = weak};
  course_span(c, first, last, &e.low, &e.high);
  if (*count < MOST_EVENTS)
    list[(*count)++] = e;
}

static bool turns(const double *x, int i) {
  return x[i] * x[i + 1] < 0.0;
}

/* Peaks between samples i−1 and i+1 that no pole parts. Where n vanishes with d the force goes on as it was, and may
 * peak there. */
static bool peaks(const course *c, int i) {
  bool pole = (turns(c->d, i - 1) && !turns(c->n, i - 1)) || (turns(c->d, i) && !turns(c->n, i));
  return !pole && force(c, i) > force(c, i - 1) && force(c, i) > force(c, i + 1);
}

/* A peak so close to a zero that the sample after the zero is larger than the peak. */
static bool peaks_beside_zero(const course *c, int i) {
  bool before = turns(c->n, i - 1), behind = turns(c->n, i), pole = turns(c->d, i - 1) || turns(c->d, i);
  return !pole && ((before && force(c, i) > force(c, i + 1)) || (behind && force(c, i) > force(c, i - 1)));
}

/* True if, within two samples of the sweep on a side, |f| falls by less than 1e-4 of itself, or exceeds the peak
 * again. */
static bool is_weak(const course *c, int i) {
  double peak = force(c, i);
  for (int side = -1; side <= 1; side += 2) {
    bool falls = false, rises = false;
    for (int k = i; k >= 0 && k < c->count && fabs(c->s[k] - c->s[i]) <= 2.0 * c->piece; k += side) {
      falls = falls || force(c, k) < (1.0 - 1e-4) * peak;
      rises = rises || force(c, k) > peak;
    }
    if (!falls || rises)
      return true;
  }
  return false;
}

/* Next to a dead point of the driver at the end. */
static bool is_by_own_digits(const course *c, double s) {
  return c->by_root && fabs(s - c->s[c->count - 1]) < own_digits(c);
}

/* True if x at places i−1 … i+1 is so small that rounding decides its sign. */
static bool is_rounding(const double *x, double largest, int i) {
  static const double rounding = 1e-10;
  return fabs(x[i]) < rounding * largest || fabs(x[i + 1]) < rounding * largest ||
         (i > 0 && fabs(x[i - 1]) < rounding * largest);
}

static double largest_of(const double *x, int count) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i)
    largest = fmax(largest, fabs(x[i]));
  return largest;
}

static int list_of(const course *c, course_end end, expected *list) {
  int count = 0;
  double n = largest_of(c->n, c->count), d = largest_of(c->d, c->count);
  for (int i = 0; i + 1 < c->count; ++i) {
    bool zero = turns(c->n, i), pole = turns(c->d, i), rounding = is_rounding(c->n, n, i) || is_rounding(c->d, d, i);
    /* Both in one place, and the force goes on as it was; or the one beside the other. */
    if (zero)
      expect(list, &count, KM_FORCE_BALANCED, c, i, i + 1, rounding || pole);
    if (pole)
      expect(list, &count, KM_FORCE_UNBOUNDED, c, i, i + 1, rounding || zero);
    if (i > 0 && peaks(c, i))
      expect(list, &count, KM_FORCE_PEAK, c, i - 1, i + 1, rounding || turns(c->d, i - 1) || pole || is_weak(c, i));
    else if (i > 0 && peaks_beside_zero(c, i))
      expect(list, &count, KM_FORCE_PEAK, c, i - 1, i + 1, true);
  }
  for (int i = 0; i < count; ++i)
    list[i].weak = list[i].weak || is_by_own_digits(c, list[i].low) || is_by_own_digits(c, list[i].high);
  if (end != COURSE_BOUNDED)
    expect(list, &count, KM_FORCE_UNBOUNDED, c, c->count - 1, c->count - 1, end == COURSE_UNCLEAR);
  return count;
}

static const char *word(km_force_event_kind kind) {
  return kind == KM_FORCE_BALANCED ? "zero" : kind == KM_FORCE_PEAK ? "peak" : "pole";
}

/* Marks the matching event, preferably a required one. */
static bool find(expected *list, int count, const km_force_event *event, double slack) {
  int best = -1;
  for (int i = 0; i < count; ++i) {
    bool here = event->s >= list[i].low - slack && event->s <= list[i].high + slack;
    if (!list[i].found && event->kind == list[i].kind && here && (best < 0 || (list[best].weak && !list[i].weak)))
      best = i;
  }
  if (best >= 0)
    list[best].found = true;
  return best >= 0;
}

/* True if d is rounding in the sample before or after s, so that its sign, and a pole, are undetermined. */
static bool is_in_rounding(const course *c, double s) {
  double largest = largest_of(c->d, c->count);
  for (int i = 0; i + 1 < c->count; ++i)
    if ((c->s[i] - s) * (c->s[i + 1] - s) <= 0.0)
      return is_rounding(c->d, largest, i);
  return false;
}

/* True if the reference is undetermined: differences begin half a place after the start; peaks begin a whole one
 * later, and end a whole one before the end. */
static bool is_out_of_sight(const course *c, const km_force_event *event) {
  int last = c->count - 1;
  double along = c->s[last] > c->s[0] ? 1.0 : -1.0, s = along * event->s;
  return is_by_own_digits(c, event->s) || is_in_rounding(c, event->s) || s < along * c->s[1] ||
         s > along * c->s[last] || (event->kind == KM_FORCE_PEAK && s > along * c->s[last - 1]);
}

bool course_agrees(const course *c, const km_statics_sweep *sweep, int actuator, double slack, family_count *count) {
  expected list[MOST_EVENTS];
  course_end end = course_ends(c);
  int expects = list_of(c, end, list);
  bool right = true;
  slack *= 1.0 + fabs(c->s[c->count - 1] - c->s[0]);
  for (size_t e = 0; e < sweep->event_count; ++e) {
    const km_force_event *event = &sweep->events[e];
    bool known = event->actuator != actuator || find(list, expects, event, slack) || is_out_of_sight(c, event);
    known = known || (event->kind == KM_FORCE_BALANCED && fabs(event->s - c->s[c->count - 1]) < slack &&
                      comes_to_nothing(c, c->n, c->d) != COURSE_BOUNDED);
    if (!known)
      print_error("  actuator %d: a %s is told at %.12g\n", actuator, word(event->kind), event->s);
    right = right && known;
  }
  for (int i = 0; i < expects; ++i) {
    if (!list[i].found && !list[i].weak)
      print_error("  actuator %d: no %s is told between %.12g and %.12g\n", actuator, word(list[i].kind), list[i].low,
                  list[i].high);
    right = right && (list[i].found || list[i].weak);
    count->zeros += list[i].kind == KM_FORCE_BALANCED;
    count->poles += list[i].kind == KM_FORCE_UNBOUNDED;
    count->peaks += list[i].kind == KM_FORCE_PEAK;
  }
  count->ends += end == COURSE_UNBOUNDED;
  return right;
}
