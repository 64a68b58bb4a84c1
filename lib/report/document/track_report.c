/* Report about the tracks of an arm along a path.
 *
 *   margin of a joint = min over the rows of min(q − low, high − q) / ((high − low) / 2); 1 in the middle, 0 at a limit
 *   rate of a joint   = max over the rows of |v|,  its part of the drive's limit
 *
 * The joint with the least margin limits the track. */
#include "kmech/report.h"
#include "kmech/version.h"

#include "arm/tracking/joint_course.h"
#include "report/charts/track_plot.h"
#include "report/document/sweep_report.h"
#include "report/document/track_film.h"
#include "report/document/track_report.h"
#include "report/record/track_record.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>

enum { PLOT = 170, DRAWING = 205, STRIP = 90 };

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

static void add_lead(km_document_maker *k, const km_tracks *tracks, int best) {
  const km_track *t = tracks->items[best];
  const km_path *path = t->plan.path;
  km_text text = {0}, limits = {0};
  if (t->end.stop == KM_TRACK_COMPLETE) {
    km_text_format(&text, "%s follows the whole path in %.4g s", label_of(k, tracks, best),
                   km_path_time(path, path->samples - 1));
  } else {
    km_text_format(&text, "%s follows %.1f %% of the path and ", label_of(k, tracks, best), km_track_part(t));
    km_track_end_text(t, &text);
  }
  km_track_limits_words(t, &limits);
  if (limits.size)
    km_text_format(&text, ". %s", limits.data);
  km_text_free(&limits);
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
  size_t joints = (size_t)t->arm->n, columns = km_fastest_joint(t) < 0 ? COLUMNS - 1 : COLUMNS;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (joints + 1) * columns);
  if (!cells)
    return;
  for (size_t c = 0; c < columns; ++c)
    cells[c] = heads[c];
  for (int j = 0; j < t->arm->n; ++j) {
    const km_arm *a = t->arm;
    km_joint_course course = km_joint_course_find(t, j);
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
    row[1] = km_document_format(k, "%.1f %%", km_track_part(t));
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

/* Row of a joint's least margin or largest rate. */
static double row_at(const km_track *t, double place) {
  const size_t s = (size_t)km_table_find(t->table, "s");
  for (size_t r = 0; r < km_table_rows(t->table); ++r)
    if (km_table_row(t->table, r)[s] >= place)
      return (double)r;
  return 0.0;
}

/* Makes the film with the limiting and the fastest joint marked on its slider. */
static km_status make_film(const km_tracks *tracks, km_arena *arena, km_track_film *film, km_error *error) {
  const km_track *t = tracks->items[km_tracks_best(tracks)];
  const int limiting = km_limiting_joint(t), fastest = km_fastest_joint(t);
  char words[2][160];
  km_motion_stop stops[2];
  size_t count = 0;
  if (limiting >= 0) {
    snprintf(words[count], sizeof words[0], "%.100s is nearest to its limit", km_arm_label(t->arm, limiting));
    stops[count] =
        (km_motion_stop){row_at(t, km_joint_course_find(t, limiting).margin_s), km_arena_string(arena, words[count])};
    ++count;
  }
  if (fastest >= 0) {
    snprintf(words[count], sizeof words[0], "%.100s is the fastest of its drive", km_arm_label(t->arm, fastest));
    stops[count] =
        (km_motion_stop){row_at(t, km_joint_course_find(t, fastest).rate_s), km_arena_string(arena, words[count])};
    ++count;
  }
  return km_track_film_make(tracks, stops, count, arena, film, error);
}

km_status km_tracks_page(const km_tracks *tracks, km_text *out, km_error *error) {
  km_status status = km_check_tracks(tracks, true, KM_PICTURE_SVG, out, error);
  if (status)
    return status;
  km_arena arena = {0};
  km_track_film film = {.films = {NULL}};
  char label[64], subtitle[160];
  status = make_film(tracks, &arena, &film, error);
  km_tracks_label(tracks, km_tracks_best(tracks), ' ', label, sizeof label);
  snprintf(subtitle, sizeof subtitle, "along its path by the method %s", label);
  film.page.title = tracks->model;
  film.page.subtitle = subtitle;
  film.page.footer = "kredund " KM_VERSION;
  if (!status)
    status = km_film_page_write(&film.page, out, error);
  km_track_film_close(&film);
  km_arena_free(&arena);
  return status;
}

static km_status add_pictures(km_document_maker *k, const km_tracks *tracks, km_track_film *film, km_error *error) {
  km_drawing_def *drawing = KM_ARENA_NEW(&k->arena, km_drawing_def, 1);
  km_plot plots[KM_TRACK_PLOTS];
  if (!drawing)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  km_status status = km_tracks_drawing_make(tracks, KM_TRACK_POSES, &k->arena, drawing, error);
  if (status)
    return status;
  km_document_heading(k, "The arm along the path");
  status = make_film(tracks, &k->arena, film, error);
  if (status)
    return status;
  km_document_film(k, &film->page, "six configurations of the arm along its path", STRIP, km_track_film_strip, film);
  km_report_drawing(k, drawing, "the arm in poses along the path, with the effector's path", DRAWING);
  km_document_heading(k, "Over the path");
  size_t count = km_tracks_plots_make(tracks, false, &k->arena, plots);
  for (size_t i = 0; i < count; ++i)
    km_report_plot(k, &plots[i], plots[i].title, PLOT);
  return KM_OK;
}

void km_tracks_summary_add(km_document_maker *k, const km_tracks *tracks) {
  const int best = km_tracks_best(tracks);
  add_lead(k, tracks, best);
  add_facts(k, tracks, tracks->items[best]);
  add_joints(k, tracks->items[best]);
  add_methods(k, tracks);
}

/* Adds all blocks. */
static km_status make(km_document_maker *k, const km_tracks *tracks, const km_swept *swept, km_track_film *film,
                      km_error *error) {
  km_tracks_summary_add(k, tracks);
  const km_status status = add_pictures(k, tracks, film, error);
  if (!status)
    km_report_model(k, swept,
                    "the effector follows the path exactly at every sample; spare freedoms as the method chooses");
  return status;
}

km_status km_tracks_report(const km_tracks *tracks, const km_report_header *header, bool html, km_text *out,
                           km_error *error) {
  km_status status = km_check_tracks(tracks, true, KM_PICTURE_SVG, out, error);
  if (status)
    return status;
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  if (!k)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  const km_swept swept = {.mechanism = tracks->items[km_tracks_best(tracks)]->arm->mechanism, .name = tracks->name};
  km_track_film film = {.films = {NULL}};
  status = make(k, tracks, &swept, &film, error);
  if (!status) {
    status = km_report_finish(k, km_report_subject(k, swept.name, swept.mechanism->model), header, "kredund",
                              km_document_format(k, "%s: along its path", tracks->model), html, out, error);
  } else {
    km_arena_free(&k->arena);
    km_free(k);
  }
  km_track_film_close(&film);
  return status;
}
