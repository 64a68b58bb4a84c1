/* Goals of an optimisation. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_GOALS_H
#define KM_STUDY_OPTIMISATION_GOALS_H

#include "study/design_study.h"

/* True if all requests have answers. A motion that ends early has none, unless the figure `reached` is a goal or has
 * limits. */
bool km_design_has_answer(const km_design_study *study, const km_design_result *result);
/* True if a value is within the figure's limits, up to rounding. */
bool km_design_is_within(const km_design_figure *figure, double value);
/* Value to minimise: the goal's figure, negated if it is to be maximised. */
double km_design_goal_value(const km_design_study *study, int goal, const km_design_result *result);

#endif
