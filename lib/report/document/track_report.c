/* Report about the tracks of an arm along a path.
 *
 *   margin of a joint = min over the rows of min(q − low, high − q) / ((high − low) / 2); 1 in the middle, 0 at a limit
 *   rate of a joint   = max over the rows of |v|,  its part of the drive's limit
 *
 * The joint with the least margin limits the track. */
#include "kmech/report.h"

#include "report/charts/track_plot.h"
#include "report/document/sweep_report.h"
#include "topology/mechanism.h"

#include <math.h>

enum { PLOT = 170, DRAWING = 205 };

/* Course of one joint over the rows of a track. */
typedef struct joint_course {
  double least, greatest;         /* values, file's unit */
  double margin, margin_s;        /* least margin and its place; NaN: no limits */
  double rate, rate_s, rate_part; /* largest speed in file's units a second, its place; part of its limit or NaN */
} joint_course;

static double margin_of(const km_arm *a, int k, double value) {
  double q = km_arm_from_units(a, k, value), half = 0.5 * (a->high[k] - a->low[k]);
  return half < HUGE_VAL ? fmin(q - a->low[k], a->high[k] - q) / half : nan("");
}

static joint_course find_course(const km_track *t, int k) {
  size_t q = km_table_span(t->table, "q.").first + (size_t)k, v = km_table_span(t->table, "v.").first + (size_t)k;
  size_t s = (size_t)km_table_find(t->table, "s");
  joint_course out = {HUGE_VAL, -HUGE_VAL, nan(""), 0.0, -1.0, 0.0, nan("")};
  for (size_t r = 0; r < km_table_rows(t->table); ++r) {
    const double *row = km_table_row(t->table, r);
    double margin = margin_of(t->arm, k, row[q]);
    out.least = fmin(out.least, row[q]);
    out.greatest = fmax(out.greatest, row[q]);
    if (isfinite(margin) && !(out.margin <= margin)) {
      out.margin = margin;
      out.margin_s = row[s];
    }
    if (fabs(row[v]) > out.rate) {
      out.rate = fabs(row[v]);
      out.rate_s = row[s];
    }
  }
  if (t->arm->rate[k] < HUGE_VAL)
    out.rate_part = out.rate / km_arm_to_units(t->arm, k, t->arm->rate[k]);
  return out;
}

/* The joint with the least margin; −1: no joint has limits. */
static int find_limiting(const km_track *t) {
  int limiting = -1;
  double least = HUGE_VAL;
  for (int k = 0; k < t->arm->n; ++k) {
    double margin = find_course(t, k).margin;
    if (margin < least) {
      least = margin;
      limiting = k;
    }
  }
  return limiting;
}

/* The joint whose rate is the largest part of its limit; −1: no joint has a limit. */
static int find_fastest(const km_track *t) {
  int fastest = -1;
  double most = -1.0;
  for (int k = 0; k < t->arm->n; ++k) {
    double part = find_course(t, k).rate_part;
    if (part > most) {
      most = part;
      fastest = k;
    }
  }
  return fastest;
}

static const char *length_unit(const km_track *t) {
  return t->arm->mechanism->model->units.length->suffix;
}

static const char *unit_of(const km_track *t, int k) {
  return km_model_coordinate_unit(t->arm->mechanism->model, t->arm->coordinate[k]);
}

static const char *label_of(km_document_maker *k, const km_tracks *tracks, int index) {
  char label[64];
  km_tracks_label(tracks, index, ' ', label, sizeof label);
  return km_document_format(k, "%s", label);
}

static double part_reached(const km_track *t) {
  return 100.0 * t->end.s / km_path_length(t->plan.path, t->plan.path->samples - 1);
}

static void add_lead(km_document_maker *k, const km_tracks *tracks, int best) {
  const km_track *t = tracks->items[best];
  const km_path *path = t->plan.path;
  int limiting = find_limiting(t), fastest = find_fastest(t);
  km_text text = {0};
  if (t->end.stop == KM_TRACK_COMPLETE) {
    km_text_format(&text, "%s follows the whole path in %.4g s", label_of(k, tracks, best),
                   km_path_time(path, path->samples - 1));
  } else {
    km_text_format(&text, "%s follows %.1f %% of the path and ", label_of(k, tracks, best), part_reached(t));
    km_track_end_text(t, &text);
  }
  if (limiting >= 0) {
    joint_course course = find_course(t, limiting);
    km_text_format(&text, ". %s comes nearest to a limit: %.3g %% of half its range are left at s = %.4g %s",
                   km_arm_label(t->arm, limiting), fabs(100.0 * course.margin) < 1e-6 ? 0.0 : 100.0 * course.margin,
                   course.margin_s, length_unit(t));
  }
  if (fastest >= 0) {
    joint_course course = find_course(t, fastest);
    km_text_format(&text, ". %s is the fastest of its drive: %.3g %% of its largest rate",
                   km_arm_label(t->arm, fastest), 100.0 * course.rate_part);
  }
  km_text_add(&text, ".");
  km_document_lead(k, km_document_words(k, &text, ""));
}

static void add_facts(km_document_maker *k, const km_tracks *tracks, const km_track *t) {
  static const char *const tasks[] = {"position and rotation", "position", "position and axis"};
  const km_path *path = t->plan.path;
  const km_model *model = t->arm->mechanism->model;
  const km_model_frame *frame = &model->frames[t->arm->frame];
  const km_units *u = &model->units;
  km_report_facts facts = {.rows = 0};
  km_report_fact(&facts, "Path",
                 km_document_format(k, "%.6g %s and %.6g %s in %.6g s, %d samples",
                                    km_path_travel(path, path->samples - 1), u->length->suffix,
                                    km_path_turn(path, path->samples - 1) / u->angle->si, u->angle->suffix,
                                    km_path_time(path, path->samples - 1), path->samples));
  km_report_fact(
      &facts, "Effector",
      km_document_format(k, "%s of %s: %s", frame->name, model->bodies[frame->body].name, tasks[t->arm->task]));
  km_report_fact(&facts, "Arm", km_document_format(k, "%d joints, %d to spare", t->arm->n, t->arm->freedom));
  km_report_fact(&facts, "Objective", km_objective_name(&tracks->study->objective));
  km_report_fact(&facts, "Largest errors",
                 km_document_format(k, "%.2g %s, %.2g %s", t->summary.error_position, u->length->suffix,
                                    t->summary.error_rotation, u->angle->suffix));
  if (isfinite(t->summary.energy))
    km_report_fact(&facts, "Energy",
                   km_document_format(k, "%.5g %s·%s, positive work %.5g %s·%s", t->summary.energy, u->force->suffix,
                                      u->length->suffix, t->summary.positive_work, u->force->suffix,
                                      u->length->suffix));
  km_report_close_facts(k, &facts);
}

/* Range, margin and rate of each joint. */
static void add_joints(km_document_maker *k, const km_track *t) {
  enum { COLUMNS = 6 };
  static const char *const heads[COLUMNS] = {"joint",        "range",        "limits",
                                             "least margin", "largest rate", "of its limit"};
  size_t joints = (size_t)t->arm->n, columns = find_fastest(t) < 0 ? COLUMNS - 1 : COLUMNS;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (joints + 1) * columns);
  if (!cells)
    return;
  for (size_t c = 0; c < columns; ++c)
    cells[c] = heads[c];
  for (int j = 0; j < t->arm->n; ++j) {
    const km_arm *a = t->arm;
    joint_course course = find_course(t, j);
    const char **row = cells + columns * ((size_t)j + 1), *unit = unit_of(t, j);
    bool limited = isfinite(course.margin);
    row[0] = km_arm_label(a, j);
    row[1] = km_document_format(k, "%.4g to %.4g %s", course.least, course.greatest, unit);
    row[2] = limited ? km_document_format(k, "%.4g to %.4g", km_arm_to_units(a, j, a->low[j]),
                                          km_arm_to_units(a, j, a->high[j]))
                     : "–";
    row[3] = limited
                 ? km_document_format(k, "%.3g %% at %.4g %s", fabs(course.margin) < 1e-8 ? 0.0 : 100.0 * course.margin,
                                      course.margin_s, length_unit(t))
                 : "–";
    row[4] = km_document_format(k, "%.4g %s/s at %.4g %s", course.rate, unit, course.rate_s, length_unit(t));
    if (columns == COLUMNS)
      row[5] = isfinite(course.rate_part) ? km_document_format(k, "%.3g %%", 100.0 * course.rate_part) : "–";
  }
  km_document_heading(k, "Joints against their limits");
  km_document_text(k, "Margin: distance to the nearest limit over half the range. Places are lengths along the path.");
  km_document_cells(k, KM_BLOCK_TABLE, cells, joints + 1, columns);
}

/* A row for each method. */
static void add_methods(km_document_maker *k, const km_tracks *tracks) {
  enum { COLUMNS = 7 };
  const char *name = km_objective_name(&tracks->study->objective);
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (size_t)(tracks->count + 1) * COLUMNS);
  size_t rows = 1;
  if (!cells || tracks->count < 2)
    return;
  cells[0] = "method";
  cells[1] = "reached";
  cells[2] = km_document_format(k, "%s, least", name);
  cells[3] = "mean";
  cells[4] = "least margin";
  cells[5] = "joint travel";
  cells[6] = "largest rate";
  for (int i = 0; i < tracks->count; ++i) {
    const km_track *t = tracks->items[i];
    if (!t || km_table_rows(t->table) == 0)
      continue;
    const km_track_summary *s = &t->summary;
    const char **row = cells + COLUMNS * rows++;
    row[0] = label_of(k, tracks, i);
    row[1] = km_document_format(k, "%.1f %%", part_reached(t));
    row[2] = km_document_format(k, "%.4g", fabs(s->objective_min) < 1e-12 ? 0.0 : s->objective_min);
    row[3] = km_document_format(k, "%.4g", s->objective_mean);
    row[4] = km_document_format(k, "%.3g %%", fabs(s->limit_margin) < 1e-8 ? 0.0 : 100.0 * s->limit_margin);
    row[5] = km_document_format(k, "%.4g rad", s->joint_travel);
    row[6] = km_document_format(k, "%.4g rad/s", s->rate);
  }
  km_document_heading(k, "Methods side by side");
  km_document_cells(k, KM_BLOCK_TABLE, cells, rows, COLUMNS);
  for (int i = 0; i < tracks->count; ++i) {
    km_text why = {0};
    if (tracks->items[i] && tracks->items[i]->end.stop != KM_TRACK_COMPLETE) {
      km_text_format(&why, "%s ", label_of(k, tracks, i));
      km_track_end_text(tracks->items[i], &why);
      km_text_add(&why, ".");
      km_document_text(k, km_document_words(k, &why, ""));
    }
  }
}

static km_status add_pictures(km_document_maker *k, const km_tracks *tracks, km_error *error) {
  km_drawing_def *drawing = KM_ARENA_NEW(&k->arena, km_drawing_def, 1);
  km_plot plots[KM_TRACK_PLOTS];
  if (!drawing)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  km_status status = km_tracks_drawing_make(tracks, &k->arena, drawing, error);
  if (status)
    return status;
  km_document_heading(k, "The arm along the path");
  km_report_drawing(k, drawing, "the arm in poses along the path, with the effector's path", DRAWING);
  km_document_heading(k, "Over the path");
  size_t count = km_tracks_plots_make(tracks, false, &k->arena, plots);
  for (size_t i = 0; i < count; ++i)
    km_report_plot(k, &plots[i], plots[i].title, PLOT);
  return KM_OK;
}

km_status km_tracks_report(const km_tracks *tracks, const km_report_header *header, bool html, km_text *out,
                           km_error *error) {
  km_status status = km_check_tracks(tracks, true, KM_PICTURE_SVG, out, error);
  if (status)
    return status;
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  if (!k)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  int best = km_tracks_best(tracks);
  const km_track *t = tracks->items[best];
  const km_swept swept = {.mechanism = t->arm->mechanism, .name = tracks->name};
  add_lead(k, tracks, best);
  add_facts(k, tracks, t);
  add_joints(k, t);
  add_methods(k, tracks);
  status = add_pictures(k, tracks, error);
  if (status) {
    km_arena_free(&k->arena);
    km_free(k);
    return status;
  }
  km_report_model(k, &swept,
                  "the effector follows the path exactly at every sample; spare freedoms as the method chooses");
  return km_report_finish(k, km_report_subject(k, swept.name, swept.mechanism->model), header, "kredund",
                          km_document_format(k, "%s: along its path", tracks->model), html, out, error);
}
