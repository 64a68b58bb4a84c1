/* Courses of the joints of a track against their limits. */
#include "arm/tracking/joint_course.h"

#include <math.h>

static double margin_of(const km_arm *a, int k, double value) {
  double q = km_arm_from_units(a, k, value), half = 0.5 * (a->high[k] - a->low[k]);
  return half < HUGE_VAL ? fmin(q - a->low[k], a->high[k] - q) / half : nan("");
}

km_joint_course km_joint_course_find(const km_track *t, int k) {
  size_t q = km_table_span(t->table, "q.").first + (size_t)k, v = km_table_span(t->table, "v.").first + (size_t)k;
  size_t s = (size_t)km_table_find(t->table, "s");
  km_joint_course out = {HUGE_VAL, -HUGE_VAL, nan(""), 0.0, -1.0, 0.0, nan("")};
  for (size_t r = 0; r < km_table_rows(t->table); ++r) {
    const double *row = km_table_row(t->table, r);
    double margin = margin_of(t->arm, k, row[q]);
    out.least = fmin(out.least, row[q]);
    out.greatest = fmax(out.greatest, row[q]);
    if (isfinite(margin) && !(out.margin <= margin)) {
      out.margin = margin;
      out.margin_s = row[s];
    }
    if (fabs(row[v]) > out.rate) {
      out.rate = fabs(row[v]);
      out.rate_s = row[s];
    }
  }
  if (t->arm->rate[k] < HUGE_VAL)
    out.rate_part = out.rate / km_arm_to_units(t->arm, k, t->arm->rate[k]);
  return out;
}

int km_limiting_joint(const km_track *t) {
  int limiting = -1;
  double least = HUGE_VAL;
  for (int k = 0; k < t->arm->n; ++k) {
    double margin = km_joint_course_find(t, k).margin;
    if (margin < least) {
      least = margin;
      limiting = k;
    }
  }
  return limiting;
}

int km_fastest_joint(const km_track *t) {
  int fastest = -1;
  double most = -1.0;
  for (int k = 0; k < t->arm->n; ++k) {
    double part = km_joint_course_find(t, k).rate_part;
    if (part > most) {
      most = part;
      fastest = k;
    }
  }
  return fastest;
}

double km_track_part(const km_track *t) {
  return 100.0 * t->end.s / km_path_length(t->plan.path, t->plan.path->samples - 1);
}
