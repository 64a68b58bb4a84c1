/* Defaults and validation of path plans. */
#include "model/path_study/path_plan.h"

#include "base/text.h"
#include "spatial/vec3.h"

#include <stdio.h>

km_path_segment km_path_segment_default(km_path_shape shape) {
  return (km_path_segment){.shape = shape, .steps = 100, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .waves = 1.0};
}

km_path_plan km_path_plan_default(void) {
  return (km_path_plan){.start = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}};
}

const char *km_path_fault_text(const km_path_fault *fault, char out[KM_PATH_FAULT_TEXT]) {
  char segment[32] = "", item[24] = "";
  if (fault->segment >= 0)
    snprintf(segment, sizeof segment, "segments[%d]%s", fault->segment, fault->key ? "." : "");
  if (fault->item >= 0)
    snprintf(item, sizeof item, "[%d]", fault->item);
  snprintf(out, KM_PATH_FAULT_TEXT, "%s%s%s", segment, fault->key ? fault->key : "", item);
  return out;
}

static km_status check_speed(double speed, km_error *error) {
  if (speed >= 0.0 && isfinite(speed))
    return KM_OK;
  return km_fail(error, KM_USAGE, "found %s; expected 0 or more", KM_SHOWN(speed));
}

static km_status check_direction(const double v[3], km_error *error) {
  double length = km_vec3_norm(km_vec3_from_array(v));
  if (length > 0.0 && isfinite(length))
    return KM_OK;
  return km_fail(error, KM_USAGE, "found a vector of length %s; expected a direction", KM_SHOWN(length));
}

static km_status check_waves(double waves, km_error *error) {
  if (waves > 0.0 && waves <= 1e4)
    return KM_OK;
  return km_fail(error, KM_USAGE, "found %s; expected a number above 0 up to 10000", KM_SHOWN(waves));
}

/* Key of the first fault of a segment; NULL if there is none. */
static const char *faulty_key(const km_path_segment *g, km_error *error) {
  if (!g->at_points && (g->steps < 1 || g->steps > KM_PATH_STEPS)) {
    km_fail(error, KM_USAGE, "found %d; expected a whole number from 1 to %d", g->steps, KM_PATH_STEPS);
    return "steps";
  }
  if (g->shape == KM_PATH_ARC && check_direction(g->axis, error))
    return "axis";
  if (g->shape == KM_PATH_WEAVE && check_direction(g->sideways, error))
    return "sideways";
  return g->shape == KM_PATH_WEAVE && check_waves(g->waves, error) ? "waves" : NULL;
}

km_status km_path_plan_check(const km_path_plan *plan, km_path_fault *fault, km_error *error) {
  double steps = 0.0;
  *fault = (km_path_fault){-1, "speed", -1};
  if (check_speed(plan->speed, error))
    return KM_USAGE;
  fault->key = "turn_speed";
  if (check_speed(plan->turn_speed, error))
    return KM_USAGE;
  fault->key = "segments";
  if (plan->segment_count < 1)
    return km_fail(error, KM_USAGE, "found none; expected at least one segment");
  for (int i = 0; i < plan->segment_count; ++i) {
    const km_path_segment *g = &plan->segments[i];
    const char *key = faulty_key(g, error);
    if (key) {
      *fault = (km_path_fault){i, key, -1};
      return KM_USAGE;
    }
    steps += g->at_points ? 0 : g->steps;
  }
  if (steps > KM_PATH_STEPS)
    return km_fail(error, KM_USAGE, "found %s steps in all; expected at most %d", KM_SHOWN(steps), KM_PATH_STEPS);
  return KM_OK;
}
