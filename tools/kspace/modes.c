/* kspace modes: all assembly modes with their evidence, circuits, leverage and drawings. */
#include "kspace/kspace.h"
#include "kspace/modes_answer.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"

#include <math.h>

/* ---- The locked joints. */

/* Moves the pose to the values, as far as the loops follow. Where they don't, the joints get the values and the loops
 * are open: the search closes them. */
static kt_exit take_values(const kspace_modes_answer *a, const kt_settings *sets, km_arena *arena) {
  const kt_pose *pose = a->pose;
  km_error error;
  km_hold *goals = KM_ARENA_NEW(arena, km_hold, (size_t)sets->count + 1);
  double *values = KM_ARENA_NEW(arena, double, (size_t)km_model_coordinate_count(pose->model));
  if (arena->failed)
    return KT_NO_MEMORY;
  for (int i = 0; i < sets->count; ++i)
    goals[i] = (km_hold){sets->items[i].coordinate, sets->items[i].value};
  km_status status = km_state_move_to(pose->mechanism, pose->state, goals, sets->count, &error);
  if (status == KM_NO_RESULT) {
    for (int c = 0; c < km_model_coordinate_count(pose->model); ++c)
      values[c] = km_state_coordinate(pose->state, c);
    for (int i = 0; i < sets->count; ++i)
      values[goals[i].coordinate] = goals[i].value;
    status = km_state_set_coordinates(pose->mechanism, pose->state, values, &error);
  }
  if (status)
    kt_print_message(&a->o->common, KM_ERROR, "%s: %s", a->o->model, error.text);
  return kt_exit_of(status);
}

/* Locks the joints of --set at their values; without any, the driver of analysis.sweep if it can move. */
static kt_exit choose_locked(kspace_modes_answer *a, km_arena *arena) {
  const km_model *model = a->pose->model;
  kt_settings sets = {0};
  kt_exit result =
      kt_settings_add(&a->o->common, model, "--set", (char **)(size_t)a->o->sets.items, a->o->sets.count, &sets);
  a->locked = KM_ARENA_NEW(arena, int, (size_t)sets.count + 1);
  if (result == KT_DONE && !a->locked)
    result = KT_NO_MEMORY;
  if (result == KT_DONE && sets.count > 0)
    result = take_values(a, &sets, arena);
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

/* ---- Leverage and drawing of each mode. */

/* Computes the leverage at the state's configuration. A port that can't move has none. */
static km_status compute_leverage(kspace_modes_answer *a, km_state *state, km_advantage *out, km_error *error) {
  km_transfer *lever;
  km_mobility mobility;
  *out = (km_advantage){.state = KM_ADVANTAGE_UNDEFINED, .value = nan("")};
  km_status status = km_transfer_create(a->pose->mechanism, &a->input, &a->output, &lever, error);
  if (status) {
    a->has_leverage = false;
    return status == KM_MEMORY ? status : KM_OK;
  }
  status = km_mobility_compute(a->pose->mechanism, state, &mobility);
  if (!status)
    status = km_transfer_compute(a->pose->mechanism, state, lever, out);
  km_transfer_free(lever);
  return status ? km_fail(error, status, "out of memory for the leverage") : KM_OK;
}

/* Moves a state of its own to each mode, and computes what the answer needs there. */
static km_status visit_modes(kspace_modes_answer *a, km_arena *arena, km_error *error) {
  const km_mechanism *mechanism = a->pose->mechanism;
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_state *state = NULL;
  km_status status = km_state_create(mechanism, &state, error);
  a->has_leverage =
      km_port_default(a->pose->model, false, &a->input) && km_port_default(a->pose->model, true, &a->output);
  a->advantage = KM_ARENA_NEW(arena, km_advantage, (size_t)a->modes.count + 1);
  if (!status && !a->advantage)
    status = km_fail(error, KM_MEMORY, "out of memory");
  if (!status && a->o->format >= KSPACE_SVG)
    status = km_drawing_create(mechanism, &a->drawing, error);
  for (int i = 0; !status && i < a->modes.count; ++i) {
    km_assembly evidence;
    status = km_state_set_coordinates(mechanism, state, a->modes.coordinates + (size_t)i * (size_t)coordinates, error);
    if (!status)
      status = km_assemble(mechanism, state, &evidence, error);
    if (!status && a->has_leverage)
      status = compute_leverage(a, state, &a->advantage[i], error);
    if (!status && a->drawing) {
      km_poses_compute(mechanism, state);
      status = km_drawing_add_pose(a->drawing, mechanism, state, error);
    }
  }
  km_state_free(state);
  return status;
}

/* ---- The command. */

/* Notes what the list leaves out. */
static void report_parts(const kspace_modes_answer *a) {
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

static kt_exit write_answer(const kspace_modes_answer *a, km_arena *arena) {
  static const char *const endings[] = {"txt", "json", "csv", "svg", "pdf", "png"};
  km_text out = {0};
  kt_exit result = KT_DONE;
  km_error error;
  km_status drawn = a->o->format >= KSPACE_SVG ? kspace_add_picture(a, &out, arena, &error) : KM_OK;
  if (drawn)
    kt_print_message(&a->o->common, KM_ERROR, "%s: %s", a->o->model, error.text);
  result = kt_exit_of(drawn);
  if (a->o->format == KSPACE_CSV)
    result = kspace_add_table(a, &out);
  else if (a->o->format == KSPACE_TABLE)
    kspace_print_modes(a, &out);
  else if (a->o->format == KSPACE_JSON)
    km_json_write(kspace_modes_record(a, arena), &out);
  if (result == KT_DONE && arena->failed)
    result = KT_NO_MEMORY;
  if (result == KT_DONE)
    result = kt_write(&a->o->common, a->o->base ? a->o->base : "-", "modes", endings[a->o->format], &out);
  km_text_free(&out);
  return result;
}

/* Searches the modes and their circuits. After Ctrl-C the answer has the modes found so far. */
static kt_exit search(kspace_modes_answer *a) {
  const kspace_modes_options *o = a->o;
  const kt_pose *pose = a->pose;
  km_error error;
  const km_all_modes_def def = {
      .locked = a->locked, .locked_count = a->locked_count, .within_limits = o->limits, .seed = o->common.seed};
  kt_progress progress = kt_progress_start(&o->common);
  kt_interrupts_catch();
  km_status status = km_modes_and_circuits_find(pose->mechanism, pose->state, &def, kt_progress_show, &progress,
                                                &a->modes, &a->circuits, &error);
  kt_interrupts_release();
  kt_progress_end(&progress);
  bool is_stopped = status == KM_CANCELLED && a->modes.count > 0;
  if (status)
    kt_print_message(&o->common, is_stopped ? KM_NOTE : KM_ERROR, "%s: %s", o->model, error.text);
  return is_stopped ? KT_DONE : kt_exit_of(status);
}

static kt_exit run(const kspace_modes_options *o, const kt_pose *pose) {
  kspace_modes_answer a = {.o = o, .pose = pose};
  km_arena arena = {0};
  km_error error;
  kt_exit result = choose_locked(&a, &arena);
  if (result == KT_DONE)
    result = search(&a);
  if (result == KT_DONE) {
    km_status status = visit_modes(&a, &arena, &error);
    if (status)
      kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
    result = kt_exit_of(status);
  }
  if (result == KT_DONE) {
    report_parts(&a);
    result = write_answer(&a, &arena);
  }
  if (result == KT_DONE && (!a.modes.is_complete || a.circuits.gap == KM_CIRCUIT_GAP_STOPPED))
    result = KT_PARTIAL;
  km_drawing_free(a.drawing);
  km_mode_circuits_free(&a.circuits);
  km_all_modes_free(&a.modes);
  km_arena_free(&arena);
  return result;
}

kt_exit kspace_modes(int argc, char **argv) {
  kspace_modes_options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      KT_SET(&o.sets, "Move a joint to a value and keep it there"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      {"limits", 0, NULL, "List modes within the joint limits only", KT_FLAG, &o.limits, KT_ABOUT_MODEL},
      {"format", 0, "FORMAT", "table (default), json, csv, or a drawing of each mode: svg, pdf, png",
       KT_WORD("table or json or csv or svg or pdf or png"), &o.format, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Write BASE.modes.txt, .json, .csv, .svg … instead of the standard output"),
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
      "mode is the pose; where its loops don't follow to the values of --set, it is one found from random starts. Modes that the mechanism's motion connects, with the joints of --set free, are one circuit; "
      "other circuits can't be reached without taking it apart. Limits are ignored there, and with several freedoms circuits "
      "aren't answered. Exit status 1: the list may lack modes, modes belong to self-motions, or Ctrl-C ended the search: the modes found "
      "so far are listed; 2: too few joints are locked. "
      "JSON keys beside those of every record: held, complete, reason (trace, lost, singular, self-motion, limit, stopped), "
      "complex_solutions, section_points, trace_difference, estimate, samples, found_once, infinite, singular, "
      "outside_limits, circuits, circuits_reason (freedoms, self-motion, ball, lost, stopped), modes (circuit, configuration, residual, certified, kantorovich, error_bound, radius, mobility, "
      "mobility_numbers, mechanical_advantage, mechanical_advantage_state, singular, moves, within_limits), and input and "
      "output of the leverage, where the model's analysis.mechanical_advantage states them.",
      argc, argv);
  const kt_texts none = {0};
  kt_pose pose;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &none, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
