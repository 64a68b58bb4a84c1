/* Mechanisms with masses and rates, and d'Alembert's principle as a judge of accelerations. */
#ifndef KM_TESTS_MOVING_H
#define KM_TESTS_MOVING_H

#include "support/support.h"

#include "kmech/dynamics.h"
#include "kmech/model.h"

/* A fixture with its equations of motion. */
typedef struct moving {
  fixture f;
  km_forces *forces;
  km_dynamics *dynamics;
} moving;

/* Takes the fixture. */
moving moving_of(fixture f);
void moving_close(moving *m);

/* Runs a model with its own gravity to a time, by an error tolerance, with its reactions on request; every status is
 * asserted. The caller frees the result (km_history_free). */
km_history history_of(fixture *f, double until, double every, double tolerance, bool reactions);
/* A cell of a column, in a row or in the last one; the column must be there. */
double history_entry(const km_history *history, size_t row, const char *column);
double history_end(const km_history *history, const char *column);

/* Random masses, centres of mass and inertias for every body; gravity that the mechanism feels. */
void give_masses(km_model *model, randomness *r);
/* Random rates that keep the loops. */
void give_rates(moving *m, randomness *r);

/* After km_dynamics_accelerate: the power of applied forces less the rates of the bodies' momenta over every null
 * vector of the loops and every free coordinate, the largest over the largest single part of it. The momenta are
 * differentiated along q(t) by central differences of ±`step`: the error is of the order step². */
double dalembert(moving *m, double step);

#endif
