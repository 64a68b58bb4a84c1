/* kstatic at: the balance of forces at one pose. */
#include "common/command_line/question_options.h"
#include "common/drive_limits.h"
#include "kstatic/kstatic.h"

#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/report.h"

typedef struct options {
  kt_request request;
  kt_question asked;
  bool rests;
} options;

static kt_exit describe(const options *o, const kt_pose *pose, const km_statics *statics) {
  km_text out = {0};
  km_arena arena = {0};
  if (o->request.json) {
    const km_value *record = km_statics_record(pose->mechanism, pose->state, statics, o->request.model, &arena);
    if (record)
      km_json_write(record, &out);
    out.failed = out.failed || !record;
  } else {
    km_statics_print(pose->mechanism, statics, o->request.model, &out);
  }
  kt_exit result = kt_answer(&o->request, "forces", &out);
  km_arena_free(&arena);
  km_text_free(&out);
  return result;
}

/* Warnings about loads that the actuators can't balance. */
static void report_falls(const options *o, const kt_pose *pose, const km_statics *statics) {
  for (int d = 0; d < statics->direction_count && d < KM_MAX_DIRECTIONS; ++d) {
    km_text words = {0};
    if (!statics->falls[d])
      continue;
    km_direction_words(pose->mechanism, statics, d, &words);
    kt_print_message(
        &o->request.common, KM_ERROR,
        "%s: the actuators can't hold this pose: the loads move %s; expected an actuator among these joints",
        o->request.model, words.data ? words.data : "");
    km_text_free(&words);
  }
}

/* Lists the actuated coordinates; returns their number, −1: an actuator is a point. */
static int list_actuators(const km_statics *statics, int *out) {
  for (int i = 0; i < statics->actuator_count; ++i) {
    if (statics->actuators[i].kind != KM_PORT_JOINT)
      return -1;
    out[i] = statics->actuators[i].coordinate;
  }
  return statics->actuator_count;
}

/* Moves the joints that no actuator holds to rest, and names their values. */
static kt_exit move_to_rest(const options *o, const kt_pose *pose, const km_question *question) {
  const km_statics *statics = km_question_balance(question);
  const km_model *model = pose->model;
  const kt_common *common = &o->request.common;
  km_error error;
  km_text words = {0};
  int *actuators = km_alloc((size_t)statics->actuator_count + 1, sizeof *actuators);
  if (!actuators)
    return KT_NO_MEMORY;
  const int count = list_actuators(statics, actuators);
  km_status status = KM_USAGE;
  if (count < 0)
    kt_print_message(common, KM_ERROR, "--rest: an actuator is a force at a point; expected joints that hold");
  else
    status = km_equilibrium_hold(pose->mechanism, pose->state, km_question_forces(question), actuators, count, &error);
  if (count >= 0 && status)
    kt_print_message(common, KM_ERROR, "%s: --rest: %s", o->request.model, error.text);
  for (int c = 0; c < km_model_coordinate_count(model) && !status; ++c) {
    bool is_held = false;
    for (int i = 0; i < count; ++i)
      is_held = is_held || actuators[i] == c;
    if (!is_held)
      km_text_format(&words, "%s%s %.9g %s", words.size ? ", " : "", km_model_coordinate_label(model, c),
                     km_state_coordinate(pose->state, c), km_model_coordinate_unit(model, c));
  }
  if (words.size && !words.failed)
    kt_print_message(common, KM_NOTE, "%s: at rest: %s", o->request.model, words.data);
  km_text_free(&words);
  km_free(actuators);
  return status == KM_NO_RESULT ? KT_PARTIAL : kt_exit_of(status);
}

static kt_exit run(const options *o, const kt_pose *pose) {
  km_question *question = NULL;
  km_mobility mobility;
  kt_exit result = kt_compute_question(&o->request.common, o->request.model, &o->asked, pose, &question);
  if (result == KT_DONE && o->rests)
    result = move_to_rest(o, pose, question);
  if (result == KT_DONE) {
    km_statics *statics = km_question_balance(question);
    if (km_mobility_compute(pose->mechanism, pose->state, &mobility) ||
        km_statics_compute(pose->mechanism, pose->state, km_question_forces(question), statics) == KM_MEMORY)
      result = KT_NO_MEMORY;
  }
  if (result == KT_DONE) {
    const km_statics *statics = km_question_balance(question);
    report_falls(o, pose, statics);
    for (int i = 0; i < statics->actuator_count; ++i)
      kt_report_drive(&o->request.common, o->request.model, pose, &statics->actuators[i], statics->actuator_forces[i],
                      "");
    result = describe(o, pose, statics);
    if (result == KT_DONE && !statics->held)
      result = KT_PARTIAL;
  }
  km_question_free(question);
  return result;
}

static void read_options(options *o, int argc, char **argv) {
  kt_options all = {0};
  kt_request_options(&all, &o->request, true, KT_REQUEST_BASE("forces"));
  kt_question_options(&all, &o->asked, "forces", false);
  const kt_option own[] = {
      {"rest", 0, NULL, "Move the joints without an actuator to rest first, such as a follower on its cam", KT_FLAG,
       &o->rests, KT_ABOUT_METHOD},
  };
  KT_OPTIONS_ADD(&all, own);
  kt_common_options(&all, &o->request.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "What actuators and joints must hold at a pose against gravity, loads, springs, contacts and stops, and the reaction in "
      "every joint. Exit status 1 if the actuators can't hold it. Forces beyond a joint's max_force are warnings."
      "\vJSON keys beside those of every record: held, undetermined_directions [{falls, statement, direction}], "
      "actuator_forces (null where they can't hold), beyond_max_force [labels], contacts [{name, kind, penetration, normal_force, friction_limit}], "
      "holding_range {actuator: [least, most]} with friction of the contacts, actuator_set (unique; redundant, least norm; can't hold), "
      "least_norm_forces, axes, reactions {force, torque, indeterminate}, reactions_with, reactions_note (what couplings leave out), degree_of_indeterminacy, "
      "held_joints, configuration. Forces are positive along +q, those of angles per radian; a reaction is the wrench "
      "of parent on child about the origin of the child's joint frame.",
      argc, argv);
}

kt_exit kstatic_at(int argc, char **argv) {
  options o = {.request = {.common = KT_COMMON("kstatic")}};
  read_options(&o, argc, argv);
  kt_pose pose;
  kt_exit result = kt_request_open(&o.request, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
