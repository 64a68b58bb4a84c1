/* Names of objectives and tasks. */
#include "kmech/arm.h"

#include "base/arguments.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const words[KM_OBJECTIVES] = {"path-control", "manipulability", "singular-value", "limit-distance",
                                                 "joint-travel", "rate-margin",    "effort",         "relative-effort",
                                                 "energy",       "positive-work",  "clearance"};

static bool known(km_objective_kind kind) {
  return (unsigned)kind < KM_OBJECTIVES;
}

const char *km_objective_word(km_objective_kind kind) {
  if (!known(kind))
    return "";
  return words[kind];
}

int km_objective_find(const char *word) {
  if (!word)
    return -1;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (strcmp(words[k], word) == 0)
      return k;
  return -1;
}

km_objective km_objective_of(km_objective_kind kind) {
  km_objective objective = {{0}};
  if (known(kind))
    objective.weight[kind] = 1.0;
  return objective;
}

int km_objective_single(const km_objective *objective) {
  if (!objective)
    return -1;
  int found = -1, count = 0;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (objective->weight[k] != 0.0) {
      found = k;
      ++count;
    }
  return count == 1 && objective->weight[found] == 1.0 ? found : -1;
}

const char *km_objective_name(const km_objective *objective) {
  if (!objective)
    return "";
  int kind = km_objective_single(objective);
  return kind < 0 ? "weighted" : words[kind];
}

static km_status unknown(const char *word, km_error *error) {
  char all[200] = "";
  size_t used = 0;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    used += (size_t)snprintf(all + used, sizeof all - used, "%s%s", k ? ", " : "", words[k]);
  return km_fail(error, KM_USAGE, "\"%.40s\" is not an objective; expected one of %s", word, all);
}

km_status km_objective_add(km_objective *objective, const char *word, double weight, km_error *error) {
  if (!objective || !word)
    return km_check_given(false, word ? "objective" : "word", error);
  int kind = km_objective_find(word);
  if (!(fabs(weight) <= 1e6) || weight == 0.0)
    return km_fail(error, KM_USAGE, "expected a weight other than 0, of magnitude up to 1e6");
  if (kind < 0)
    return unknown(word, error);
  objective->weight[kind] += weight;
  return KM_OK;
}

km_status km_task_of_word(const char *word, km_task *out, km_error *error) {
  if (!word || !out)
    return km_check_given(false, word ? "place for the result" : "word", error);
  static const char *const tasks[] = {"pose", "position", "axis"};
  for (int k = 0; k < 3; ++k)
    if (strcmp(word, tasks[k]) == 0) {
      *out = (km_task)k;
      return KM_OK;
    }
  return km_fail(error, KM_USAGE, "\"%.40s\" is not a task; expected pose, position or axis", word);
}
