/* Acceptance of designs in an optimisation, the best design, and the front of two goals (non-dominated designs). */
#include "study/optimisation/goals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool is_goal(const km_design_optimise *o, const char *figure) {
  for (int g = 0; o && g < o->goal_count; ++g)
    if (strcmp(o->goals[g].figure, figure) == 0)
      return true;
  return false;
}

/* True if a motion that ends early is acceptable: the figure `reached` is a goal or has limits, so it decides
 * itself. */
static bool accepts_early_end(const km_design_study *s) {
  for (int f = 0; f < s->figure_count; ++f) {
    const km_design_figure *figure = s->figures[f];
    bool counts = isfinite(figure->low) || isfinite(figure->high) || is_goal(s->def->optimise, figure->name);
    if (figure->kind == KM_DESIGN_REACHED && counts)
      return true;
  }
  return false;
}

bool km_design_has_answer(const km_design_study *s, const km_design_result *r) {
  return r->outcome == KM_DESIGN_DONE || (r->outcome == KM_DESIGN_SHORT && accepts_early_end(s));
}

bool km_design_is_within(const km_design_figure *figure, double x) {
  double size = fmax(fabs(figure->low), fabs(figure->high));
  double constraint = 1e-9 * (isfinite(size) ? size : fabs(x));
  return x >= figure->low - constraint && x <= figure->high + constraint;
}

bool km_design_study_accepts(const km_design_study *s, const km_design_result *r) {
  if (!s || !r || !km_design_has_answer(s, r))
    return false;
  for (int f = 0; f < s->figure_count; ++f) {
    bool unlimited = isinf(s->figures[f]->low) && isinf(s->figures[f]->high);
    if (!unlimited && !km_design_is_within(s->figures[f], r->figures[f]))
      return false;
  }
  return true;
}

double km_design_goal_value(const km_design_study *s, int goal, const km_design_result *r) {
  const km_design_goal *g = &s->def->optimise->goals[goal];
  double value = r->figures[km_design_find_figure(s->def, g->figure)];
  return g->largest ? -value : value;
}

int km_design_study_best(const km_design_study *s) {
  int best = -1;
  double least = HUGE_VAL;
  km_design_result r;
  for (int i = 0; s && s->def->optimise && i < s->trail.count; ++i)
    if (!km_design_study_result(s, i, &r, NULL) && km_design_study_accepts(s, &r) &&
        km_design_goal_value(s, 0, &r) < least) {
      best = i;
      least = km_design_goal_value(s, 0, &r);
    }
  return best;
}

typedef struct front_point {
  int design;
  double goals[2];
} front_point;

static int compare_goals(const void *a, const void *b) {
  const front_point *p = a, *q = b;
  for (int g = 0; g < 2; ++g)
    if (p->goals[g] != q->goals[g])
      return p->goals[g] < q->goals[g] ? -1 : 1;
  return p->design - q->design;
}

/* Non-dominated designs: sorted by the first goal, those with a new minimum of the second. */
int km_design_study_front(const km_design_study *s, int *designs, int capacity) {
  if (!s || !s->def->optimise || s->def->optimise->goal_count != 2 || (capacity > 0 && !designs))
    return 0;
  front_point *points = KM_NEW(front_point, (size_t)s->trail.count + 1);
  km_design_result r;
  int count = 0, kept = 0;
  double least = HUGE_VAL;
  for (int i = 0; points && i < s->trail.count; ++i)
    if (!km_design_study_result(s, i, &r, NULL) && km_design_study_accepts(s, &r))
      points[count++] = (front_point){i, {km_design_goal_value(s, 0, &r), km_design_goal_value(s, 1, &r)}};
  if (points)
    qsort(points, (size_t)count, sizeof *points, compare_goals);
  for (int i = 0; i < count; ++i)
    if (points[i].goals[1] < least) {
      least = points[i].goals[1];
      if (kept++ < capacity)
        designs[kept - 1] = points[i].design;
    }
  km_free(points);
  return kept;
}
