/* Report about the best tracks of several studies, or of variants of one: which figures differ and by how much, the
 * curves that differ most, then each study briefly. */
#include "arm/tracking/joint_course.h"
#include "base/arguments.h"
#include "report/charts/track_plot.h"
#include "report/document/comparison/comparison_page.h"
#include "report/document/sweep_report.h"
#include "report/document/track_report.h"
#include "topology/mechanism.h"

#include <math.h>

enum { DRAWING = 230 };

typedef struct comparison {
  const km_tracks **items; /* [count] with a track of more than one row */
  const char **names;
  int count;
  const char *missing; /* names of those without a track; NULL: none */
} comparison;

static const km_track *best_of(const km_tracks *tracks) {
  return tracks->items[km_tracks_best(tracks)];
}

/* Figures of the best track. */
static void list_figures(km_document_maker *k, const km_tracks *tracks, km_compared_figures *out) {
  const km_track *t = best_of(tracks);
  const km_track_summary *s = &t->summary;
  const int limiting = km_limiting_joint(t), fastest = km_fastest_joint(t);
  const km_units *u = &t->arm->mechanism->model->units;
  double manipulability = nan("");
  km_table_figure(t->table, "objective.manipulability", KM_FIGURE_MIN, 0.0, &manipulability, NULL, NULL);
  const km_compared_figure figures[] = {
      {"part of the path that is followed", "%", km_track_part(t), KM_BETTER_MORE, NULL, false},
      {"least margin to a limit", "%", limiting < 0 ? nan("") : 100.0 * km_joint_course_find(t, limiting).margin,
       KM_BETTER_MORE, "limit_margin", false},
      {"largest part of a drive's rate", "%",
       fastest < 0 ? nan("") : 100.0 * km_joint_course_find(t, fastest).rate_part, KM_BETTER_LESS, NULL, false},
      {"largest joint rate", "rad/s", s->rate, KM_BETTER_LESS, NULL, false},
      {"joint travel", "rad", s->joint_travel, KM_BETTER_LESS, NULL, false},
      {"least manipulability", "", manipulability, KM_BETTER_MORE, "objective.manipulability", false},
      {"energy", km_document_format(k, "%s·%s", u->force->suffix, u->length->suffix), s->energy, KM_BETTER_LESS, NULL,
       false},
  };
  for (size_t i = 0; i < sizeof figures / sizeof *figures; ++i)
    if (isfinite(figures[i].value))
      km_compared_add(out, figures[i]);
}

/* Keeps the studies that have a track. KM_USAGE: none has, or one isn't whole. */
static km_status choose(km_document_maker *k, const km_tracks *tracks, const char *const *names, int count,
                        comparison *out, km_error *error) {
  *out = (comparison){.items = KM_ARENA_NEW(&k->arena, const km_tracks *, (size_t)count),
                      .names = KM_ARENA_NEW(&k->arena, const char *, (size_t)count)};
  km_text missing = {0};
  if (k->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  for (int i = 0; i < count; ++i) {
    km_text none = {0};
    if (km_check_tracks(&tracks[i], true, KM_PICTURE_SVG, &none, NULL)) {
      km_text_format(&missing, "%s%s", missing.size ? ", " : "", names[i]);
      continue;
    }
    out->items[out->count] = &tracks[i];
    out->names[out->count++] = names[i];
  }
  out->missing = km_document_words(k, &missing, NULL);
  return out->count ? KM_OK : km_fail(error, KM_USAGE, "there is no track to report");
}

static void add_page(km_document_maker *k, const comparison *c, bool ordered) {
  km_compared_figures *figures = KM_ARENA_NEW(&k->arena, km_compared_figures, (size_t)c->count);
  km_compared_table *tables = KM_ARENA_NEW(&k->arena, km_compared_table, (size_t)c->count);
  for (int i = 0; i < c->count && figures && tables; ++i) {
    const km_table *t = best_of(c->items[i])->table;
    list_figures(k, c->items[i], &figures[i]);
    tables[i] = (km_compared_table){c->names[i], t, km_table_find(t, "s")};
  }
  if (k->arena.failed)
    return;
  const km_compared_rows rows = km_compared_merge(k, figures, c->count);
  if (!rows.items)
    return;
  km_comparison_page_add(k, c->names, c->count, ordered ? "variant" : "study", ordered ? "variants" : "studies", &rows);
  if (c->missing)
    km_document_text(k, km_document_format(k, "Without a track, and left out: %s.", c->missing));
  km_comparison_curves_add(k, tables, c->count, ordered, &rows,
                           km_document_format(k, "s: travel, and turns times L (%s)",
                                              best_of(c->items[0])->arm->mechanism->model->units.length->suffix));
}

/* Adds a part for each study: its summary and the arm along the path. */
static km_status add_parts(km_document_maker *k, const comparison *c, km_error *error) {
  for (int i = 0; i < c->count; ++i) {
    km_drawing_def *drawing = KM_ARENA_NEW(&k->arena, km_drawing_def, 1);
    if (!drawing)
      return km_fail(error, KM_MEMORY, "out of memory for a report");
    const km_status status = km_tracks_drawing_make(c->items[i], KM_TRACK_POSES, &k->arena, drawing, error);
    if (status)
      return status;
    km_document_part(k, c->names[i]);
    km_tracks_summary_add(k, c->items[i]);
    km_document_heading(k, "The arm along the path");
    km_report_drawing(k, drawing, "the arm in poses along the path, with the effector's path", DRAWING);
  }
  return KM_OK;
}

km_status km_tracks_comparison_report(const km_tracks *tracks, const char *const *names, int count, const char *name,
                                      bool ordered, const km_report_header *header, bool html, km_text *out,
                                      km_error *error) {
  km_status status = km_check_given(tracks && names && count > 0 && name && out, "tracks, name or place", error);
  if (status)
    return status;
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  comparison c;
  if (!k)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  status = choose(k, tracks, names, count, &c, error);
  if (!status) {
    add_page(k, &c, ordered);
    status = add_parts(k, &c, error);
  }
  if (!status)
    return km_report_finish(
        k, name, header, "kredund",
        km_document_format(k, ordered ? "%s: %d variants compared" : "%s: %d studies compared", name, c.count), html,
        out, error);
  km_arena_free(&k->arena);
  km_free(k);
  return status;
}
