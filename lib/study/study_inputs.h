/* What the answers of a study depend on beside its own file and the model's text. Private to study/. */
#ifndef KM_STUDY_STUDY_INPUTS_H
#define KM_STUDY_STUDY_INPUTS_H

#include "study/design_study.h"

/* Each appends to a text whose hash is a key: a name with its length, so that no two lists of names read alike; numbers. */
void km_design_add_name(km_text *out, const char *name);
void km_design_add_numbers(km_text *out, const double *numbers, int count);
/* What the meshes of a model weigh: their files change nothing else. "" where it has none. */
void km_design_add_meshes(const km_model *model, km_text *out);
/* The contents of the files that a question names, and of the tables that these name. KM_IO, KM_MEMORY. */
km_status km_design_add_files(const km_design_study *study, const km_design_question *question, km_text *out,
                              km_error *error);

#endif
