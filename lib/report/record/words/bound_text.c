/* Text about an optimum at bounds of its variables.
 *
 *   min(x − low, high − x) <= tolerance · (high − low) */
#include "report/record/words/bound_text.h"

#include "base/text.h"

#include <math.h>

static const double least_tolerance = 1e-4; /* fraction of the width: optimisers approach a bound to about that */

void km_designs_bound_words(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  const km_design_optimise *o = def->optimise;
  const int best = o && o->goal_count == 1 ? km_design_study_best(s) : -1;
  int count = 0;
  if (best < 0 || km_design_study_values(s, best, values, NULL))
    return;
  for (int i = 0; i < o->variable_count; ++i) {
    const km_design_variable *v = &o->variables[i];
    const double width = v->high - v->low, near = fmax(o->tolerance, least_tolerance) * width;
    const double x = values[v->parameter];
    const bool is_low = x - v->low <= near, is_high = v->high - x <= near;
    if (!(width > 0.0) || (!is_low && !is_high))
      continue;
    km_text_format(out, "%s%s at its %s bound %.6g",
                   count++ ? ", " : "the best design is at a bound: ", def->parameters[v->parameter].name,
                   is_high ? "upper" : "lower", is_high ? v->high : v->low);
  }
  if (count)
    km_text_add(out, "; a wider bound may give a better one");
}
