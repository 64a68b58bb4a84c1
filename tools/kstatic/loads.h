/* Loads on the command line. */
#ifndef KSTATIC_LOADS_H
#define KSTATIC_LOADS_H

#include "kstatic/kstatic.h"

/* The model's loads, as changed and added to by --load. */
typedef struct kstatic_loads {
  km_load *items;
  int count;
} kstatic_loads;

/* Says what is wrong. The caller frees the loads in any case. */
kt_exit kstatic_loads_read(const kt_common *common, const km_model *model, const kt_texts *texts, kstatic_loads *out);
void kstatic_loads_free(kstatic_loads *loads);

#endif
