/* Inputs on which the answers of a study depend besides its own text and the model's. Private to study/. */
#ifndef KM_STUDY_STUDY_INPUTS_H
#define KM_STUDY_STUDY_INPUTS_H

#include "study/design_study.h"

/* Append to a text whose hash is a key: a name with its length, so that lists of names are unambiguous; numbers. */
void km_design_add_name(km_text *out, const char *name);
void km_design_add_numbers(km_text *out, const double *numbers, int count);
/* Appends masses and inertias of bodies with meshes, the only effect of mesh files. */
void km_design_add_meshes(const km_model *model, km_text *out);
/* Appends hashes of the files that a request names, and of the tables that these name. KM_IO, KM_MEMORY. */
km_status km_design_add_files(const km_design_study *study, const km_design_question *question, km_text *out,
                              km_error *error);

#endif
