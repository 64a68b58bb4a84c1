/* Joints of a path study, bound to the arm: their order, start values, rates, and the joints that a method fixes. */
#include "arm/study/study_binding.h"

#include "arm/tracking/joint_effort.h"
#include "base/similar_names.h"
#include "base/text.h"
#include "model/path_study/method_settings.h"

#include <stdio.h>
#include <string.h>

static int find_column(const km_arm *a, const char *label) {
  for (int k = 0; k < a->n && label; ++k)
    if (strcmp(km_arm_label(a, k), label) == 0)
      return k;
  return -1;
}

/* Stores one label of the order. */
static bool store_label(km_binder *b, int index, bool *seen) {
  const km_arm *a = b->study->arm;
  const km_study_names *list = &b->def->coordinates;
  const char *label = list->items[index];
  char where[128];
  int k = find_column(a, label);
  snprintf(where, sizeof where, "%s[%d]", list->place.text, index);
  const km_study_place at = {where, list->place.option};
  if (k < 0)
    return km_binder_fault(b, &at, "\"%.80s\" is no joint on the way to the effector; expected one from %s to %s",
                           label ? label : "", km_arm_label(a, 0), km_arm_label(a, a->n - 1));
  if (seen[k])
    return km_binder_fault(b, &at, "\"%.80s\" is given twice; expected each joint once", label);
  seen[k] = true;
  b->order[index] = k;
  return true;
}

bool km_bind_order(km_binder *b) {
  const km_arm *a = b->study->arm;
  const km_study_names *list = &b->def->coordinates;
  bool is_ok = true, seen[KM_ARM_MAX_JOINTS] = {false};
  b->order = KM_ARENA_NEW(&b->study->arena, int, (size_t)a->n);
  if (!b->order)
    return km_binder_memory(b);
  for (int k = 0; k < a->n; ++k)
    b->order[k] = k;
  if (list->count > 0 && list->count != a->n)
    return km_binder_fault(b, &list->place,
                           "found %d joints; expected the %d on the way to the effector, from %s to %s", list->count,
                           a->n, km_arm_label(a, 0), km_arm_label(a, a->n - 1));
  for (int i = 0; i < list->count; ++i)
    is_ok = store_label(b, i, seen) && is_ok;
  return is_ok;
}

/* Reorders values from the order of `coordinates` to that of the arm: out[n]. */
static bool reorder(km_binder *b, const km_study_numbers *list, double *out) {
  const km_arm *a = b->study->arm;
  if (list->count != a->n)
    return km_binder_fault(b, &list->place, "found %d values; expected %d, one for each joint from %s to %s",
                           list->count, a->n, km_arm_label(a, 0), km_arm_label(a, a->n - 1));
  for (int i = 0; i < a->n; ++i)
    out[b->order[i]] = list->items[i];
  return true;
}

/* True if the path states a speed or times. */
static bool has_speed(const km_path_plan *plan) {
  bool timed = plan->speed > 0.0 || plan->turn_speed > 0.0;
  for (int i = 0; i < plan->segment_count && plan->segments; ++i)
    timed = timed || (plan->segments[i].shape == KM_PATH_SPLINE && plan->segments[i].times);
  return timed;
}

/* Sets the rates from the drives' max_rate in the model, if the path has a speed. */
static void set_drive_rates(km_binder *b) {
  km_arm *a = b->study->arm;
  double second = a->mechanism->model->units.time->si;
  bool timed = has_speed(&b->def->path.plan), some = false;
  for (int k = 0; k < a->n; ++k) {
    double most = a->mechanism->max_rate[a->coordinate[k]];
    some = some || most < HUGE_VAL;
    if (timed)
      a->rate[k] = most / a->unit[k] / second;
  }
  if (some && !timed && b->def->path.plan.segments)
    km_messages_add(
        b->messages, KM_NOTE,
        "the path has no speed, so the joints' max_rate doesn't count (\"speed\" in the path, or \"rates\")");
}

bool km_bind_rates(km_binder *b) {
  const km_study_numbers *list = &b->def->rates;
  km_arm *a = b->study->arm;
  double rates[KM_ARM_MAX_JOINTS];
  km_error error;
  if (!list->items) {
    set_drive_rates(b);
    return true;
  }
  return reorder(b, list, rates) && km_binder_pass(b, &list->place, km_arm_set_rates(a, rates, a->n, &error), &error);
}

bool km_bind_start(km_binder *b, double *q) {
  const km_arm *a = b->study->arm;
  const km_study_numbers *list = &b->def->q0;
  double given[KM_ARM_MAX_JOINTS];
  if (list->items && !reorder(b, list, given))
    return false;
  for (int k = 0; k < a->n; ++k)
    q[k] = list->items ? km_arm_from_units(a, k, given[k]) : b->state->q[a->coordinate[k]] / a->unit[k];
  int out = list->items ? km_arm_limit_passed(a, q) : -1;
  return out < 0 ||
         km_binder_fault(b, &list->place, "%s at %s is outside its limits; expected %s to %s", km_arm_label(a, out),
                         KM_SHOWN(km_arm_to_units(a, out, q[out])), KM_SHOWN(km_arm_to_units(a, out, a->low[out])),
                         KM_SHOWN(km_arm_to_units(a, out, a->high[out])));
}

static bool unknown_joint(km_binder *b, const km_study_names *joints, const char *label) {
  const km_arm *a = b->study->arm;
  km_nearest nearest = {.wanted = label};
  char names[KM_NEAREST_TEXT];
  for (int k = 0; k < a->n; ++k)
    km_nearest_add(&nearest, km_arm_label(a, k));
  return km_binder_fault(b, &joints->place, "\"%.80s\" is no joint of the arm; the nearest of its %d are %s", label,
                         a->n, km_nearest_text(&nearest, names));
}

/* Adds a joint, by its label, to the fixed joints of a method. */
static bool add_fixed_joint(km_binder *b, const km_study_names *joints, const char *label, km_method *out) {
  const km_arm *a = b->study->arm;
  int k = find_column(a, label);
  if (k < 0)
    return unknown_joint(b, joints, label ? label : "");
  if (out->joint_count == a->freedom || out->joint_count == KM_METHOD_JOINTS)
    return km_binder_fault(b, &joints->place, "found more joints than the %d that are to spare", a->freedom);
  out->joints[out->joint_count++] = k;
  return true;
}

/* Pairs of bodies for the objective clearance: all that no joint connects and that are apart at the start. */
static km_status bind_clearance(km_binder *b, km_error *error) {
  km_study *s = b->study;
  if (s->objective.weight[KM_BODY_CLEARANCE] == 0.0)
    return KM_OK;
  km_state *there;
  km_status status = km_state_create(b->mechanism, &there, error);
  if (status)
    return status;
  status = km_state_assign(b->mechanism, there, b->state, error);
  if (!status) {
    km_poses_compute(b->mechanism, there);
    status = km_clearance_create(b->mechanism, there, NULL, 0, &s->clearance, error);
  }
  if (!status)
    status = km_arm_set_clearance(s->arm, there, s->clearance, error);
  km_state_free(there);
  return status;
}

bool km_bind_methods(km_binder *b) {
  const km_study_def *def = b->def;
  km_study *s = b->study;
  bool is_ok = true;
  s->objective = def->objective;
  km_error error;
  is_ok = km_binder_pass(b, &def->objective_place, bind_clearance(b, &error), &error);
  is_ok = is_ok && km_binder_pass(b, &def->objective_place, km_check_objective(s->arm, &s->objective, &error), &error);
  s->method_count = def->method_count > 0 ? def->method_count : 1;
  s->methods = KM_ARENA_NEW(&s->arena, km_method, (size_t)s->method_count);
  if (!s->methods)
    return km_binder_memory(b);
  s->methods[0] = km_method_default(KM_GREEDY);
  for (int i = 0; i < def->method_count; ++i) {
    const km_study_names *joints = &def->methods[i].joints;
    s->methods[i] = def->methods[i].method;
    for (int k = 0; k < joints->count; ++k)
      is_ok = add_fixed_joint(b, joints, joints->items[k], &s->methods[i]) && is_ok;
  }
  return is_ok;
}
