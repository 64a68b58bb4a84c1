/* Writes outlines in AutoCAD's exchange format, release 12: pairs of lines, a group's number and its value. */
#include "report/drawing/link_outlines.h"

#include "model/units.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { NAME = 32 }; /* bytes of a layer's name, with its NUL */

static void write_text(km_text *out, int group, const char *value) {
  km_text_format(out, "%3d\r\n%s\r\n", group, value);
}

static void write_number(km_text *out, int group, double value) {
  char text[KM_NUMBER_TEXT];
  km_number_format(text, fabs(value) < 1e-300 ? 0.0 : value);
  write_text(out, group, text);
}

static void write_point(km_text *out, int group, km_canvas_point point) {
  write_number(out, group, point.x);
  write_number(out, group + 10, point.y);
  write_number(out, group + 20, 0.0);
}

/* Release 12 allows letters, digits and _ only; the number distinguishes names that become equal. */
static void layer_name(const km_model *model, int body, char out[NAME]) {
  const char *name = body ? model->bodies[body].name : "fixed";
  size_t count = (size_t)snprintf(out, NAME, "%d_", body);
  for (; *name && count < NAME - 1; ++name)
    out[count++] =
        isalnum((unsigned char)*name) && (unsigned char)*name < 128 ? (char)toupper((unsigned char)*name) : '_';
  out[count] = '\0';
}

/* The number of a length unit in the header's $INSUNITS. */
static const char *unit_number(const km_model *model) {
  static const char *const numbers[][2] = {{"in", "1"}, {"mm", "4"}, {"cm", "5"}, {"m", "6"}};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
    if (strcmp(model->units.length->suffix, numbers[i][0]) == 0)
      return numbers[i][1];
  return "0";
}

static void write_head(const km_model *model, km_text *out) {
  write_text(out, 0, "SECTION");
  write_text(out, 2, "HEADER");
  write_text(out, 9, "$ACADVER");
  write_text(out, 1, "AC1009");
  write_text(out, 9, "$INSUNITS");
  write_text(out, 70, unit_number(model));
  write_text(out, 0, "ENDSEC");
}

static void write_layers(const km_model *model, km_text *out) {
  char name[NAME];
  write_text(out, 0, "SECTION");
  write_text(out, 2, "TABLES");
  write_text(out, 0, "TABLE");
  write_text(out, 2, "LAYER");
  snprintf(name, sizeof name, "%d", model->body_count);
  write_text(out, 70, name);
  for (int b = 0; b < model->body_count; ++b) {
    write_text(out, 0, "LAYER");
    layer_name(model, b, name);
    write_text(out, 2, name);
    write_text(out, 70, "0");
    snprintf(name, sizeof name, "%d", b % 7 + 1); /* one of the seven colours that every reader has */
    write_text(out, 62, name);
    write_text(out, 6, "CONTINUOUS");
  }
  write_text(out, 0, "ENDTAB");
  write_text(out, 0, "ENDSEC");
}

static double degrees(double angle) {
  return fmod(angle * 180.0 / M_PI + 720.0, 360.0);
}

static void write_part(const km_model *model, const km_outline_part *p, km_text *out) {
  static const char *const kinds[] = {"LINE", "ARC", "CIRCLE"};
  char name[NAME];
  layer_name(model, p->body, name);
  write_text(out, 0, kinds[p->kind]);
  write_text(out, 8, name);
  write_point(out, 10, p->from);
  if (p->kind == KM_OUTLINE_LINE) {
    write_point(out, 11, p->to);
    return;
  }
  write_number(out, 40, p->radius);
  if (p->kind != KM_OUTLINE_ARC)
    return;
  write_number(out, 50, degrees(p->begin));
  write_number(out, 51, degrees(p->end));
}

km_status km_outlines_dxf(const km_outlines *o, km_text *out, km_error *error) {
  size_t before = out->size;
  write_head(o->model, out);
  write_layers(o->model, out);
  write_text(out, 0, "SECTION");
  write_text(out, 2, "ENTITIES");
  for (size_t i = 0; i < o->count; ++i)
    write_part(o->model, &o->parts[i], out);
  write_text(out, 0, "ENDSEC");
  write_text(out, 0, "EOF");
  if (!out->failed)
    return KM_OK;
  out->size = before;
  return km_fail(error, KM_MEMORY, "out of memory for outlines");
}
