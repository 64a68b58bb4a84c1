/* The page that plays a drawing's poses, beside a plot. */
#include "base/arguments.h"
#include "base/memory.h"
#include "report/charts/chart.h"
#include "report/document/film_page.h"
#include "report/drawing/drawing_poses.h"
#include "report/drawing/film_drawing.h"
#include "report/plot/film_plot.h"

static const double plot_width = 300, plot_height = 236, panel_height = 118; /* points: letters fit a phone */

/* True if every curve has a row for each pose. */
static km_status check_chart(const km_plot *plot, size_t poses, km_error *error) {
  for (size_t p = 0; p < plot->panel_count; ++p)
    for (size_t i = 0; i < plot->panels[p].series_count; ++i)
      if (plot->panels[p].series[i].count != poses)
        return km_fail(error, KM_USAGE, "curves of %zu rows beside %zu poses; expected one for each pose",
                       plot->panels[p].series[i].count, poses);
  return KM_OK;
}

static km_status film_chart(const km_chart *chart, size_t poses, km_arena *arena, km_film *out, km_error *error) {
  km_plot plot = chart->plot;
  plot.title = plot.subtitle = NULL; /* the page has them, and the motion itself */
  plot.strip = (km_plot_strip){0};
  double height = plot.own_y ? panel_height * (double)plot.panel_count : plot_height;
  return km_plot_film(&plot, plot_width, height, poses, arena, out, error);
}

static km_status write_page(const km_film *const *films, size_t count, const km_motion_page *page, km_text *out,
                            km_error *error) {
  const char *alt[] = {"the mechanism in motion", page->chart_alt ? page->chart_alt : ""};
  km_film_page all = {.title = page->title ? page->title : "",
                      .subtitle = page->subtitle ? page->subtitle : "",
                      .footer = page->footer ? page->footer : "",
                      .films = films,
                      .alt = alt,
                      .film_count = count,
                      .quantity = page->quantity,
                      .unit = page->unit ? page->unit : "",
                      .values = page->values,
                      .stops = page->stops,
                      .stop_count = page->stop_count,
                      .closed = page->closed,
                      .seconds = page->seconds};
  return km_film_page_write(&all, out, error);
}

static km_status check_page(const km_motion_page *page, const km_text *out, km_error *error) {
  km_status status = km_check_given(page && out, "page or place for the result", error);
  if (!status)
    status = km_check_given(page->values && page->quantity, "values or quantity", error);
  if (!status && page->stop_count)
    status = km_check_given(page->stops != NULL, "stops", error);
  if (!status && !(page->seconds > 0.0 && isfinite(page->seconds)))
    status = km_fail(error, KM_USAGE, "%g seconds; expected more than 0", page->seconds);
  return status;
}

km_status km_drawing_page(const km_drawing *drawing, const km_drawing_look *look, const km_motion_page *page,
                          km_text *out, km_error *error) {
  km_arena arena = {0};
  km_drawing_def def = {0};
  km_film film = {0}, curves = {0};
  const km_film *const films[] = {&film, &curves};
  km_status status = check_page(page, out, error);
  if (!status)
    status = km_drawing_define(drawing, look, &def, error);
  if (!status && page->chart)
    status = check_chart(&page->chart->plot, def.pose_count, error);
  if (status)
    return status;
  def.loads = false; /* arrows that turn would cover the motion */
  status = km_drawing_film(&def, &arena, &film, error);
  if (!status && page->chart)
    status = film_chart(page->chart, def.pose_count, &arena, &curves, error);
  if (!status)
    status = write_page(films, page->chart ? 2 : 1, page, out, error);
  km_film_close(&film);
  km_film_close(&curves);
  km_arena_free(&arena);
  return status;
}
