/* Inputs on which the answers of a study depend besides its own text and the model's. Private to study/. */
#ifndef KM_STUDY_STUDY_INPUTS_H
#define KM_STUDY_STUDY_INPUTS_H

#include "base/store/store_file.h"
#include "study/design_study.h"

/* Appends hashes of the files that a request names, and of the tables that these name. KM_IO, KM_MEMORY. */
km_status km_design_add_files(const km_design_study *study, const km_design_question *question, km_text *out,
                              km_error *error);

#endif
