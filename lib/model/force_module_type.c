/* Names of the force module types. */
#include "model/model.h"

#include <string.h>

static const char *const words[KM_MODULE_TYPES] = {"stiffness", "damping",    "friction", "motor",
                                                   "pid",       "fiala_tire", "contact"};
static const char *const shapes[KM_CONTACT_SHAPES] = {"point-plane", "circle-line", "circle-circle",
                                                        "circle-in-circle"};

const char *km_contact_shape_word(km_contact_shape shape) {
  return shapes[shape];
}

int km_contact_shape_find(const char *word) {
  for (int shape = 0; shape < KM_CONTACT_SHAPES; ++shape)
    if (strcmp(word, shapes[shape]) == 0)
      return shape;
  return -1;
}

const char *km_module_type_word(km_module_type type) {
  return words[type];
}

km_module_variable km_module_type_variable(km_module_type type) {
  return type == KM_MODULE_MOTOR                                   ? KM_VARIABLE_TIME
         : type == KM_MODULE_DAMPING || type == KM_MODULE_FRICTION ? KM_VARIABLE_VELOCITY
                                                                   : KM_VARIABLE_DISPLACEMENT;
}

bool km_module_is_spring_in_joint(const km_model_module *module) {
  return module->type == KM_MODULE_STIFFNESS && module->variable == KM_VARIABLE_DISPLACEMENT &&
         module->input_count == 1 && module->inputs[0].weight == 1.0 && !module->saturates && !module->curve.form &&
         module->input.coordinate >= 0 && module->output.coordinate == module->input.coordinate;
}

const km_module_input *km_model_single_input(km_arena *arena, km_module_port port, km_distance distance) {
  km_module_input *input = KM_ARENA_NEW(arena, km_module_input, 1);
  if (input)
    *input = (km_module_input){.port = port, .distance = distance, .weight = 1.0};
  return input;
}

int km_module_type_find(const char *word) {
  for (int type = 0; type < KM_MODULE_TYPES; ++type)
    if (strcmp(word, words[type]) == 0)
      return type;
  return -1;
}
