/* Algorithms of optimisations. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_ALGORITHMS_H
#define KM_STUDY_OPTIMISATION_ALGORITHMS_H

#include <nlopt.h>
#include <stdbool.h>

typedef struct km_algorithm {
  const char *word, *about;
  nlopt_algorithm id;
  bool gradient;    /* needs derivatives: central differences */
  bool constraints; /* handles inequality constraints; otherwise it runs inside an augmented Lagrangian */
  bool local;       /* calls a local algorithm from its own starts */
} km_algorithm;

const km_algorithm *km_algorithm_find(const char *word); /* finds an algorithm by name; NULL: unknown */

#endif
