/* kspace modes: all assembly modes with their evidence and circuits. */
#include "kspace/kspace.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/space.h"

#include <math.h>

enum { TABLE, JSON, CSV };

typedef struct options {
  kt_common common;
  kt_texts holds, sets;
  const char *model;
  const char *base; /* -o, or NULL */
  int format;
  bool limits;
} options;

/* Modes with the pose at which they were searched. */
typedef struct answer {
  const options *o;
  const kt_pose *pose;
  int *locked; /* [locked_count] coordinates that keep their values */
  int locked_count;
  km_all_modes modes;
  km_mode_circuits circuits;
} answer;

/* ---- The locked joints. */

/* Locks the joints of --set; without any, the driver of analysis.sweep if it can move. */
static kt_exit choose_locked(answer *a, km_arena *arena) {
  const km_model *model = a->pose->model;
  kt_settings sets = {0};
  kt_exit result =
      kt_settings_add(&a->o->common, model, "--set", (char **)(size_t)a->o->sets.items, a->o->sets.count, &sets);
  a->locked = KM_ARENA_NEW(arena, int, (size_t)sets.count + 1);
  if (result == KT_DONE && !a->locked)
    result = KT_NO_MEMORY;
  for (int i = 0; result == KT_DONE && i < sets.count; ++i)
    a->locked[a->locked_count++] = sets.items[i].coordinate;
  int driver = km_model_sweep_coordinate(model);
  km_mobility mobility;
  if (result == KT_DONE && sets.count == 0 && driver >= 0) {
    if (km_mobility_compute(a->pose->mechanism, a->pose->state, &mobility))
      result = KT_NO_MEMORY;
    else if (mobility.mobility > 0 && km_mobility_number(a->pose->state, driver) > 0.0)
      a->locked[a->locked_count++] = driver;
  }
  kt_settings_free(&sets);
  return result;
}

/* ---- Text. */

static void print_locked(const answer *a, km_text *out) {
  for (int i = 0; i < a->locked_count; ++i)
    km_text_format(out, "%s%s at %.6g %s", i ? ", " : " with ", km_model_coordinate_label(a->pose->model, a->locked[i]),
                   km_state_coordinate(a->pose->state, a->locked[i]),
                   km_model_coordinate_unit(a->pose->model, a->locked[i]));
}

/* The verdict, and the reason why the list may lack modes. */
static void print_gap(const km_all_modes *m, km_text *out) {
  switch (m->gap) {
  case KM_GAP_NONE:
    km_text_format(out,
                   "complete: the trace test passed, and %s %d complex solutions was followed to the closed loops\n",
                   m->complex_solutions == 1 ? "the one of" : "each of", m->complex_solutions);
    break;
  case KM_GAP_TRACE:
    km_text_format(
        out,
        "at least these: the trace test did not pass. %d complex solutions are known, about %d are estimated "
        "(%d of %d finds were found once); another --seed may find the rest\n",
        m->complex_solutions, m->estimate, m->found_once, m->samples);
    break;
  case KM_GAP_LOST:
    km_text_add(out, "at least these: solutions were lost on the way to the closed loops; try another --seed\n");
    break;
  case KM_GAP_SINGULAR:
    km_text_format(out,
                   "at least these: %d of %d complex solutions are singular, so that modes coincide there or form "
                   "curves; change a dimension a little to tell them apart\n",
                   m->singular, m->complex_solutions);
    break;
  case KM_GAP_MOVES:
    km_text_add(out,
                "self-motion: bodies move although the held joints stay. Modes that move are samples, and there are "
                "as many as you like; hold one joint more, or change a dimension\n");
    break;
  case KM_GAP_LIMIT:
    km_text_format(out, "at least these: the search ended at its limit of work; %d complex solutions are known\n",
                   m->complex_solutions);
    break;
  }
}

/* Worst figures of the proofs. */
static void print_proofs(const km_all_modes *m, km_text *out) {
  int proved = 0;
  double bound = 0.0, radius = HUGE_VAL;
  for (int i = 0; i < m->count; ++i)
    if (m->evidence[i].is_certified) {
      ++proved;
      bound = fmax(bound, m->evidence[i].error_bound);
      radius = fmin(radius, m->evidence[i].radius);
    }
  if (proved > 0)
    km_text_format(out, "proved: %s%d of them, each one solution within %.2g rad or sizes and no other within %.2g\n",
                   proved == m->count ? "all " : "", proved, bound, radius);
  if (m->outside > 0)
    km_text_format(out, "%d mode%s outside the joint limits\n", m->outside, m->outside == 1 ? " is" : "s are");
}

/* Numbers of the modes of one circuit: "2, 4 and 7". */
static void print_members(const answer *a, int circuit, km_text *out) {
  int left = 0, printed = 0;
  for (int i = 0; i < a->modes.count; ++i)
    left += a->circuits.circuit[i] == circuit;
  for (int i = 0; i < a->modes.count; ++i)
    if (a->circuits.circuit[i] == circuit) {
      km_text_format(out, "%s%d", printed == 0 ? "" : left == 1 ? " and " : ", ", i + 1);
      ++printed;
      --left;
    }
}

/* Writes the modes of each circuit, or the reason why they aren't known. */
static void print_circuits(const answer *a, km_text *out) {
  const km_mode_circuits *c = &a->circuits;
  switch (c->gap) {
  case KM_CIRCUIT_GAP_NONE:
  case KM_CIRCUIT_GAP_LOST:
    if (c->freedom == 0) {
      km_text_add(out,
                  "circuits: nothing moves with the held joints free, so that each mode is a circuit of its own\n");
      return;
    }
    if (a->modes.count == 1) {
      km_text_add(out, "1 mode in 1 circuit\n");
      return;
    }
    km_text_format(out, "%d modes in %s%d circuit%s: ", a->modes.count, c->gap ? "at most " : "", c->count,
                   c->count == 1 ? "" : "s");
    for (int k = 1; k <= c->count; ++k) {
      km_text_add(out, k == 1 ? "" : "; ");
      print_members(a, k, out);
    }
    km_text_add(out, c->count == 1 ? ". The motion connects them\n"
                     : c->gap      ? ". A curve was not followed to its end: circuits may be connected there\n"
                                   : ". Another circuit can't be reached without taking the mechanism apart\n");
    return;
  case KM_CIRCUIT_GAP_FREEDOMS:
    km_text_format(out,
                   "circuits: not answered, since the bodies move in %d ways with the held joints free, not in one; "
                   "hold all joints but one rigid by --hold\n",
                   c->freedom);
    return;
  case KM_CIRCUIT_GAP_SELF_MOTION:
    km_text_add(out, "circuits: not answered, since modes are samples of self-motions\n");
    return;
  case KM_CIRCUIT_GAP_BALL:
    km_text_add(out, "circuits: not answered, since nothing but ball joints is held; hold a hinge or a slide\n");
    return;
  }
}

static void print_modes(const answer *a, km_text *out) {
  const km_all_modes *m = &a->modes;
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_text_format(out, "%s: %d assembly mode%s", a->o->model, m->count, m->count == 1 ? "" : "s");
  print_locked(a, out);
  km_text_add(out, "\n");
  print_gap(m, out);
  print_proofs(m, out);
  print_circuits(a, out);
  for (int i = 0; i < m->count; ++i) {
    const km_mode_evidence *e = &m->evidence[i];
    km_text_format(out, "  %d:", i + 1);
    for (int c = 0; c < coordinates; ++c)
      km_text_format(out, "%s %s %.6g %s", c ? "," : "", km_model_coordinate_label(a->pose->model, c),
                     m->coordinates[i * coordinates + c], km_model_coordinate_unit(a->pose->model, c));
    if (a->circuits.count > 0)
      km_text_format(out, "; circuit %d", a->circuits.circuit[i]);
    km_text_format(out, "%s%s%s\n",
                   e->moves         ? "; moves"
                   : e->is_singular ? "; singular"
                                    : "",
                   e->is_certified || e->is_singular ? "" : "; not proved",
                   e->is_within_limits ? "" : "; outside the limits");
  }
}

/* ---- JSON. */

static void add_mode(const answer *a, int i, km_value *list, km_arena *arena) {
  const km_mode_evidence *e = &a->modes.evidence[i];
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_value *mode = km_value_add(arena, list, NULL, KM_OBJECT);
  if (a->circuits.count > 0)
    km_value_number(arena, mode, "circuit", a->circuits.circuit[i]);
  km_value *configuration = km_value_add(arena, mode, "configuration", KM_OBJECT);
  for (int c = 0; c < coordinates; ++c)
    km_value_number(arena, configuration, km_model_coordinate_label(a->pose->model, c),
                    a->modes.coordinates[i * coordinates + c]);
  km_value_number(arena, mode, "residual", e->residual);
  km_value_boolean(arena, mode, "certified", e->is_certified);
  km_value_number(arena, mode, "kantorovich", e->kantorovich);
  km_value_number(arena, mode, "error_bound", e->error_bound);
  km_value_number(arena, mode, "radius", e->radius);
  km_value_number(arena, mode, "mobility", e->mobility);
  km_value *numbers = km_value_add(arena, mode, "mobility_numbers", KM_OBJECT);
  for (int c = 0; c < coordinates; ++c)
    km_value_number(arena, numbers, km_model_coordinate_label(a->pose->model, c),
                    a->modes.mobility_numbers[i * coordinates + c]);
  km_value_boolean(arena, mode, "singular", e->is_singular);
  km_value_boolean(arena, mode, "moves", e->moves);
  km_value_boolean(arena, mode, "within_limits", e->is_within_limits);
}

static const km_value *record_of(const answer *a, km_arena *arena) {
  const km_all_modes *m = &a->modes;
  km_value *record = km_record_head(a->pose->mechanism, "kspace", a->o->model, arena);
  km_value *held = km_value_add(arena, record, "held", KM_OBJECT);
  for (int i = 0; i < a->locked_count; ++i)
    km_value_number(arena, held, km_model_coordinate_label(a->pose->model, a->locked[i]),
                    km_state_coordinate(a->pose->state, a->locked[i]));
  km_value_boolean(arena, record, "complete", m->is_complete);
  if (!m->is_complete)
    km_value_string(arena, record, "reason", km_mode_gap_name(m->gap));
  km_value_number(arena, record, "complex_solutions", m->complex_solutions);
  km_value_number(arena, record, "section_points", m->section_points);
  km_value_number(arena, record, "trace_difference", m->trace_difference);
  km_value_number(arena, record, "estimate", m->estimate);
  km_value_number(arena, record, "samples", m->samples);
  km_value_number(arena, record, "found_once", m->found_once);
  km_value_number(arena, record, "infinite", m->infinite);
  km_value_number(arena, record, "singular", m->singular);
  km_value_number(arena, record, "outside_limits", m->outside);
  if (a->circuits.count > 0)
    km_value_number(arena, record, "circuits", a->circuits.count);
  if (a->circuits.gap)
    km_value_string(arena, record, "circuits_reason", km_circuit_gap_name(a->circuits.gap));
  km_value *list = km_value_add(arena, record, "modes", KM_LIST);
  for (int i = 0; i < m->count && !arena->failed; ++i)
    add_mode(a, i, list, arena);
  return record;
}

/* ---- CSV. */

static kt_exit add_table(const answer *a, km_text *out) {
  const km_all_modes *m = &a->modes;
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_table *table = km_table_create();
  km_text name = {0};
  bool is_ok = table && km_table_add_column(table, "mode", "") >= 0;
  for (int c = 0; is_ok && c < 2 * coordinates; ++c) {
    bool is_number = c >= coordinates;
    name.size = 0;
    km_text_format(&name, "%s.%s", is_number ? "m" : "q", km_model_coordinate_label(a->pose->model, c % coordinates));
    is_ok = !name.failed &&
            km_table_add_column(table, name.data, is_number ? "" : km_model_coordinate_unit(a->pose->model, c)) >= 0;
  }
  static const char *const figures[] = {"dof",      "certified", "kantorovich", "error_bound",   "radius",
                                        "residual", "singular",  "moves",       "within_limits", "circuit"};
  for (size_t k = 0; is_ok && k < sizeof figures / sizeof *figures; ++k)
    is_ok = km_table_add_column(table, figures[k], "") >= 0;
  for (int i = 0; is_ok && i < m->count; ++i) {
    const km_mode_evidence *e = &m->evidence[i];
    double *row = km_table_add_row(table);
    is_ok = row != NULL;
    if (!is_ok)
      break;
    *row++ = i + 1;
    for (int c = 0; c < coordinates; ++c)
      *row++ = m->coordinates[i * coordinates + c];
    for (int c = 0; c < coordinates; ++c)
      *row++ = m->mobility_numbers[i * coordinates + c];
    const double rest[] = {e->mobility,         e->is_certified,
                           e->kantorovich,      e->error_bound,
                           e->radius,           e->residual,
                           e->is_singular,      e->moves,
                           e->is_within_limits, a->circuits.count > 0 ? a->circuits.circuit[i] : nan("")};
    for (size_t k = 0; k < sizeof rest / sizeof *rest; ++k)
      *row++ = rest[k];
  }
  size_t size = is_ok ? km_table_csv(table, NULL, 0) : 0;
  char *bytes = is_ok && size > 0 ? KM_NEW(char, size + 1) : NULL;
  is_ok = bytes && km_table_csv(table, bytes, size + 1) == size;
  if (is_ok)
    km_text_add(out, bytes);
  is_ok = is_ok && !out->failed;
  km_free(bytes);
  km_text_free(&name);
  km_table_free(table);
  return is_ok ? KT_DONE : KT_NO_MEMORY;
}

/* ---- The command. */

/* Notes what the list leaves out. */
static void report_parts(const answer *a) {
  int parts = 0;
  km_substructure_mobility part;
  for (int i = 0; i < km_substructure_count(a->pose->mechanism); ++i) {
    km_substructure_evidence(a->pose->mechanism, a->pose->state, i, &part);
    parts += part.loops > 0 && i != a->modes.substructure;
  }
  if (parts > 0)
    kt_print_message(&a->o->common, KM_NOTE,
                     "%s: %d other part%s of the mechanism close%s by %s: their modes aren't listed; name one of their "
                     "joints by --set",
                     a->o->model, parts, parts == 1 ? "" : "s", parts == 1 ? "s" : "",
                     parts == 1 ? "itself" : "themselves");
}

static kt_exit write_answer(const answer *a, km_arena *arena) {
  static const char *const endings[] = {"txt", "json", "csv"};
  km_text out = {0};
  kt_exit result = KT_DONE;
  if (a->o->format == CSV)
    result = add_table(a, &out);
  else if (a->o->format == TABLE)
    print_modes(a, &out);
  else
    km_json_write(record_of(a, arena), &out);
  if (result == KT_DONE && arena->failed)
    result = KT_NO_MEMORY;
  if (result == KT_DONE)
    result = a->o->base ? kt_write(&a->o->common, a->o->base, "modes", endings[a->o->format], &out)
                        : kt_print(&a->o->common, &out);
  km_text_free(&out);
  return result;
}

static kt_exit run(const options *o, const kt_pose *pose) {
  answer a = {.o = o, .pose = pose};
  km_arena arena = {0};
  km_error error;
  kt_exit result = choose_locked(&a, &arena);
  if (result == KT_DONE) {
    const km_all_modes_def def = {
        .locked = a.locked, .locked_count = a.locked_count, .within_limits = o->limits, .seed = o->common.seed};
    kt_progress progress = kt_progress_start(&o->common);
    km_status status =
        km_all_modes_find(pose->mechanism, pose->state, &def, kt_progress_show, &progress, &a.modes, &error);
    if (!status)
      status = km_mode_circuits_find(pose->mechanism, pose->state, &def, &a.modes, kt_progress_show, &progress,
                                     &a.circuits, &error);
    kt_progress_end(&progress);
    if (status)
      kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
    result = kt_exit_of(status);
  }
  if (result == KT_DONE) {
    report_parts(&a);
    result = write_answer(&a, &arena);
  }
  if (result == KT_DONE && !a.modes.is_complete)
    result = KT_PARTIAL;
  km_mode_circuits_free(&a.circuits);
  km_all_modes_free(&a.modes);
  km_arena_free(&arena);
  return result;
}

kt_exit kspace_modes(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      KT_SET(&o.sets, "Move a joint to a value and keep it there; the loops follow"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      {"limits", 0, NULL, "List modes within the joint limits only", KT_FLAG, &o.limits, KT_ABOUT_MODEL},
      {"format", 0, "FORMAT", "table (default), json or csv", KT_WORD("table or json or csv"), &o.format,
       KT_ABOUT_FILES},
      KT_BASE(&o.base, "Write BASE.modes.txt, .json or .csv instead of the standard output"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED);
  kt_options_read(
      &all,
      "All assembly modes: every configuration that closes the loops with the joints of --set and --hold where they "
      "are, else with the driver of the model's analysis.sweep. A structure needs neither."
      "\vThe closure errors are followed over the complex numbers until the trace test shows that no solution is "
      "missing. Each real one is a mode; a proof (Newton-Kantorovich) states within which distance there is one "
      "solution, and no other. Modes are told apart by the places of the bodies, without the halves of struts. The first "
      "mode is the pose itself. Modes that the mechanism's motion connects, with the joints of --set free, are one circuit; "
      "other circuits can't be reached without taking it apart. Limits are ignored there, and with several freedoms circuits "
      "aren't answered. Exit status 1: the list may lack modes, or bodies move although the joints stay. "
      "JSON keys beside those of every record: held, complete, reason (trace, lost, singular, self-motion, limit), "
      "complex_solutions, section_points, trace_difference, estimate, samples, found_once, infinite, singular, "
      "outside_limits, circuits, circuits_reason (freedoms, self-motion, ball, lost), modes (circuit, configuration, residual, certified, kantorovich, error_bound, radius, mobility, "
      "mobility_numbers, singular, moves, within_limits).",
      argc, argv);
  kt_pose pose;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
