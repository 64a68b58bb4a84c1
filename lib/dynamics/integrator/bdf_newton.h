/* The linear systems of BDF's Newton iterations. Private to dynamics/. */
#ifndef KM_DYNAMICS_INTEGRATOR_BDF_NEWTON_H
#define KM_DYNAMICS_INTEGRATOR_BDF_NEWTON_H

#include "dynamics/simulation.h"

#include <cvode/cvode.h>

typedef struct km_newton km_newton;

/* Makes `cvode` solve (I − γ J) x = b, J = ∂f/∂y. A derivative depends on few components of the vector: independent
 * coordinates, their rates, internal states of forces. Only their columns of J are found, by differences, and only they
 * are factored; the other components follow. NULL: out of memory. A matrix takes one evaluation more than it has
 * columns, and O(columns³); a solution O(columns · size). */
km_newton *km_newton_create(km_simulation *run, void *cvode, SUNContext context);
void km_newton_free(km_newton *newton);

#endif
