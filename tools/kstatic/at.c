/* kstatic at: the balance of forces at one pose. */
#include "kstatic/kstatic.h"

#include "exchange/json/json.h"
#include "report/record/statics_record.h"

typedef struct options {
  kt_request request;
  kstatic_options acting;
} options;

static kt_exit describe(const options *o, const kt_pose *pose, const km_statics *statics) {
  km_text out = {0};
  km_arena arena = {0};
  if (o->request.json) {
    const km_value *record =
        km_statics_record(pose->mechanism, pose->state, statics, (km_axes)o->acting.axes, o->request.model, &arena);
    if (record)
      km_json_write(record, &out);
    out.failed = out.failed || !record;
  } else {
    km_statics_print(pose->mechanism, statics, (km_axes)o->acting.axes, o->request.model, &out);
  }
  kt_exit result = kt_answer(&o->request, "forces", &out);
  km_arena_free(&arena);
  km_text_free(&out);
  return result;
}

/* What the actuators can't hold, on the standard error. */
static void tell_falls(const options *o, const kt_pose *pose, const km_statics *statics) {
  for (int d = 0; d < statics->direction_count && d < KM_MOST_DIRECTIONS; ++d) {
    km_text words = {0};
    if (!statics->falls[d])
      continue;
    km_direction_words(pose->mechanism, statics, d, &words);
    kt_say(&o->request.common, KM_ERROR,
           "%s: the actuators can't hold this pose: the loads move %s; expected an actuator among these joints",
           o->request.model, words.data ? words.data : "");
    km_text_free(&words);
  }
}

static kt_exit run(const options *o, const kt_pose *pose) {
  kstatic_balance balance;
  km_mobility mobility;
  kt_exit result = kstatic_prepare(&o->request.common, o->request.model, pose, &o->acting, &balance);
  if (result == KT_DONE) {
    km_mobility_update(pose->mechanism, pose->state, &mobility);
    km_statics_update(pose->mechanism, pose->state, balance.forces, &balance.statics);
    tell_falls(o, pose, &balance.statics);
    result = describe(o, pose, &balance.statics);
    if (result == KT_DONE && !balance.statics.held)
      result = KT_PARTIAL;
  }
  kstatic_free(&balance);
  return result;
}

static options read_options(int argc, char **argv) {
  options o = {.request = {.common = KT_COMMON("kstatic")}};
  kt_options all = {0};
  kt_request_options(&all, &o.request, true, KT_REQUEST_BASE("forces"));
  kstatic_options_add(&all, &o.acting);
  kt_common_options(&all, &o.request.common, 0);
  kt_options_read(
      &all,
      "What actuators and joints must hold at a pose against gravity, loads and springs, and the reaction in every "
      "joint. Exit status 1 if the actuators can't hold it."
      "\vJSON keys beside those of every record: held, undetermined_directions [{falls, statement, direction}], "
      "actuator_forces (null where they can't hold), actuator_set (unique; redundant, least norm; can't hold), "
      "least_norm_forces, axes, reactions {force, torque, indeterminate}, reactions_with, degree_of_indeterminacy, "
      "held_joints, configuration. Forces are positive along +q, those of angles per radian; a reaction is the wrench "
      "of parent on child about the origin of the child's joint frame.",
      argc, argv);
  return o;
}

kt_exit kstatic_at(int argc, char **argv) {
  options o = read_options(argc, argv);
  kt_pose pose;
  kt_exit result = kt_request_open(&o.request, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
