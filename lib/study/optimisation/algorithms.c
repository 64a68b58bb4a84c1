/* Algorithms of NLopt for optimisations. */
#include "study/optimisation/algorithms.h"

#include "base/similar_names.h"
#include "study/optimisation/optimisation.h"

#include <string.h>

static const km_algorithm algorithms[] = {
    {"cobyla", "local, linear models, takes constraints (Powell 1994)", NLOPT_LN_COBYLA, false, true, false},
    {"bobyqa", "local, quadratic models (Powell 2009)", NLOPT_LN_BOBYQA, false, false, false},
    {"nelder-mead", "local, simplex (Nelder and Mead 1965)", NLOPT_LN_NELDERMEAD, false, false, false},
    {"subplex", "local, simplices in subspaces (Rowan 1990)", NLOPT_LN_SBPLX, false, false, false},
    {"slsqp", "local, gradient, takes constraints (Kraft 1994)", NLOPT_LD_SLSQP, true, true, false},
    {"mma", "local, gradient, takes constraints (Svanberg 2002)", NLOPT_LD_MMA, true, true, false},
    {"lbfgs", "local, gradient, limited-memory BFGS (Nocedal 1980)", NLOPT_LD_LBFGS, true, false, false},
    {"direct", "global, dividing rectangles (Gablonsky and Kelley 2001)", NLOPT_GN_DIRECT_L, false, false, false},
    {"crs", "global, controlled random search (Kaelo and Ali 2006)", NLOPT_GN_CRS2_LM, false, false, false},
    {"isres", "global, evolution strategy, takes constraints (Runarsson and Yao 2005)", NLOPT_GN_ISRES, false, true,
     false},
    {"esch", "global, evolution (Beasley and da Silva Santos 2010)", NLOPT_GN_ESCH, false, false, false},
    {"mlsl", "global, multi-start of bobyqa over a low-discrepancy sequence (Kucherenko and Sytsko 2005)",
     NLOPT_G_MLSL_LDS, false, false, true},
};

enum { COUNT = sizeof algorithms / sizeof *algorithms };

const km_algorithm *km_algorithm_find(const char *word) {
  for (int i = 0; i < COUNT && word; ++i)
    if (strcmp(algorithms[i].word, word) == 0)
      return &algorithms[i];
  return NULL;
}

const char *km_design_algorithm(int index) {
  return index >= 0 && index < COUNT ? algorithms[index].word : NULL;
}

const char *km_design_algorithm_about(int index) {
  return index >= 0 && index < COUNT ? algorithms[index].about : NULL;
}

km_status km_algorithm_check(const char *word, km_error *error) {
  char names[KM_NEAREST_TEXT];
  km_nearest nearest = {.wanted = word ? word : ""};
  if (km_algorithm_find(word))
    return KM_OK;
  for (int i = 0; i < COUNT; ++i)
    km_nearest_add(&nearest, algorithms[i].word);
  return km_fail(error, KM_USAGE, "optimise.algorithm: there is no algorithm \"%.80s\"; the nearest ones are %s",
                 nearest.wanted, km_nearest_text(&nearest, names));
}
