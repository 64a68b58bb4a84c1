/* Names of the force module types. */
#include "model/model.h"

#include <string.h>

static const char *const words[KM_MODULE_TYPES] = {"stiffness", "damping", "friction", "motor", "pid", "fiala_tire"};

const char *km_module_type_word(km_module_type type) {
  return words[type];
}

int km_module_type_find(const char *word) {
  for (int type = 0; type < KM_MODULE_TYPES; ++type)
    if (strcmp(word, words[type]) == 0)
      return type;
  return -1;
}
