/* Text about an optimum at bounds of its variables. */
#ifndef KM_REPORT_RECORD_WORDS_BOUND_TEXT_H
#define KM_REPORT_RECORD_WORDS_BOUND_TEXT_H

#include "kmech/study.h"

/* "the best design is at a bound: foot x at its upper bound 110; beyond it may be better", appended. Nothing where no
 * variable of the best design is within the tolerance of the optimisation of a bound. */
void km_designs_bound_words(const km_design_study *study, const km_design_study_def *def, km_text *out);

#endif
