/* A family of planar linkages: toggles and extremes of a leverage along sweeps against displacements alone. */
#include "support/course.h"
#include "support/planar.h"

#include "kmech/sweep.h"

#include <math.h>

enum { SAMPLES = 2500 };

typedef struct lever_case {
  km_sweep_plan plan;
  int input, output;
  course course; /* n, d: steps of input and output */
  double last_s, last[2];
} lever_case;

static void look(void *context, fixture *f, int i, double s) {
  lever_case *k = context;
  course *c = &k->course;
  double q[2] = {f->state->q[k->input], f->state->q[k->output]};
  if (i > 0) {
    c->s[i - 1] = i == SAMPLES && c->by_root ? s : 0.5 * (s + k->last_s);
    c->n[i - 1] = q[0] - k->last[0];
    c->d[i - 1] = q[1] - k->last[1];
  }
  k->last_s = s;
  k->last[0] = q[0];
  k->last[1] = q[1];
}

/* True if a toggle of this state is reported between a place and the next. */
static bool is_told(const km_advantage_sweep *sweep, km_advantage_state state, const course *c, int place) {
  double low, high;
  course_span(c, place, place + 1, &low, &high);
  for (size_t i = 0; i < sweep->toggle_count; ++i) {
    const km_advantage_toggle *t = &sweep->toggles[i];
    bool kind = t->state == state || t->state == KM_ADVANTAGE_UNDEFINED;
    if (kind && t->s >= low - 1e-6 && t->s <= high + 1e-6)
      return true;
  }
  return false;
}

static bool toggles_agree(const lever_case *k, const km_advantage_sweep *sweep, family_count *count) {
  const course *c = &k->course;
  size_t crossings = 0;
  bool right = true;
  for (int i = 0; i + 1 < c->count; ++i) {
    bool zero = c->n[i] * c->n[i + 1] < 0.0, pole = c->d[i] * c->d[i + 1] < 0.0;
    right = right && (!zero || is_told(sweep, KM_ADVANTAGE_ZERO, c, i));
    right = right && (!pole || is_told(sweep, KM_ADVANTAGE_INFINITE, c, i));
    crossings += zero || pole;
    count->zeros += zero;
    count->poles += pole;
  }
  /* One may lie beyond the first or the last difference, or at the driver's end. */
  return right && sweep->toggle_count >= crossings && sweep->toggle_count <= crossings + 2;
}

static double leverage(const course *c, int i) {
  return c->n[i] / c->d[i];
}

/* The leverage at the end, half a place beyond the last difference: beside a pole it grows by more than in the place
 * before. */
static double at_end(const course *c) {
  int last = c->count - 1;
  return (3.0 * c->n[last] - c->n[last - 1]) / (3.0 * c->d[last] - c->d[last - 1]);
}

/* Error bound of the leverage: configurations are closed to `closed`, which matters more for smaller steps. */
static double grain(const course *c, int i) {
  static const double closed = 1e-12;
  return fabs(leverage(c, i)) * (1e-6 + closed / fabs(c->n[i]) + closed / fabs(c->d[i]));
}

/* The bound is that of the reference plus its change to the next places and its rounding; before the first place it
 * may be larger, after the last one by the change to the end, doubled for curvature. If it changes by a tenth of
 * itself over the last place, as next to a pole beyond the end, the reference gives no bound. */
static bool meets(const course *c, double told, double sense) {
  int best = 0;
  for (int i = 1; i < c->count; ++i)
    if (sense * leverage(c, i) > sense * leverage(c, best))
      best = i;
  double value = leverage(c, best), change = 0.0;
  if (best > 0)
    change = fabs(value - leverage(c, best - 1));
  if (best + 1 < c->count)
    change = fmax(change, fabs(value - leverage(c, best + 1)));
  else
    change = fmax(change, 2.0 * fabs(value - at_end(c)));
  double slack = change + grain(c, best);
  double first = leverage(c, 0);
  bool before = best == 0 || fabs(told - first) <= fabs(first - leverage(c, 1));
  bool after = best + 1 == c->count && change > 0.1 * fabs(value);
  return sense * (told - value) >= -slack && (before || after || sense * (told - value) <= slack);
}

/* The bounds of a leverage that stays finite. */
static bool bounds_agree(const lever_case *k, const km_advantage_sweep *sweep, family_count *count) {
  for (size_t i = 0; i < sweep->toggle_count; ++i)
    if (sweep->toggles[i].state != KM_ADVANTAGE_ZERO)
      return true;
  count->peaks++;
  return meets(&k->course, sweep->lowest.value, -1.0) && meets(&k->course, sweep->highest.value, 1.0);
}

bool family_leverage(uint64_t seed, family_count *count) {
  randomness r = {seed};
  planar p = planar_random(&r, 1, 1 + below(&r, 2), false);
  lever_case k = {.input = below(&r, p.joints)};
  while ((k.output = below(&r, p.joints)) == k.input) {
  }
  k.plan = (km_sweep_plan){.coordinate = below(&r, p.joints),
                           .direction = -1,
                           .sign = 1.0,
                           .to = (below(&r, 2) ? 1.0 : -1.0) * uniform(&r, 0.4, 2.5),
                           .steps = 1 + below(&r, 60)};
  if (below(&r, 3) == 0)
    k.plan.arclength = uniform(&r, 1.0, 4.0) / k.plan.steps;
  char *text = planar_text(&p);
  fixture f = fixture_read(text), g = fixture_read(text);
  km_free(text);
  km_port in = {.kind = KM_PORT_JOINT, .coordinate = k.input, .name = "in"},
          out = {.kind = KM_PORT_JOINT, .coordinate = k.output, .name = "out"};
  km_advantage_sweep sweep = {0};
  km_status status = km_advantage_sweep_run(f.mechanism, f.state, &k.plan, &in, &out, false, &sweep, NULL);
  bool right = status == KM_OK || status == KM_PARTIAL;
  k.course = course_make(SAMPLES, &k.plan, &sweep.motion);
  k.course.differences = true;
  bool long_enough = right && fabs(sweep.motion.end.position) > 0.01 && !sweep.motion.start.stop;
  if (long_enough && course_walk(&g, &k.plan, &sweep.motion, SAMPLES + 1, look, &k))
    right = toggles_agree(&k, &sweep, count) && bounds_agree(&k, &sweep, count);
  count->ends += k.course.by_root;
  if (!right) {
    print_error("leverage, seed %llu: %g at %g to %g at %g%s, toggles", (unsigned long long)seed, sweep.lowest.value,
                sweep.lowest.s, sweep.highest.value, sweep.highest.s, k.course.by_root ? ", the driver gives out" : "");
    for (size_t i = 0; i < sweep.toggle_count; ++i)
      print_error(" %s %g", km_advantage_state_name(sweep.toggles[i].state), sweep.toggles[i].s);
    print_error("\n");
  }
  course_free(&k.course);
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
  fixture_close(&g);
  return right;
}
