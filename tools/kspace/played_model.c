/* A model whose drivers follow a path over time. */
#include "kspace/played_model.h"

#include "kmech/inspect.h"
#include "kmech/model.h"

#include <string.h>

/* The joint of a label among those of the assemblies and of theirs; NULL: none. */
static const km_value *find_joint(const km_value *assemblies, const char *label) {
  for (const km_value *a = assemblies ? assemblies->first : NULL; a; a = a->next) {
    const km_value *joints = km_value_get(a, "joints"), *name = km_value_get(a, "name");
    for (const km_value *j = joints ? joints->first : NULL; j; j = j->next) {
      const km_value *own = km_value_get(j, "name");
      size_t length = name && name->string ? strlen(name->string) : 0;
      bool is_full = length > 0 && own && own->string && strncmp(label, name->string, length) == 0 &&
                     label[length] == '/' && strcmp(label + length + 1, own->string) == 0;
      if (own && own->string && (is_full || strcmp(label, own->string) == 0))
        return j;
    }
    const km_value *inner = find_joint(km_value_get(a, "assemblies"), label);
    if (inner)
      return inner;
  }
  return NULL;
}

/* Adds the table of one driver to its joint. */
static void prescribe(km_value *joint, const km_table *motion, int column, double time, km_arena *arena) {
  km_value *table = km_value_add(arena, km_value_add(arena, joint, "prescribed", KM_OBJECT), "table", KM_LIST);
  for (size_t r = 0; r < km_table_rows(motion); ++r) {
    const double *row = km_table_row(motion, r), knot[2] = {time * row[0], row[column]};
    km_value_numbers(arena, table, NULL, knot, 2);
  }
}

kt_exit kspace_write_played_model(const kt_common *common, const char *file, const km_model *model,
                                  const km_table *motion, const int *drivers, int count, double time,
                                  const char *base) {
  km_arena arena = {0};
  km_text bytes = {0}, out = {0};
  km_error error;
  const km_value *root = NULL;
  km_status status = km_file_read(file, &bytes, &error);
  if (!status)
    status = km_json_parse(bytes.data, bytes.size, &arena, &root, &error);
  for (int d = 0; !status && d < count; ++d) {
    const char *label = km_model_coordinate_label(model, drivers[d]);
    const km_value *joint = find_joint(km_value_get(root, "assemblies"), label);
    if (joint && km_value_get(joint, "prescribed"))
      status = km_fail(&error, KM_USAGE, "joint \"%s\" of %s has a prescribed motion already; expected a model without",
                       label, file);
    else if (joint) /* the tree is that of this arena */
      prescribe((km_value *)(size_t)joint, motion, d + 1, time, &arena);
    else
      status = km_fail(&error, KM_USAGE, "joint \"%s\" can't be prescribed in %s; expected a joint of a JSON model",
                       label, file);
  }
  if (!status)
    km_json_write(root, &out);
  if (!status && (arena.failed || out.failed))
    status = km_fail(&error, KM_MEMORY, "out of memory for the prescribed model");
  if (status)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_write(common, base, "path", "json", &out);
  km_text_free(&out);
  km_text_free(&bytes);
  km_arena_free(&arena);
  return result;
}
