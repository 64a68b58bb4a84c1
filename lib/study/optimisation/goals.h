/* Goals of an optimisation. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_GOALS_H
#define KM_STUDY_OPTIMISATION_GOALS_H

#include "study/design_study.h"

/* Did all questions answer? A motion that stops short doesn't, unless what is reached decides itself. */
bool km_design_has_answer(const km_design_study *study, const km_design_result *result);
/* Is a value within the figure's limits, but for rounding? */
bool km_design_is_within(const km_design_figure *figure, double value);
/* What is to be least: the goal's figure, or what is opposite to it. */
double km_design_goal_value(const km_design_study *study, int goal, const km_design_result *result);

#endif
