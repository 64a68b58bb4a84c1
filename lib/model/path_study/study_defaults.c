/* Default definition of a path study, with the names of its parts in messages. */
#include "kmech/arm.h"

km_study_def km_study_def_default(void) {
  return (km_study_def){.effector.place.text = "effector",
                        .frame = -1,
                        .coordinates.place.text = "coordinates",
                        .q0.place.text = "q0",
                        .rates.place.text = "rates",
                        .task = KM_TASK_POSE,
                        .task_place.text = "task",
                        .path = {.plan = km_path_plan_default(), .place.text = "path"},
                        .methods_place.text = "methods",
                        .objective = km_objective_of(KM_PATH_CONTROL),
                        .objective_place.text = "objective"};
}
