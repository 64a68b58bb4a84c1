/* The frame that a study calls its effector. */
#include "arm/study.h"

#include <string.h>

enum { LONGEST_PATH = 64 };

/* The names of "body/frame", where a \\ keeps the slash of a name. The count; 0: too many, or out of memory. */
static size_t split_path(km_arena *arena, const char *text, const char **names) {
  char *to = KM_ARENA_NEW(arena, char, strlen(text) + 1);
  size_t count = 0;
  if (!to)
    return 0;
  names[count++] = to;
  for (const char *c = text; *c; ++c) {
    if (*c == '/' && count == LONGEST_PATH)
      return 0;
    if (*c == '/') {
      *to++ = '\0';
      names[count++] = to;
      continue;
    }
    c += *c == '\\' && c[1];
    *to++ = *c;
  }
  *to = '\0';
  return count;
}

/* A text is a body's own name, which may hold slashes, or else a path. */
static bool find_text(const km_model *model, const char *text, km_arena *arena, int *frame) {
  const char *names[LONGEST_PATH] = {text};
  if (!km_model_find_frame(model, names, 1, frame, NULL))
    return true;
  size_t count = strchr(text, '/') ? split_path(arena, text, names) : 0;
  return count > 1 && !km_model_find_frame(model, names, count, frame, NULL);
}

km_status km_effector_find(const km_model *model, const km_study_names *path, km_arena *arena, int *frame,
                           km_error *error) {
  if (path->count == 1 && path->items[0] && find_text(model, path->items[0], arena, frame))
    return KM_OK;
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for a study");
  return km_model_find_frame(model, path->items, (size_t)path->count, frame, error);
}
