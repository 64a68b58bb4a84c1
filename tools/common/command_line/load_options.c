/* Reads --load: changed and added loads. */
#include "common/command_line/question_options.h"

#include "kmech/base.h"

#include <string.h>

/* The model's loads, as changed and added to. */
typedef struct loads {
  km_load *items;
  int count;
} loads;

/* Reads the value of --load: numbers, then optionally :frame or :fixed. */
typedef struct values {
  double items[6];
  int count;
  bool turning, axes_given;
} values;

static bool read_values(const char *text, values *out) {
  const char *colon = strchr(text, ':');
  *out = (values){0};
  if (colon) {
    out->axes_given = true;
    out->turning = strcmp(colon + 1, "frame") == 0;
    if (!out->turning && strcmp(colon + 1, "fixed") != 0)
      return false;
  }
  const char *rest = text;
  for (char last = ','; last == ',' && out->count < 6;) {
    kt_piece item = kt_split(&rest, ",:");
    bool good = kt_number(item.text, &out->items[out->count]);
    last = item.separator;
    km_free(item.text);
    if (!good)
      return false;
    ++out->count;
    if (last != ',')
      return out->count == 1 || out->count == 3 || out->count == 6;
  }
  return false;
}

static km_load *named(const km_model *model, const char *name, loads *out) {
  for (int i = 0; i < km_model_load_count(model); ++i)
    if (strcmp(km_model_load_name(model, i), name) == 0)
      return &out->items[i];
  return NULL;
}

static kt_exit unknown(const kt_common *common, const km_model *model, const char *text, const char *name) {
  km_nearest nearest = {.wanted = name};
  char names[KM_NEAREST_TEXT];
  for (int i = 0; i < km_model_load_count(model); ++i)
    km_nearest_add(&nearest, km_model_load_name(model, i));
  kt_print_message(common, KM_ERROR,
                   "--load %s: \"%s\" is neither a load of the model (%s %s) nor a BODY/FRAME with a force "
                   "FX,FY,FZ",
                   text, name, km_model_load_count(model) > KM_NEAREST ? "the nearest are" : "it has",
                   km_nearest_text(&nearest, names));
  return KT_USAGE;
}

static void set(km_load *load, const values *v) {
  for (int k = 0; k < 3; ++k) {
    if (v->count == 1) {
      load->force[k] *= v->items[0];
      load->torque[k] *= v->items[0];
    } else {
      load->force[k] = v->items[k];
    }
    if (v->count == 6)
      load->torque[k] = v->items[3 + k];
  }
  if (v->axes_given)
    load->turning = v->turning;
}

static km_load *add(loads *out, int frame) {
  out->items[out->count] = (km_load){.frame = frame};
  return &out->items[out->count++];
}

static kt_exit read_one(const kt_common *common, const km_model *model, const char *text, loads *out) {
  const char *rest = text;
  kt_piece name = kt_split(&rest, "=");
  values v;
  kt_exit result = KT_DONE;
  km_load *load = named(model, name.text, out);
  if (name.separator != '=' || !read_values(rest, &v)) {
    result = kt_usage(common, "--load", text,
                      "NAME=FX,FY,FZ or NAME=FX,FY,FZ,TX,TY,TZ, or NAME=FACTOR for a load of the model; :frame behind "
                      "it for axes that turn with the frame");
  } else if (load) {
    set(load, &v);
  } else {
    int frame = -1;
    size_t size = (size_t)(rest - 1 - text);
    char *place = KM_NEW(char, size + 1);
    if (place)
      memcpy(place, text, size);
    if (!place)
      result = KT_NO_MEMORY;
    else if (v.count == 1 || !strchr(place, '/'))
      result = unknown(common, model, text, name.text);
    else
      result = kt_frame(common, model, "--load", place, &frame);
    if (result == KT_DONE)
      set(add(out, frame), &v);
    km_free(place);
  }
  km_free(name.text);
  return result;
}

kt_exit kt_loads(const kt_common *common, const km_model *model, const kt_texts *texts, km_arena *arena,
                 km_option_value *out) {
  int own = km_model_load_count(model);
  kt_exit result = KT_DONE;
  loads all = {KM_ARENA_NEW(arena, km_load, (size_t)(own + texts->count)), own};
  if (!all.items)
    return KT_NO_MEMORY;
  for (int i = 0; i < own; ++i)
    all.items[i] = km_model_load_at(model, i);
  for (int i = 0; i < texts->count && result == KT_DONE; ++i)
    result = read_one(common, model, texts->items[i], &all);
  out->loads = all.items;
  out->count = all.count;
  return result;
}
