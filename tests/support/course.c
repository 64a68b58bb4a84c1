/* Zeros, poles and peaks of n/d by its values at many poses. */
#include "support/course.h"

#include "base/memory.h"

#include <math.h>

enum { MOST_EVENTS = 200 };

course course_make(int count) {
  double *data = KM_NEW(double, 3 * (size_t)count);
  return (course){count, data, data + count, data + 2 * count};
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
static bool follow_to(km_follow *follow, double s) {
  bool there = km_follow_advance(follow, s - km_follow_length(follow)) == KM_OK;
  if (!km_follow_closed(follow))
    return there;
  km_follow_go_round(follow);
  return km_follow_length(follow) >= s || km_follow_advance(follow, s - km_follow_length(follow)) == KM_OK;
}

bool course_walk(fixture *f, const km_sweep_plan *plan, const km_sweep *motion, int count, course_look look,
                 void *context) {
  km_drive *drive = NULL;
  km_follow *follow = NULL;
  km_mobility mobility;
  bool by_length = plan->arclength > 0.0, there = true;
  km_mobility_update(f->mechanism, f->state, &mobility);
  if (by_length ? km_follow_create(f->mechanism, f->state, -1, 1.0, false, &follow, NULL)
                : km_drive_create(f->mechanism, f->state, plan->coordinate, false, &drive, NULL))
    return false;
  for (int i = 0; i < count && there; ++i) {
    double s = place(plan, motion, i, count);
    if (by_length)
      there = i == 0 || follow_to(follow, s);
    else
      there = km_drive_to(drive, s).stop == KM_STOP_NONE || i + 1 == count;
    look(context, f, i, s);
  }
  km_drive_free(drive);
  km_follow_free(follow);
  return there;
}

/* x goes with the root of the way to the end: on by the parabola through three differences, which stand one and a half, two and a
 * half and three and a half places before it. The last one has the digits to which the end was located. */
static bool comes_to_nothing(const double *x, int count) {
  x += count - 4;
  double end = 4.375 * x[2] - 5.25 * x[1] + 1.875 * x[0];
  return fabs(end) < 0.6 * fabs(x[2] - x[1]);
}

bool course_gives_out(const course *c) {
  return comes_to_nothing(c->d, c->count) && !comes_to_nothing(c->n, c->count);
}

typedef struct expected {
  km_force_event_kind kind;
  double low, high;
  bool weak; /* may be told or not: too flat for 360 poses over the range, or beside another */
  bool found;
} expected;

static double force(const course *c, int i) {
  return fabs(c->n[i] / c->d[i]);
}

static void expect(expected *list, int *count, km_force_event_kind kind, double a, double b) {
  if (*count < MOST_EVENTS)
    list[(*count)++] = (expected){kind, fmin(a, b), fmax(a, b), false, false};
}

/* Peaks between samples i−1 and i+1 of one sign that no pole parts. */
static bool peaks(const course *c, int i) {
  bool apart = c->d[i - 1] * c->d[i] < 0.0 || c->d[i] * c->d[i + 1] < 0.0;
  return !apart && force(c, i) > force(c, i - 1) && force(c, i) > force(c, i + 1);
}

/* Does |f| fall by less than 1e-4 of it on a side within two of the poses that a sweep looks at? */
static bool is_weak(const course *c, int i) {
  int window = c->count / 180;
  for (int side = -1; side <= 1; side += 2) {
    double least = force(c, i);
    for (int k = 1; k <= window && i + side * k >= 0 && i + side * k < c->count; ++k)
      least = fmin(least, force(c, i + side * k));
    if (least > (1.0 - 1e-4) * force(c, i))
      return true;
  }
  return false;
}

static int list_of(const course *c, bool ends, expected *list) {
  int count = 0;
  for (int i = 0; i + 1 < c->count; ++i) {
    bool zero = c->n[i] * c->n[i + 1] < 0.0, pole = c->d[i] * c->d[i + 1] < 0.0;
    if (zero)
      expect(list, &count, KM_FORCE_BALANCED, c->s[i], c->s[i + 1]);
    if (zero && count > 0) /* both in one place, and the force goes on as it was; or the one beside the other */
      list[count - 1].weak = pole;
    if (pole)
      expect(list, &count, KM_FORCE_UNBOUNDED, c->s[i], c->s[i + 1]);
    if (pole && count > 0)
      list[count - 1].weak = zero;
    if (i > 0 && peaks(c, i)) {
      expect(list, &count, KM_FORCE_PEAK, c->s[i - 1], c->s[i + 1]);
      list[count - 1].weak = is_weak(c, i);
    }
  }
  if (ends)
    expect(list, &count, KM_FORCE_UNBOUNDED, c->s[c->count - 1], c->s[c->count - 1]);
  return count;
}

static const char *word(km_force_event_kind kind) {
  return kind == KM_FORCE_BALANCED ? "zero" : kind == KM_FORCE_PEAK ? "peak" : "pole";
}

bool course_agrees(const course *c, const km_statics_sweep *sweep, int actuator, bool ends, double slack,
                   family_count *count) {
  expected list[MOST_EVENTS];
  int expects = list_of(c, ends, list);
  bool right = true;
  slack *= 1.0 + fabs(c->s[c->count - 1] - c->s[0]);
  for (size_t e = 0; e < sweep->event_count; ++e) {
    const km_force_event *event = &sweep->events[e];
    bool known = event->actuator != actuator;
    for (int i = 0; i < expects && !known; ++i) {
      bool here = event->s >= list[i].low - slack && event->s <= list[i].high + slack;
      known = !list[i].found && event->kind == list[i].kind && here;
      list[i].found = list[i].found || known;
    }
    /* Differences begin half a place after the start, peaks a whole one later. */
    const double *s = c->s;
    int last = c->count - 1;
    known = known || (event->s - s[1]) * (s[last] - s[0]) < 0.0 || (event->s - s[last]) * (s[last] - s[0]) > 0.0;
    known = known || (event->kind == KM_FORCE_BALANCED && fabs(event->s - s[last]) < slack &&
                      comes_to_nothing(c->n, c->count) && !comes_to_nothing(c->d, c->count));
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
  count->ends += ends;
  return right;
}
