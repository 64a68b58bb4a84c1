/* Shapes of bodies. */
#include "exchange/json/read/reader.h"

#include <string.h>

/* Stated kind of shape; −1: error reported. */
static int find_kind(km_reader *reader, const km_value *value, const km_place *place) {
  int found = -1, count = 0;
  for (int k = 0; k < KM_SHAPE_KINDS; ++k)
    if (km_value_get(value, km_shape_word((km_shape_kind)k))) {
      found = k;
      count++;
    }
  if (count == 1)
    return found;
  km_reader_error(reader, place, "found %d of mesh, box, sphere, cylinder and capsule; expected one", count);
  return -1;
}

/* One number, or a list of `count`; false: reported. */
static bool read_numbers(km_reader *reader, const km_value *value, const km_place *place, int count, double *out) {
  size_t given = value->kind == KM_LIST ? value->count : 1;
  if (given != (size_t)count) {
    km_reader_error(reader, place, "found %zu numbers; expected %d", given, count);
    return false;
  }
  const km_value *item = value->kind == KM_LIST ? value->first : value;
  for (int k = 0; k < count; ++k, item = item->next)
    out[k] = item->number;
  return true;
}

static void read_size(km_reader *reader, const km_value *value, const km_place *place, km_model_shape *out) {
  const km_value *scale = km_value_get(value, "scale");
  km_place scale_at = {place, "scale", 0}, at = {place, km_shape_word(out->kind), 0};
  int count = km_shape_sizes(out->kind);
  if (out->kind != KM_SHAPE_OF_MESH) {
    if (scale)
      km_reader_error(reader, &scale_at, "found a scale of a %s; expected it only of a mesh", km_shape_word(out->kind));
    if (!read_numbers(reader, km_value_get(value, km_shape_word(out->kind)), &at, count, out->size))
      return;
    for (int k = 0; k < count; ++k)
      if (!(out->size[k] > 0.0))
        km_reader_error(reader, &at, "found %s; expected sizes greater than 0", KM_SHOWN(out->size[k]));
    return;
  }
  out->mesh = km_reader_string(value, "mesh");
  if (!scale)
    return;
  if (!read_numbers(reader, scale, &scale_at, scale->kind == KM_LIST ? 3 : 1, out->scale))
    return;
  for (int k = 1; k < 3 && scale->kind != KM_LIST; ++k)
    out->scale[k] = out->scale[0];
  for (int k = 0; k < 3; ++k)
    if (out->scale[k] == 0.0)
      km_reader_error(reader, &scale_at, "found 0; expected another number");
}

static void read_color(km_reader *reader, const km_value *value, const km_place *place, km_model_shape *out) {
  const km_value *color = km_value_get(value, "color");
  km_place at = {place, "color", 0};
  if (!color)
    return;
  out->color[3] = 1.0;
  if (!read_numbers(reader, color, &at, color->count == 3 ? 3 : 4, out->color))
    return;
  for (int k = 0; k < 4; ++k)
    if (!(out->color[k] >= 0.0 && out->color[k] <= 1.0))
      km_reader_error(reader, &at, "found %s; expected numbers from 0 to 1", KM_SHOWN(out->color[k]));
}

void km_read_shape(km_reader *reader, const km_value *value, int body, const km_place *place) {
  km_model *model = reader->model;
  int kind = find_kind(reader, value, place);
  if (kind < 0)
    return;
  km_model_shape shape = {.body = body,
                          .kind = (km_shape_kind)kind,
                          .where = km_reader_where(reader, place),
                          .scale = {1, 1, 1},
                          .pose = {km_reader_orientation(reader, value, place), km_reader_vector(value, "T")},
                          .density = km_reader_number(value, "density", -1.0),
                          .color = {0, 0, 0, -1.0}};
  read_size(reader, value, place, &shape);
  read_color(reader, value, place, &shape);
  if (km_value_get(value, "density"))
    km_reader_positive(reader, place, "density", shape.density);
  model->shapes[model->shape_count++] = shape;
}
