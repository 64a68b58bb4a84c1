/* Writes pages on which films play: the first frame as SVG, the others as numbers for the script. */
#include "report/document/film_page.h"

#include "base/text.h"
#include "report/canvas/svg_path.h"
#include "report/document/escape.h"

#include <math.h>

static const double steps = 100; /* a point, and a degree, in the script's data */

static char prefix_of(size_t film) {
  return (char)('a' + film);
}

static void add_styles(const km_film_page *page, bool dark, km_text *out) {
  for (size_t k = 0; k < page->film_count; ++k)
    for (size_t i = 0; i < page->films[k]->style_count; ++i)
      km_text_format(out, ".%c%zu{%s}", prefix_of(k), i,
                     dark ? page->films[k]->styles[i].dark : page->films[k]->styles[i].light);
}

void km_film_styles_write(const km_film_page *page, km_text *out) {
  km_text_format(out, "%s\n", km_film_sheet);
  add_styles(page, false, out);
  km_text_add(out, "\n@media(prefers-color-scheme:dark){");
  add_styles(page, true, out);
  km_text_add(out, "}\n");
}

static void add_head(const km_film_page *page, km_text *out) {
  km_text_add(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
                   "content=\"width=device-width, initial-scale=1\">\n<title>");
  km_html_escape(page->title, out);
  km_text_format(out, "</title>\n<style>\n%s", km_film_page_sheet);
  km_film_styles_write(page, out);
  km_text_add(out, "</style>\n</head>\n<body>\n<h1>");
  km_html_escape(page->title, out);
  km_text_add(out, "</h1>\n<p class=\"about\">");
  km_html_escape(page->subtitle, out);
  km_text_add(out, "</p>\n");
}

static void add_attribute(km_text *out, const char *name, double value) {
  km_text_format(out, " %s=\"", name);
  km_svg_number(out, value, 2);
  km_text_add(out, "\"");
}

static void add_text(char prefix, const km_film_shape *s, km_text *out) {
  km_text_format(out, "<text class=\"%c%d\"", prefix, s->style);
  add_attribute(out, "x", s->x);
  add_attribute(out, "y", s->y);
  if (s->length > 0.0)
    add_attribute(out, "textLength", s->length);
  if (s->angle != 0.0) {
    km_text_add(out, " transform=\"rotate(");
    km_svg_number(out, s->angle * 180.0 / M_PI, 2);
    km_text_add(out, " ");
    km_svg_number(out, s->x, 2);
    km_text_add(out, " ");
    km_svg_number(out, s->y, 2);
    km_text_add(out, ")\"");
  }
  km_text_add(out, ">");
  km_html_escape(s->path, out);
  km_text_add(out, "</text>");
}

/* The group as it is in the first frame. */
static void add_group(const km_film *film, char prefix, size_t index, km_text *out) {
  const km_film_group *g = &film->groups[index];
  const char *kind = g->names ? "n " : "";
  if (g->shapes->count == 0 && g->mover != KM_FILM_DRAWN)
    return;
  km_text_add(out, "<g");
  if (g->mover == KM_FILM_DRAWN) {
    km_text_format(out, " class=\"d%zu\"", index);
  } else if (g->mover != KM_FILM_STANDS) {
    const km_film_mover *m = &film->movers[g->mover];
    km_text_format(out, " class=\"%sm%d\" transform=\"translate(", kind, g->mover);
    km_svg_number(out, m->x[0], 2);
    km_text_add(out, " ");
    km_svg_number(out, m->y[0], 2);
    km_text_add(out, ")\"");
  }
  km_text_add(out, ">");
  for (size_t i = 0; i < g->shapes->count; ++i)
    if (g->shapes->items[i].text)
      add_text(prefix, &g->shapes->items[i], out);
    else
      km_text_format(out, "<path class=\"%c%d\" d=\"%s\"/>", prefix, g->shapes->items[i].style,
                     g->shapes->items[i].path);
  km_text_add(out, "</g>\n");
}

static void add_film(const km_film_page *page, size_t k, km_text *out) {
  const km_film *film = page->films[k];
  km_text_format(out, "<figure><svg id=\"film%zu\" viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"", k, film->width,
                 film->height);
  km_html_escape(page->alt[k], out);
  km_text_add(out, "\">\n");
  for (size_t i = 0; i < film->group_count; ++i)
    add_group(film, prefix_of(k), i, out);
  km_text_add(out, "</svg></figure>\n");
}

/* Marks of the slider: triangles under its track; a click moves there. */
static void add_stops(const km_film_page *page, km_text *out) {
  size_t last = page->films[0]->frame_count - 1;
  km_text_add(out, "<div class=\"stops\">");
  for (size_t i = 0; i < page->stop_count && last > 0; ++i) {
    const km_motion_stop *stop = &page->stops[i];
    km_text_format(out, "<button style=\"left:");
    km_svg_number(out, 100.0 * stop->pose / (double)last, 2);
    km_text_add(out, "%\" data-frame=\"");
    km_svg_number(out, stop->pose, 2);
    km_text_add(out, "\" title=\"");
    km_html_escape(stop->name, out);
    km_text_add(out, "\" aria-label=\"");
    km_html_escape(stop->name, out);
    km_text_add(out, "\">▲</button>");
  }
  km_text_add(out, "</div>");
}

static void add_controls(const km_film_page *page, km_text *out) {
  km_text_format(out,
                 "<div class=\"controls\"><button id=\"play\" aria-label=\"Play\"><svg viewBox=\"0 0 16 16\">"
                 "<path d=\"M4 2l9 6l-9 6z\"/></svg></button>\n<div class=\"track\"><input id=\"frame\" type=\"range\" "
                 "min=\"0\" max=\"%zu\" step=\"1\" value=\"0\" aria-label=\"",
                 page->films[0]->frame_count - 1);
  km_html_escape(page->quantity, out);
  km_text_add(out, "\" data-quantity=\"");
  km_html_escape(page->quantity, out);
  km_text_add(out, "\" data-unit=\"");
  km_html_escape(page->unit, out);
  km_text_add(out, "\">");
  add_stops(page, out);
  km_text_add(out, "</div>\n<label><input id=\"names\" type=\"checkbox\" checked> names</label>"
                   "<output id=\"says\" for=\"frame\"></output></div>\n");
}

/* Differences from number to number, in whole steps, add up without error. */
static void add_differences(const double *values, size_t count, km_text *out) {
  long long before = 0;
  km_text_add(out, "[");
  for (size_t f = 0; f < count; ++f) {
    long long now = llround(values[f] * steps);
    km_text_format(out, f ? ",%lld" : "%lld", now - before);
    before = now;
  }
  km_text_add(out, "]");
}

static bool is_used(const km_film *film, size_t mover) {
  for (size_t i = 0; i < film->group_count; ++i)
    if (film->groups[i].mover == (int)mover && film->groups[i].shapes->count)
      return true;
  return false;
}

static void add_movers(const km_film *film, km_text *out) {
  const char *comma = "";
  for (size_t m = 0; m < film->mover_count; ++m) {
    if (!is_used(film, m))
      continue;
    km_text_format(out, "%s[%zu,", comma, m);
    add_differences(film->movers[m].x, film->frame_count, out);
    km_text_add(out, ",");
    add_differences(film->movers[m].y, film->frame_count, out);
    if (film->movers[m].angle) {
      km_text_add(out, ",");
      add_differences(film->movers[m].angle, film->frame_count, out);
    }
    km_text_add(out, "]\n");
    comma = ",";
  }
}

static void add_drawn(const km_film *film, km_text *out) {
  const char *comma = "";
  for (size_t i = 0; i < film->group_count; ++i) {
    if (film->groups[i].mover != KM_FILM_DRAWN)
      continue;
    km_text_format(out, "%s[%zu,[", comma, i);
    for (size_t f = 0; f < film->frame_count; ++f) {
      const km_film_shapes *shapes = &film->groups[i].shapes[f];
      km_text_add(out, f ? ",\n\"" : "\"");
      for (size_t k = 0; k < shapes->count; ++k)
        km_text_format(out, "%s%d%s", k ? "|" : "", shapes->items[k].style, shapes->items[k].path);
      km_text_add(out, "\"");
    }
    km_text_add(out, "]]\n");
    comma = ",";
  }
}

static void add_data(const km_film_page *page, km_text *out) {
  km_text_format(out, "<script type=\"application/json\" id=\"data\">{\"closed\":%s,\"seconds\":%g,\"values\":[",
                 page->closed ? "true" : "false", page->seconds);
  for (size_t f = 0; f < page->films[0]->frame_count; ++f)
    km_text_format(out, f ? ",\"%.5g\"" : "\"%.5g\"", page->values[f]);
  km_text_add(out, "],\"films\":[");
  for (size_t k = 0; k < page->film_count; ++k) {
    km_text_add(out, k ? ",{\"movers\":[" : "{\"movers\":[");
    add_movers(page->films[k], out);
    km_text_add(out, "],\"drawn\":[");
    add_drawn(page->films[k], out);
    km_text_add(out, "]}");
  }
  km_text_add(out, "]}</script>\n");
}

void km_film_write(const km_film_page *page, km_text *out) {
  km_text_format(out, "<div class=\"film%s\">\n", page->film_count > 1 ? " two" : "");
  for (size_t k = 0; k < page->film_count; ++k)
    add_film(page, k, out);
  add_controls(page, out);
  km_text_add(out, "</div>\n");
}

void km_film_script_write(const km_film_page *page, km_text *out) {
  add_data(page, out);
  km_text_format(out, "<script>\n%s</script>\n", km_film_script);
}

km_status km_film_page_write(const km_film_page *page, km_text *out, km_error *error) {
  size_t before = out->size;
  add_head(page, out);
  km_film_write(page, out);
  km_text_add(out, "<footer>");
  km_html_escape(page->footer, out);
  km_text_add(out, "</footer>\n");
  km_film_script_write(page, out);
  km_text_add(out, "</body>\n</html>\n");
  if (!out->failed)
    return KM_OK;
  out->size = before;
  return km_fail(error, KM_MEMORY, "out of memory for a page");
}
