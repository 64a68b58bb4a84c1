/* Ends of a leverage on the command line: joints, or points with a direction. */
#include "common/command_line/question_options.h"

#include "kmech/base.h"

#include <math.h>
#include <string.h>

/* Three numbers of a direction, made a unit vector. */
static bool read_direction(const char *text, double out[3]) {
  if (!kt_numbers(text, 3, out))
    return false;
  double size = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  for (int k = 0; k < 3 && size > 0.0; ++k)
    out[k] /= size;
  return size > 0.0;
}

/* The last colon parts a point from its direction; a backslash before it makes it a part of a name. */
const char *kt_direction(const char *text) {
  const char *colon = strrchr(text, ':');
  return colon && colon > text && colon[-1] != '\\' ? colon + 1 : NULL;
}

static kt_exit read_point(const kt_common *common, const km_model *model, const char *option, const char *text,
                          km_arena *arena, km_port *out) {
  const char *direction = kt_direction(text);
  if (!read_direction(direction, out->direction)) {
    kt_print_message(common, KM_ERROR, "%s %s: expected BODY/FRAME:DX,DY,DZ, a point of a body and a direction", option,
                     text);
    return KT_USAGE;
  }
  size_t size = (size_t)(direction - text);
  char *place = KM_ARENA_NEW(arena, char, size), *name = kt_plain(text);
  out->kind = KM_PORT_POINT;
  out->coordinate = -1;
  out->name = km_arena_string(arena, name);
  km_free(name);
  if (!place || !out->name)
    return KT_NO_MEMORY;
  memcpy(place, text, size - 1);
  return kt_frame(common, model, option, place, &out->frame);
}

/* A joint's label may hold a colon: a joint that is there wins. */
kt_exit kt_end(const kt_common *common, const km_model *model, const char *option, const char *text, km_arena *arena,
               km_port *out) {
  const char *rest = text;
  kt_piece label = kt_split(&rest, "");
  bool known = km_model_find_coordinate(model, label.text, &out->coordinate, NULL) == KM_OK;
  km_free(label.text);
  if (!known && kt_direction(text))
    return read_point(common, model, option, text, arena, out);
  kt_exit result = kt_coordinate(common, model, option, text, &out->coordinate);
  out->kind = KM_PORT_JOINT;
  if (result != KT_DONE && strchr(text, '/'))
    kt_print_message(common, KM_NOTE, "a point of a body needs a direction: BODY/FRAME:DX,DY,DZ");
  return result;
}
