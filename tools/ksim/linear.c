/* ksim linearise and ksim equilibrium: small motions about a pose, and poses at rest. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/inspect.h"
#include "kmech/report.h"

#include <string.h>

typedef struct options {
  kt_common common;
  kt_texts holds, sets;
  const char *model, *base;
  int json;
  bool settle, matrices, animate;
  int only; /* the mode that is shown, a line of the table; 0: all */
} options;

typedef struct work {
  const options *o;
  kt_pose pose;
  km_forces *forces;
  km_dynamics *dynamics;
  km_linear linear;
  const char *base; /* base name of the files: -o, otherwise that of the model */
  char name[256];   /* the model's */
} work;

/* Friction has no slope to linearise where nothing slides. */
static void report_friction(const kt_common *common, const char *path, const km_model *model) {
  const char *first = km_model_first_friction(model);
  if (first)
    kt_print_message(
        common, KM_NOTE,
        "%s: friction, such as that of \"%s\", doesn't count at rest and in small motions; it does in ksim run and ksim "
        "inverse",
        path, first);
}

static void print_gravity(const km_model *model, km_text *out) {
  km_text_add(out, "  ");
  km_gravity_words(model, NULL, out);
  km_text_add(out, "\n");
}

static kt_exit open_work(work *w) {
  const options *o = w->o;
  km_error error;
  kt_base_name(o->model, w->name, sizeof w->name);
  w->base = o->base ? o->base : w->name;
  kt_exit result = kt_open(&o->common, o->model, &o->holds, &o->sets, &w->pose);
  if (result != KT_DONE)
    return result;
  report_friction(&o->common, o->model, w->pose.model);
  km_status status = km_forces_create_own(w->pose.mechanism, &w->forces, &error);
  if (!status)
    status = km_dynamics_create(w->pose.mechanism, w->forces, &w->dynamics, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  return kt_exit_of(status);
}

static void close_work(work *w) {
  km_linear_free(&w->linear);
  km_dynamics_free(w->dynamics);
  km_forces_free(w->forces);
  kt_close(&w->pose);
}

static kt_exit linearise(work *w) {
  km_error error;
  km_status status = km_linearise(w->dynamics, w->pose.state, &w->linear, &error);
  if (status)
    kt_print_message(&w->o->common, KM_ERROR, "%s: %s", w->o->model, error.text);
  return kt_exit_of(status);
}

/* JSON, or the table after its first lines. */
static kt_exit answer(const work *w, const char *tool, const char *result_word, km_text *lines) {
  const options *o = w->o;
  km_text json = {0};
  if (o->json) {
    km_arena arena = {0};
    const km_value *record = km_linear_record(w->pose.mechanism, w->pose.state, &w->linear, tool, o->model, &arena);
    if (record)
      km_json_write(record, &json);
    json.failed = json.failed || !record;
    km_arena_free(&arena);
  } else {
    km_linear_print(w->pose.mechanism, &w->linear, lines);
  }
  const km_text *out = o->json ? &json : lines;
  kt_exit result =
      o->base ? kt_write(&o->common, o->base, result_word, o->json ? "json" : "txt", out) : kt_print(&o->common, out);
  km_text_free(&json);
  return result;
}

static kt_exit write_matrix(const work *w, const char *base, const char *word, const double *matrix, int rows,
                            int columns) {
  km_text out = {0};
  km_matrix_csv(matrix, rows, columns, &out);
  kt_exit result = kt_write(&w->o->common, base, word, "csv", &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_matrices(const work *w) {
  const options *o = w->o;
  const km_linear *l = &w->linear;
  const char *base = w->base;
  km_text mat = {0};
  kt_exit result = write_matrix(w, base, "A", l->A, 2 * l->freedom, 2 * l->freedom);
  result = kt_worse(result, write_matrix(w, base, "B", l->B, 2 * l->freedom, l->coordinate_count));
  km_linear_mat(l, &mat);
  result = kt_worse(result, kt_write(&o->common, base, "linear", "mat", &mat));
  km_text_free(&mat);
  return result;
}

static kt_exit animate(const work *w) {
  const options *o = w->o;
  return ksim_animate_modes(&(ksim_modes){&o->common, o->model, w->base, &w->pose, w->dynamics, &w->linear, o->only});
}

static kt_exit run_linearise(work *w) {
  kt_exit result = open_work(w);
  if (result == KT_DONE)
    result = linearise(w);
  if (result != KT_DONE)
    return result;
  km_text lines = {0};
  km_stability stability = km_linear_stability(&w->linear);
  km_text_format(&lines, "%s: %d freedom%s about this pose, %s%s\n", w->o->model, w->linear.freedom,
                 w->linear.freedom == 1 ? "" : "s", stability == KM_NOT_AT_REST ? "which is " : "",
                 km_stability_name(stability));
  print_gravity(w->pose.model, &lines);
  if (stability == KM_NOT_AT_REST)
    kt_print_message(
        &w->o->common, KM_NOTE,
        "%s: the pose isn't at rest, so that nothing is said of its stability: its joints accelerate by up to %.3g (radians or "
        "characteristic lengths over s²); ksim equilibrium finds one that is",
        w->o->model, w->linear.residual);
  result = answer(w, "ksim linearise", "linear", &lines);
  km_text_free(&lines);
  if (w->o->matrices)
    result = kt_worse(result, write_matrices(w));
  return w->o->animate ? kt_worse(result, animate(w)) : result;
}

static kt_exit run_equilibrium(work *w) {
  const options *o = w->o;
  km_error error;
  kt_exit result = open_work(w);
  if (result != KT_DONE)
    return result;
  kt_progress progress = kt_progress_start(&o->common);
  km_status status = km_equilibrium_find(w->dynamics, w->pose.state, o->settle, kt_progress_show, &progress, &error);
  kt_progress_end(&progress);
  if (status) {
    const char *way = o->settle ? "; --set starts from another pose" : "; --settle lets it fall to one first";
    kt_print_message(&o->common, KM_ERROR, "%s: %s%s", o->model, error.text, status == KM_NO_RESULT ? way : "");
    return status == KM_NO_RESULT ? KT_PARTIAL : kt_exit_of(status);
  }
  result = linearise(w);
  if (result != KT_DONE)
    return result;
  const km_model *model = w->pose.model;
  km_text lines = {0};
  km_text_format(&lines, "%s: at rest, %s\n", o->model, km_stability_name(km_linear_stability(&w->linear)));
  print_gravity(model, &lines);
  for (int c = 0; c < km_model_coordinate_count(model); ++c)
    km_text_format(&lines, "  %-14s %.9g %s\n", km_model_coordinate_label(model, c),
                   km_state_coordinate(w->pose.state, c), km_model_coordinate_unit(model, c));
  km_text_add(&lines, "\n");
  result = answer(w, "ksim equilibrium", "rest", &lines);
  km_text_free(&lines);
  return result;
}

static void read_options(options *o, bool linear, int argc, char **argv) {
  kt_options all = {.operand = {"model", "MODEL", true, &o->model, NULL}};
  const kt_option shared[] = {
      KT_SET(&o->sets, linear ? "Move a joint to a value; the loops follow" : KT_SET_FIRST),
      KT_HOLD(&o->holds, KT_HOLD_RIGID),
      KT_MODE(o->common),
      KT_POSE(o->common),
      {"format", 0, "FORMAT", "table (default) or json", KT_WORD("table or json"), &o->json, KT_ABOUT_FILES},
  };
  const kt_option of_linear[] = {
      {"matrices", 0, NULL, "Write BASE.A.csv, BASE.B.csv and BASE.linear.mat (MATLAB, level 4) too", KT_FLAG,
       &o->matrices, KT_ABOUT_FILES},
      {"animate", 0, NULL, "Write BASE.mode1.html … too, which play the modes, by the lines of the table", KT_FLAG,
       &o->animate, KT_ABOUT_FILES},
      {"only", 0, "LINE", "Animate the mode of this line of the table alone", KT_COUNT, &o->only, KT_ABOUT_FILES},
      KT_BASE(&o->base, "Write BASE.linear.txt or .json instead of the standard output"),
  };
  const kt_option of_rest[] = {
      {"settle", 0, NULL,
       "Let the mechanism fall first, from every pose that isn't stable: the pose is then a stable one", KT_FLAG,
       &o->settle, KT_ABOUT_METHOD},
      KT_BASE(&o->base, "Write BASE.rest.txt or .json instead of the standard output"),
  };
  KT_OPTIONS_ADD(&all, shared);
  if (linear)
    KT_OPTIONS_ADD(&all, of_linear);
  else
    KT_OPTIONS_ADD(&all, of_rest);
  kt_common_options(&all, &o->common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      linear
          ? "The equations of motion, linearised about a pose: state matrices, natural frequencies, "
            "damping and modes."
            "\vx holds the deviations of the independent coordinates and then those of their rates, f the "
            "forces in all coordinates: dx/dt = A x + B f, in radians and the model's length, force and "
            "time units. N tells how all coordinates follow the independent ones."
          : "A pose at rest under gravity, loads, springs, contacts and stops, near the pose that it "
            "starts from; whether it is stable, and how the mechanism swings about it. Exit status 1 if none is found.",
      argc, argv);
}

kt_exit ksim_linearise(int argc, char **argv) {
  options o = {.common = KT_COMMON("ksim")};
  read_options(&o, true, argc, argv);
  if (o.only && !o.animate) {
    kt_print_message(&o.common, KM_ERROR, "--only %d: expected --animate with it", o.only);
    return KT_USAGE;
  }
  if (kt_is_piped(o.base) && (o.matrices || o.animate))
    return kt_usage(&o.common, "-o", "-", "a name, as --matrices and --animate write several files");
  work w = {.o = &o};
  kt_exit result = run_linearise(&w);
  close_work(&w);
  return result;
}

kt_exit ksim_equilibrium(int argc, char **argv) {
  options o = {.common = KT_COMMON("ksim")};
  read_options(&o, false, argc, argv);
  work w = {.o = &o};
  kt_exit result = run_equilibrium(&w);
  close_work(&w);
  return result;
}
