/* What kstatic's commands share. */
#ifndef KSTATIC_H
#define KSTATIC_H

#include "common/pose.h"
#include "kmech/mobility.h"
#include "kmech/statics.h"

kt_exit kstatic_at(int argc, char **argv);
kt_exit kstatic_sweep(int argc, char **argv);
kt_exit kstatic_report(int argc, char **argv);

/* --actuators --load --gravity --axes as they were given. */
typedef struct kstatic_options {
  const char *actuators, *gravity;
  kt_texts loads;
  int axes; /* a km_axes */
} kstatic_options;

void kstatic_options_add(kt_options *out, kstatic_options *options);

/* The forces on a model and its actuators, as the options over the model's own say. */
typedef struct kstatic_balance {
  km_forces *forces;
  km_statics statics;
} kstatic_balance;

/* Says what is wrong. The caller frees the balance in any case. */
kt_exit kstatic_prepare(const kt_common *common, const char *path, const kt_pose *pose, const kstatic_options *options,
                        kstatic_balance *out);
/* What acts on the model, in words. */
void kstatic_words(const km_model *model, const kstatic_options *options, km_text *out);
void kstatic_free(kstatic_balance *balance);

#endif
