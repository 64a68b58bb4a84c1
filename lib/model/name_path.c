/* Paths as a file writes them, taken apart into names. */
#include "model/name_path.h"

#include <stdio.h>
#include <string.h>

bool km_path_names_gather(const km_value *value, km_path_names *out) {
  out->count = 0;
  out->names[0] = "";
  out->copy = NULL;
  out->failed = false;
  if (value->kind == KM_STRING) {
    out->names[out->count++] = value->string;
    return true;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    if (out->count == KM_LONGEST_PATH)
      return false;
    out->names[out->count++] = v->kind == KM_STRING ? v->string : "";
  }
  return true;
}

bool km_path_names_split(const char *text, km_path_names *out) {
  out->count = 0;
  bool parted = strchr(text, '/') != NULL;
  out->copy = parted ? KM_NEW(char, strlen(text) + 1) : NULL;
  out->failed = parted && !out->copy;
  if (!out->copy)
    return false;
  char *end = out->copy;
  bool sound = true;
  out->names[out->count++] = end;
  for (const char *c = text; *c && sound; ++c) {
    if (*c == '/') {
      *end++ = '\0';
      sound = out->count < KM_LONGEST_PATH && out->names[out->count - 1][0];
      if (sound)
        out->names[out->count++] = end;
    } else {
      if (*c == '\\' && c[1])
        ++c;
      *end++ = *c;
    }
  }
  if (sound && out->count > 1 && out->names[out->count - 1][0])
    return true;
  km_path_names_free(out);
  return false;
}

void km_path_names_free(km_path_names *path) {
  km_free(path->copy);
  path->copy = NULL;
}

const char *km_path_names_text(const char *const *names, size_t count, char out[KM_PATH_TEXT]) {
  size_t used = 0;
  out[0] = '\0';
  for (size_t i = 0; i < count && used < KM_PATH_TEXT - 1; ++i) {
    int length = snprintf(out + used, KM_PATH_TEXT - used, "%s%s", i ? "/" : "", names[i]);
    used += length > 0 ? (size_t)length : 0;
  }
  return out;
}
