/* Inputs and outputs on the command line. */
#include "kma/kma.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

void kma_ends_options_add(kt_options *out, kma_ends_options *o) {
  const kt_option table[] = {
      {"input", 0, "JOINT",
       "What is pushed: a joint, or BODY/FRAME:DX,DY,DZ, a point along a direction (default: the model's "
       "analysis.mechanical_advantage)",
       KT_TEXT, &o->input, KT_ABOUT_MODEL},
      {"output", 0, "JOINT", "What pushes: a joint, or a point in the same way", KT_TEXT, &o->output, KT_ABOUT_MODEL},
  };
  KT_OPTIONS_ADD(out, table);
}

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
static const char *direction_of(const char *text) {
  const char *colon = strrchr(text, ':');
  return colon && colon > text && colon[-1] != '\\' ? colon + 1 : NULL;
}

bool kma_has_direction(const char *text) {
  return direction_of(text) != NULL;
}

static kt_exit read_point(const kt_common *common, const km_model *model, const char *option, const char *text,
                          km_handle *out, char **owned) {
  const char *direction = direction_of(text);
  if (!direction || !read_direction(direction, out->direction)) {
    kt_say(common, KM_ERROR, "%s %s: expected BODY/FRAME:DX,DY,DZ, a point of a body and a direction", option, text);
    return KT_USAGE;
  }
  size_t size = (size_t)(direction - text);
  char *place = KM_NEW(char, size), *name = kt_plain(text);
  kt_exit result = place && name ? KT_DONE : KT_INTERNAL;
  if (result == KT_DONE) {
    memcpy(place, text, size - 1);
    result = kt_frame(common, model, option, place, &out->frame);
  }
  km_free(place);
  out->kind = KM_HANDLE_POINT;
  out->coordinate = -1;
  out->name = *owned = name;
  return result;
}

/* A joint's label may hold a colon: a joint that is there wins. */
static kt_exit read_end(const kt_common *common, const km_model *model, const char *option, const char *text,
                        km_handle *out, char **owned) {
  const char *rest = text;
  kt_piece label = kt_split(&rest, "");
  bool point = strcmp(option, "--point") == 0;
  bool known = !point && label.text && km_model_find_coordinate(model, label.text, &out->coordinate, NULL) == KM_OK;
  km_free(label.text);
  if (point || (!known && direction_of(text)))
    return read_point(common, model, option, text, out, owned);
  kt_exit result = kt_coordinate(common, model, option, text, &out->coordinate);
  out->kind = KM_HANDLE_JOINT;
  if (result == KT_DONE)
    out->name = km_model_coordinate_label(model, out->coordinate);
  else if (strchr(text, '/'))
    kt_say(common, KM_NOTE, "a point of a body needs a direction: BODY/FRAME:DX,DY,DZ");
  return result;
}

/* Points fill the ends that no option names: one is the output, two are input and output. */
static kt_exit place_points(const kt_common *common, const kma_ends_options *o, const char **input,
                            const char **output) {
  for (int i = o->points.count; i-- > 0;) {
    if (!*output)
      *output = o->points.items[i];
    else if (!*input)
      *input = o->points.items[i];
    else
      return kt_usage(common, "--point", o->points.items[i],
                      "one point for each end that --input and --output leave open");
  }
  return KT_DONE;
}

kt_exit kma_ends_read(const kt_common *common, const char *path, const km_model *model, const kma_ends_options *o,
                      kma_ends *out) {
  const char *input = o->input, *output = o->output;
  *out = (kma_ends){0};
  kt_exit result = place_points(common, o, &input, &output);
  if (result == KT_DONE && input)
    result = read_end(common, model, input == o->input ? "--input" : "--point", input, &out->input, &out->owned[0]);
  if (result == KT_DONE && output)
    result =
        read_end(common, model, output == o->output ? "--output" : "--point", output, &out->output, &out->owned[1]);
  if (result != KT_DONE)
    return result;
  bool have_input = input || km_handle_default(model, false, &out->input);
  bool have_output = output || km_handle_default(model, true, &out->output);
  if (have_input && have_output)
    return KT_DONE;
  kt_say(common, KM_ERROR, "%s: the model's analysis.mechanical_advantage has no %s; expected --%s", path,
         have_input ? "output" : "input", have_input ? "output or --point" : "input");
  return KT_USAGE;
}

void kma_ends_free(kma_ends *ends) {
  km_free(ends->owned[0]);
  km_free(ends->owned[1]);
}
