/* Text about what acts on a mechanism: gravity, loads, force modules, damping and friction of joints. */
#ifndef KM_REPORT_RECORD_WORDS_FORCES_TEXT_H
#define KM_REPORT_RECORD_WORDS_FORCES_TEXT_H

#include "forces/forces.h"

/* "gravity (0, -9.81, 0) m/s²; gas: spring in strut; damping in D", appended. `forces` NULL: the model's own gravity
 * and loads. `at_rest`: forces that act in motion only are left out. */
void km_acting_words(const km_model *model, const km_forces *forces, bool at_rest, km_text *out);
/* "; gas spring in lift; stop: contact between ram and frame": the force modules that act. */
void km_modules_words(const km_model *model, bool at_rest, km_text *out);

#endif
