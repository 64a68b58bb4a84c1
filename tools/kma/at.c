/* kma at: mechanical advantage at one pose. */
#include "kma/kma.h"

#include "kmech/data.h"
#include "kmech/report.h"

#include <math.h>

typedef struct options {
  kt_request request;
  kt_question asked;
  kt_texts points;
} options;

/* The ends of the leverage. */
typedef struct ends {
  km_port input, output;
} ends;

static km_status transmission_at(const kt_pose *pose, const ends *e, km_transmission *out, km_error *error) {
  km_transmission_workspace *work;
  km_status status = km_transmission_create(pose->mechanism, &e->input, &e->output, &work, error);
  if (!status)
    km_transmission_compute(pose->mechanism, pose->state, work, out);
  km_transmission_free(work);
  return status;
}

/* `why` of losses that aren't requested: the model has no friction. */
static km_status losses_at(const kt_pose *pose, const ends *e, km_losses *out, km_error *error) {
  km_losses_workspace *work;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan(""), .why = "no joint has friction"};
  if (!km_model_has_friction(pose->model))
    return KM_OK;
  km_status status = km_losses_create(pose->mechanism, &e->input, &e->output, &work, error);
  if (!status && km_losses_compute(pose->mechanism, pose->state, work, out) == KM_MEMORY)
    status = km_fail(error, KM_MEMORY, "out of memory for the losses");
  km_losses_free(work);
  return status;
}

/* The numbers of a branch point belong to none of its branches. */
static km_status report_branches(const options *o, const kt_pose *pose, km_transfer *lever, km_error *error) {
  enum { MOST = 8 };
  km_advantage each[MOST];
  km_text words = {0};
  int count = km_transfer_branches(pose->mechanism, pose->state, lever, each, MOST);
  for (int i = 0; i < count; ++i) {
    km_text_add(&words, i ? ", " : "");
    if (each[i].state == KM_ADVANTAGE_FINITE)
      km_text_format(&words, "%.6g", each[i].value);
    else
      km_text_add(&words, km_advantage_state_name(each[i].state));
  }
  if (count > 0 && !words.failed)
    kt_print_message(&o->request.common, KM_WARNING,
                     "%s: this pose is a branch point; in the motions that meet the mechanical advantage is %s",
                     o->request.model, words.data);
  bool failed = count < 0 || words.failed;
  km_text_free(&words);
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the branch points") : KM_OK;
}

static km_status describe(const options *o, const kt_pose *pose, const ends *e, km_text *out, km_error *error) {
  km_transfer *lever;
  km_advantage advantage;
  km_transmission transmission;
  km_losses losses;
  km_mobility mobility;
  km_arena arena = {0};
  km_status status = km_transfer_create(pose->mechanism, &e->input, &e->output, &lever, error);
  if (status)
    return status;
  status = km_mobility_compute(pose->mechanism, pose->state, &mobility);
  if (!status)
    status = km_transfer_compute(pose->mechanism, pose->state, lever, &advantage);
  if (status)
    km_fail(error, status, "out of memory for the leverage");
  else
    status = report_branches(o, pose, lever, error);
  km_transfer_free(lever);
  if (!status)
    status = transmission_at(pose, e, &transmission, error);
  if (!status)
    status = losses_at(pose, e, &losses, error);
  if (status)
    return status;
  if (o->request.json) {
    const km_value *record = km_advantage_record(pose->mechanism, pose->state, &e->input, &e->output, &advantage,
                                                 &transmission, &losses, o->request.model, &arena);
    if (record)
      km_json_write(record, out);
    else
      status = km_fail(error, KM_MEMORY, "out of memory");
  } else {
    km_advantage_print(pose->mechanism, &e->input, &e->output, &advantage, &transmission, &losses, o->request.model,
                       out);
  }
  km_arena_free(&arena);
  return status;
}

static kt_exit run(const options *o, const kt_pose *pose) {
  const kt_common *common = &o->request.common;
  km_question *question = NULL;
  km_text out = {0};
  km_error error;
  kt_exit result = kt_compute_question(common, o->request.model, &o->asked, pose, &question);
  if (result == KT_DONE) {
    const ends e = {*km_question_end(question, false), *km_question_end(question, true)};
    km_status status = describe(o, pose, &e, &out, &error);
    if (status)
      kt_print_message(common, KM_ERROR, "%s: %s", o->request.model, error.text);
    result = kt_exit_of(status);
  }
  if (result == KT_DONE)
    result = kt_answer(&o->request, "advantage", &out);
  km_text_free(&out);
  km_question_free(question);
  return result;
}

static void read_options(options *o, int argc, char **argv) {
  kt_options all = {0};
  const kt_option point[] = {
      {"point", 0, "BODY/FRAME:DX,DY,DZ",
       "A point along a direction of the inertial frame as output; a second one: as input before it", KT_TEXTS,
       &o->points, KT_ABOUT_MODEL}};
  kt_request_options(&all, &o->request, true, KT_REQUEST_BASE("advantage"));
  kt_question_options(&all, &o->asked, "advantage", false);
  KT_OPTIONS_ADD(&all, point);
  kt_common_options(&all, &o->request.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "Mechanical advantage of an input over an output at a pose: the input's rate over the output's, signed."
      "\vJSON keys beside those of every record: input, output, mechanical_advantage and velocity_ratio (null where "
      "infinite or undefined), state (finite, zero, infinite, undefined), method (single freedom, least motion), unit, "
      "force_ratio {ideal, actual, efficiency, locks_itself, locks_from (the share of the friction at which it begins "
      "to)} with the joints' friction, transmission {transmission_angle, virtual_coefficient, sutherland_roth, "
      "chen_angeles, manipulability, condition_number, wrench}, each with a value, or null and why it is undefined; "
      "held_joints, configuration.",
      argc, argv);
}

kt_exit kma_at(int argc, char **argv) {
  options o = {.request = {.common = KT_COMMON("kma")}};
  kt_pose pose;
  read_options(&o, argc, argv);
  if (!kma_place_points(&o.request.common, &o.asked, &o.points))
    return KT_USAGE;
  kt_exit result = kt_request_open(&o.request, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
