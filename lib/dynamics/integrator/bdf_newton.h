/* Linear systems of BDF's Newton iteration. Private to dynamics/. */
#ifndef KM_DYNAMICS_INTEGRATOR_BDF_NEWTON_H
#define KM_DYNAMICS_INTEGRATOR_BDF_NEWTON_H

#include "dynamics/simulation.h"

#include <cvode/cvode.h>

typedef struct km_newton km_newton;

/* Attaches a solver of (I − γ J) x = b, J = ∂f/∂y, to `cvode`. The derivative depends on few components: independent
 * coordinates, their rates, internal states of forces. Only their columns of J are computed, by differences, and
 * factored; the other components follow. NULL: out of memory. Cost: columns + 1 evaluations and O(columns³) for a
 * matrix, O(columns · size) for a solution. */
km_newton *km_newton_create(km_simulation *run, void *cvode, SUNContext context);
void km_newton_free(km_newton *newton);

#endif
