/* Figures that kspace map adds to each cell: leverage, forces of the actuators, the least clearance. */
#ifndef KSPACE_MAP_FIGURES_H
#define KSPACE_MAP_FIGURES_H

#include "common/pose.h"
#include "kmech/clearance.h"
#include "kmech/space.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"

typedef enum kspace_ask {
  KSPACE_ASK_MOBILITY,
  KSPACE_ASK_ADVANTAGE,
  KSPACE_ASK_FORCES,
  KSPACE_ASK_CLEARANCE
} kspace_ask;
#define KSPACE_ASK_WORDS "mobility or advantage or forces or clearance"

/* The figures and what they are computed with. */
typedef struct kspace_map_figures {
  km_map_figures figures; /* count 0: none */
  km_arena arena;
  km_transfer *transfer;
  km_statics statics;
  km_forces *forces;
  km_clearance *clearance;
  km_pair_clearance *pairs; /* [pair] of the present cell */
} kspace_map_figures;

/* Prepares the figures; drivers[2] hold where the model has no actuators. Free in any case. */
kt_exit kspace_map_figures_create(const kt_common *common, const kt_pose *pose, kspace_ask ask, const int *drivers,
                                  kspace_map_figures *out);
void kspace_map_figures_free(kspace_map_figures *figures);

#endif
