/* The answer of kspace modes, and its forms. */
#ifndef KSPACE_MODES_ANSWER_H
#define KSPACE_MODES_ANSWER_H

#include "common/common.h"
#include "common/pose.h"
#include "kmech/report.h"
#include "kmech/space.h"
#include "kmech/transfer.h"

/* Words of --format in their order. */
enum { KSPACE_TABLE, KSPACE_JSON, KSPACE_CSV, KSPACE_SVG, KSPACE_PDF, KSPACE_PNG };

typedef struct kspace_modes_options {
  kt_common common;
  kt_texts holds, sets;
  const char *model;
  const char *base; /* -o, or NULL */
  int format;
  bool limits;
} kspace_modes_options;

/* Modes with the pose at which they were searched. */
typedef struct kspace_modes_answer {
  const kspace_modes_options *o;
  const kt_pose *pose;
  int *locked; /* [locked_count] coordinates that keep their values */
  int locked_count;
  km_all_modes modes;
  km_mode_circuits circuits;
  bool has_leverage;
  km_port input, output;   /* ports of the model's analysis.mechanical_advantage */
  km_advantage *advantage; /* [mode] */
  km_drawing *drawing;     /* the modes as poses; NULL: no picture is requested */
} kspace_modes_answer;

/* ", A at 60 deg" for each locked joint, "with" before the first. */
void kspace_print_locked(const kspace_modes_answer *a, km_text *out);
/* Leverage of mode i with its unit, or the word for its state. */
void kspace_print_leverage(const kspace_modes_answer *a, int i, km_text *out);
void kspace_print_modes(const kspace_modes_answer *a, km_text *out);
/* NULL: out of memory. */
const km_value *kspace_modes_record(const kspace_modes_answer *a, km_arena *arena);
kt_exit kspace_add_table(const kspace_modes_answer *a, km_text *out);
km_status kspace_add_picture(const kspace_modes_answer *a, km_text *out, km_arena *arena, km_error *error);

#endif
