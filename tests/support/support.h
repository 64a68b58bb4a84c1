/* Test support: models as fixtures, random configurations, an independent Jacobian. */
#ifndef KM_TESTS_SUPPORT_H
#define KM_TESTS_SUPPORT_H

/* cmocka wants these first. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support/evidence.h"

#include "base/text.h"
#include "kinematics/state.h"
#include "kmech/data.h"
#include "kmech/sweep.h"

#include <stdbool.h>

/* A model with its mechanism and an assembled state. */
typedef struct fixture {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
} fixture;

/* Models of models/, without ending; NULL at the end. */
extern const char *const all_models[];
/* True if the model's default sweep drives the only freedom of its substructure. */
bool has_one_freedom(const char *name);

fixture fixture_open(const char *name); /* models/NAME.json */
/* Variant number `seed` of it, whose frames lie up to 0.2 % elsewhere; 0, and where its loops can't be closed: the
 * model itself. */
fixture fixture_open_variant(const char *name, uint64_t seed);
fixture fixture_read(const char *json); /* text */
/* The model of a fixture in other units, by their names; NULL: the unit stays. */
fixture fixture_in_units(const fixture *f, const char *angle, const char *length, const char *mass, const char *time);
fixture fixture_of(km_model *model); /* takes the model */
/* Text of a model with n loops by `write`: lattices.h, chains.h. */
fixture fixture_written(void (*write)(km_text *out, int n), int n);
/* Reads and assembles what may be refused; close the fixture in any case. */
km_status fixture_try(const char *json, fixture *f, km_error *error);
/* The notes about its geometry, one after the other; the caller frees them (km_free). */
char *fixture_notes(fixture *f);
void fixture_close(fixture *f);
char *read_model_text(const char *name); /* the caller frees it (km_free) */
/* A copy of the text where the first `from` behind `place` (NULL: anywhere) is `to`; the caller frees it (km_free). */
char *edited(const char *text, const char *place, const char *from, const char *to);

/* The coordinate of a joint, by its label. */
int fixture_coordinate(const fixture *f, const char *label);
/* A cell of a table, by the column's name without its unit. */
double table_cell(const km_table *table, size_t row, const char *column);

/* A parallelogram with links 2 and 1 (joints A, B, C, D), its crank turned by `angle`; 0 and π are its change points.
 */
fixture parallelogram(double angle);

/* |a − b| ≤ tolerance, and neither is NaN. */
#define assert_near(a, b, tolerance) assert_near_at((a), (b), (tolerance), #a, __FILE__, __LINE__)
void assert_near_at(double a, double b, double tolerance, const char *what, const char *file, int line);
/* A deviation, from 0 to the bound. */
#define assert_at_most(a, bound) assert_near((a), 0.0, (bound))
/* Numbers with the same bits. */
#define assert_same_bits(a, b, count) assert_same_bits_at((a), (b), (count), #a, __FILE__, __LINE__)
void assert_same_bits_at(const double *a, const double *b, size_t count, const char *what, const char *file, int line);

/* Deterministic numbers: splitmix64. */
typedef struct randomness {
  uint64_t state;
} randomness;
double uniform(randomness *r, double low, double high);
int below(randomness *r, int count);

/* Drives random coordinates of every substructure by random amounts; the state stays closed. */
void go_somewhere(fixture *f, randomness *r);

/* Column of a coordinate in the inertial frame, from the bodies' poses: independent of the loop programs. */
km_twist column_in_space(const fixture *f, int coordinate);
/* The whole six-row Jacobian of a substructure (lengths over its size, about its first joint), rows × columns
 * column-major; the caller frees it. rows = 6 · loops + couplings. */
double *whole_jacobian(const fixture *f, int substructure, int *rows);

/* Mobility numbers and rank of a substructure by LAPACKE's SVD of the whole Jacobian. */
int numbers_by_svd(const fixture *f, int substructure, double *numbers);

#endif
