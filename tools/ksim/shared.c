/* What ksim's commands read alike. */
#include "ksim/ksim.h"

#include "base/memory.h"
#include "model/model.h"

#include <math.h>

kt_exit ksim_read_number(const kt_common *common, const char *option, const char *text, const char *expected,
                         double *out) {
  if (!text)
    return KT_DONE;
  return kt_number(text, out) && isfinite(*out) && *out > 0.0 ? KT_DONE : kt_usage(common, option, text, expected);
}

kt_exit ksim_read_frames(const kt_common *common, const km_model *model, const kt_texts *texts,
                         const km_followed_frame **out, int *count) {
  km_followed_frame *frames = KM_NEW(km_followed_frame, (size_t)texts->count + 1);
  kt_exit result = frames ? KT_DONE : KT_INTERNAL;
  *out = frames;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i) {
    frames[i].name = texts->items[i];
    result = kt_frame(common, model, "--frame", texts->items[i], &frames[i].frame);
    *count = i + 1;
  }
  return result;
}

/* Coulomb friction needs the reactions, which equations of motion in independent coordinates leave out. */
static void tell_friction(const kt_common *common, const char *path, const km_model *model) {
  for (int j = 0; j < model->joint_count; ++j) {
    if (!(model->joints[j].friction.coefficient > 0.0))
      continue;
    kt_say(common, KM_NOTE,
           "%s: the coefficient of friction of joint \"%s\" doesn't count in a motion yet; only a constant torque of "
           "friction does",
           path, model->joints[j].label);
    return;
  }
}

kt_exit ksim_forces(const kt_common *common, const char *path, const kt_pose *pose, km_forces **out) {
  int count = km_model_load_count(pose->model);
  km_load *loads = KM_NEW(km_load, (size_t)count + 1);
  km_error error = {KM_MEMORY, "out of memory"};
  for (int i = 0; i < count && loads; ++i)
    loads[i] = km_model_load_at(pose->model, i);
  km_status status = loads ? km_forces_create(pose->mechanism, NULL, loads, count, out, &error) : KM_MEMORY;
  km_free(loads);
  tell_friction(common, path, pose->model);
  if (status)
    kt_say(common, KM_ERROR, "%s: %s", path, error.text);
  return kt_exit_of(status);
}
