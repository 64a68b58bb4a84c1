/* The algorithms of optimisations. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_ALGORITHMS_H
#define KM_STUDY_OPTIMISATION_ALGORITHMS_H

#include <nlopt.h>
#include <stdbool.h>

typedef struct km_algorithm {
  const char *word, *about;
  nlopt_algorithm id;
  bool gradient;    /* it wants derivatives: central differences */
  bool constraints; /* it takes inequality constraints itself; else an augmented Lagrangian does around it */
  bool local;       /* it calls another one from its own starts */
} km_algorithm;

const km_algorithm *km_algorithm_find(const char *word); /* NULL: unknown */

#endif
