/* The ranks of mpirun, where kstudy runs under it and was built with MPI. */
#ifndef KSTUDY_RANKS_H
#define KSTUDY_RANKS_H

#include "kmech/study.h"

typedef struct kstudy_ranks {
  int rank, count; /* 0 of 1 without mpirun */
  km_design_workers crew;
} kstudy_ranks;

/* Joins the others; nothing happens without mpirun. */
void kstudy_ranks_begin(kstudy_ranks *ranks);
/* The leader dismisses the others first. All ranks call it. */
void kstudy_ranks_end(kstudy_ranks *ranks);

#endif
