/* Progress of a stage as that of the whole work: from + (to − from) done, never falling. */
#include "kmech/base.h"

#include <math.h>

void km_progress_stage_next(km_progress_stage *stage, double to) {
  if (!stage)
    return;
  stage->from = stage->to;
  stage->to = to;
}

bool km_progress_stage_report(void *stage, double done) {
  km_progress_stage *s = stage;
  if (!s || !s->progress)
    return true;
  s->reported = fmax(s->reported, s->from + (s->to - s->from) * fmin(fmax(done, 0.0), 1.0));
  return s->progress(s->context, s->reported);
}
