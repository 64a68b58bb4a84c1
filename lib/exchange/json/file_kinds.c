/* Recognises the kind of a JSON file by its characteristic keys. */
#include "exchange/json/format/format.h"

const char *km_other_kind(const km_value *root, const km_object_format *expected) {
  static const struct {
    const km_object_format *format;
    const char *keys[6], *words;
  } kinds[] = {
      {&km_format_model, {"assemblies", "model_parameters"}, "a model"},
      {&km_format_study, {"effector", "path", "methods", "q0", "segments"}, "a path study, which kredund reads"},
      {&km_format_designs,
       {"ask", "sample", "optimise", "grid", "variants"},
       "a study of designs, which kstudy reads"}};
  const char *found = NULL;
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k)
    for (const char *const *key = kinds[k].keys; *key; ++key) {
      if (!km_value_get(root, *key))
        continue;
      if (kinds[k].format == expected)
        return NULL;
      found = kinds[k].words;
    }
  return found;
}
