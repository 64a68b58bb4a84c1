/* What kma's commands share. */
#ifndef KMA_H
#define KMA_H

#include "common/pose.h"
#include "kmech/advantage.h"

kt_exit kma_at(int argc, char **argv);
kt_exit kma_sweep(int argc, char **argv);
kt_exit kma_report(int argc, char **argv);

/* --input --output --point as they were given. */
typedef struct kma_ends_options {
  const char *input, *output;
  kt_texts points; /* BODY/FRAME:DX,DY,DZ; of a sweep BODY/FRAME too */
} kma_ends_options;

void kma_ends_options_add(kt_options *out, kma_ends_options *options);

/* Does a point end with a direction? */
bool kma_has_direction(const char *text);

/* Input and output of one model. Names of points are owned by it. */
typedef struct kma_ends {
  km_handle input, output;
  char *owned[2];
} kma_ends;

/* Reads the ends over the model's own; says what is wrong. The caller frees them in any case. */
kt_exit kma_ends_read(const kt_common *common, const char *path, const km_model *model, const kma_ends_options *options,
                      kma_ends *out);
void kma_ends_free(kma_ends *ends);

#endif
