/* kredund ik: all branches of poses that reach one pose of the effector. kredund selfmotion: one of them. */
#include "kredund/kredund.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/model.h"
#include "kmech/report.h"

static kt_exit read_pose(const kredund_request *r, const kredund_open *open, km_frame_pose *out) {
  double value[6];
  if (!kt_numbers(r->pose, 6, value))
    return kt_usage(&r->common, "--pose", r->pose, "six numbers X,Y,Z,RX,RY,RZ");
  double unit = km_model_units(open->pose.model).angle->si;
  const double turn[3] = {value[3] * unit, value[4] * unit, value[5] * unit};
  if (km_frame_pose_make(value, turn, out, NULL))
    return kt_usage(&r->common, "--pose", r->pose, "six finite numbers X,Y,Z,RX,RY,RZ");
  return KT_DONE;
}

/* --pose, the path's first pose, or where the arm is. */
static kt_exit find_target(const kredund_request *r, const kredund_open *open, km_frame_pose *out) {
  const km_path *path = km_study_bound_path(open->study);
  if (r->pose)
    return read_pose(r, open, out);
  if (path) {
    km_path_pose(path, 0, out);
    return KT_DONE;
  }
  kt_exit result;
  double *q = kredund_start(r, open, &result);
  if (q)
    result = kt_exit_of(km_arm_place(km_study_arm(open->study), q, out, NULL));
  km_free(q);
  return result;
}

static kt_exit answer(const kredund_request *r, const km_value *record, km_text *text, km_arena *arena) {
  if (r->json && record)
    km_json_write(record, text);
  if (arena->failed)
    text->failed = true;
  return r->base ? kt_write(&r->common, r->base, "ik", r->json ? "json" : "txt", text) : kt_print(&r->common, text);
}

static kt_exit run(const kredund_request *r, const kredund_open *open) {
  km_frame_pose target;
  km_ik_solutions branches;
  km_error error;
  km_arena arena = {0};
  km_text text = {0};
  const km_arm *arm = km_study_arm(open->study);
  kt_exit result = find_target(r, open, &target);
  if (result != KT_DONE)
    return result;
  km_status status = km_ik_solutions_find(arm, &target, r->common.seed, NULL, NULL, &branches, &error);
  if (status) {
    kt_print_message(&r->common, KM_ERROR, "%s: %s", open->name, error.text);
    result = kt_exit_of(status);
  } else {
    if (!r->json)
      km_ik_solutions_print(arm, &branches, open->name, &text);
    result = answer(r, r->json ? km_ik_solutions_record(arm, &branches, open->model, &arena) : NULL, &text, &arena);
    if (result == KT_DONE && branches.within == 0) {
      kt_print_message(&r->common, KM_ERROR, "%s: no branch has a pose within the joint limits", open->name);
      result = KT_PARTIAL;
    }
  }
  km_ik_solutions_free(&branches);
  km_arena_free(&arena);
  km_text_free(&text);
  return result;
}

kt_exit kredund_ik(int argc, char **argv) {
  kredund_request r = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  const kt_option table[] = {
      {"pose", 0, "X,Y,Z,RX,RY,RZ",
       "The effector's pose in the inertial frame: place and rotation vector, in the model's units", KT_TEXT, &r.pose,
       KT_ABOUT_MODEL},
      {"format", 0, "FORMAT", "table (default) or json", KT_WORD("table or json"), &r.json, KT_ABOUT_FILES},
      KT_BASE(&r.base, KT_REQUEST_BASE("ik")),
  };
  kredund_arm_options(&all, &r);
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &r.common, KT_USES_SEED | KT_USES_MODEL);
  kt_options_hide(&all, "objective"); /* columns that only tracks have */
  kt_options_hide(&all, "rates");
  kt_options_read(&all,
                  "Every branch of poses that reach a pose of the effector: one self-motion each, with its closed "
                  "length or its arcs within the limits.",
                  argc, argv);
  kredund_open open;
  kt_exit result = kredund_bind(&r, false, &open);
  if (result == KT_DONE)
    result = run(&r, &open);
  kredund_close(&open);
  return result;
}
