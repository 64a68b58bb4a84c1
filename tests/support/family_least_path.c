/* Random driven motions with several freedoms left, against the path of least motion by small steps. */
#include "support/motion_families.h"
#include "support/random_mechanism.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "model/model.h"

#include <lapacke.h>
#include <stdio.h>
#include <string.h>

/* End of a motion: all coordinates as a scaled step from the start. */
typedef struct ending {
  km_stop stop;
  double step[KM_MAX_FREEDOM * 32];
} ending;

static ending drive(const char *json, int driver, double way, int pieces) {
  fixture f = fixture_read(json);
  const km_substructure *sub = &f.mechanism->substructures[f.mechanism->substructure_of[driver]];
  double *saved = KM_NEW(double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns)),
         from = km_state_coordinate(f.state, driver);
  ending end = {.stop = KM_STOP_NONE};
  km_driver_motion *d;
  km_state_save(f.state, sub, saved);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, driver, true, &d, NULL), KM_OK);
  for (int i = 1; i <= pieces && !end.stop; ++i)
    end.stop = km_driver_motion_move_to(d, from + way * i / pieces).stop;
  km_state_difference(f.state, sub, saved, end.step);
  km_driver_motion_free(d);
  km_free(saved);
  fixture_close(&f);
  return end;
}

/* The scaled rates t with J t = 0, the driver's 1, least in |D t|, by the SVD of the whole Jacobian. */
static bool least_rates(fixture *f, int index, int driver, double *t) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  int rows, n = sub->columns, rank;
  km_poses_compute(m, f->state);
  double *J = whole_jacobian(f, index, &rows);
  int all = rows + 1, ld = all > n ? all : n;
  double *A = KM_NEW(double, (size_t)(all * n)), *b = KM_NEW(double, (size_t)ld), *values = KM_NEW(double, (size_t)ld);
  for (int c = 0; c < n; ++c) {
    for (int r = 0; r < rows; ++r)
      A[c * all + r] = J[c * rows + r] / weight[c];
    A[c * all + rows] = (c == driver) / weight[c];
  }
  b[rows] = 1.0;
  bool solved = LAPACKE_dgelsd(LAPACK_COL_MAJOR, all, n, 1, A, all, b, ld, values, 1e-7, &rank) == 0;
  for (int c = 0; c < n; ++c)
    t[c] = b[c] / weight[c];
  km_free(J);
  km_free(A);
  km_free(b);
  km_free(values);
  return solved && fabs(t[driver] - 1.0) < 1e-6;
}

/* The midpoint rule, closed again after every half step; false where it isn't regular enough to be a truth. */
static bool small_steps(const char *json, int driver, double way, int pieces, double *out) {
  fixture f = fixture_read(json);
  const km_mechanism *m = f.mechanism;
  int index = m->substructure_of[driver], column = m->column_of[driver];
  const km_substructure *sub = &m->substructures[index];
  size_t n = (size_t)sub->columns;
  double *start = KM_NEW(double, 3 * n), *here = KM_NEW(double, 3 * n), *t = KM_NEW(double, n);
  double h = way * km_model_coordinate_factor(f.model, driver) / m->unit[driver] / pieces;
  bool good = true;
  km_state_save(f.state, sub, start);
  for (int i = 0; i < pieces && good; ++i) {
    km_state_save(f.state, sub, here);
    for (int half = 1; half >= 0 && good; --half) {
      km_closure evidence;
      good = least_rates(&f, index, column, t);
      for (size_t k = 0; k < n; ++k) {
        t[k] *= half ? 0.5 * h : h;
        good = good && fabs(t[k]) < 0.05;
      }
      km_state_restore(f.state, sub, here);
      km_state_move(m, f.state, sub, t);
      f.state->pivot_driver[index] = KM_NEVER;
      good = good && km_loops_close(m, f.state, index, column, &evidence) == KM_CLOSED;
    }
  }
  km_state_difference(f.state, sub, start, out);
  km_free(start);
  km_free(here);
  km_free(t);
  fixture_close(&f);
  return good;
}

static double distance(const double *a, const double *b, int count) {
  double far = 0.0;
  for (int k = 0; k < count; ++k)
    far = fmax(far, fabs(a[k] - b[k]));
  return far;
}

/* A coordinate that can drive a substructure with other freedoms; -1: none. */
static int choose_driver(fixture *f, randomness *r, int *columns) {
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_compute(m, f->state, &mobility);
  for (int tries = 0; tries < 20 && m->coordinate_count > 0; ++tries) {
    int c = below(r, m->coordinate_count), index = m->substructure_of[c];
    if (index < 0 || m->held[c] || m->ball_of[c] >= 0 || km_factor_freedom(f->state->factor[index]) < 2 ||
        km_mobility_number(f->state, c) < 0.02)
      continue;
    *columns = m->substructures[index].columns;
    return c;
  }
  return -1;
}

bool family_least_path(uint64_t seed) {
  static const int cuts[] = {1, 5, 10, 300};
  randomness r = {seed};
  char *json = NULL;
  int columns = 0, driver = -1;
  for (int tries = 0; tries < 60 && driver < 0; ++tries) { /* most random mechanisms have one freedom a substructure */
    km_free(json);
    json = random_mechanism(&r, below(&r, 2));
    fixture f = fixture_read(json);
    driver = choose_driver(&f, &r, &columns);
    fixture_close(&f);
  }
  double way = (below(&r, 2) ? 1.0 : -1.0) * uniform(&r, 0.1, 0.8), coarse[192], fine[192];
  bool agrees = true;
  if (driver >= 0 && columns <= 192 && small_steps(json, driver, way, 200, coarse) &&
      small_steps(json, driver, way, 400, fine) && distance(coarse, fine, columns) < 1e-4) {
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts && agrees; ++i) {
      ending end = drive(json, driver, way, cuts[i]);
      double far = distance(end.step, fine, columns);
      agrees = !end.stop && far < 1e-4;
      if (!agrees)
        fprintf(stderr, "least path of seed %llu: coordinate %d by %g in %d pieces: stop %d, %.3g from the truth\n",
                (unsigned long long)seed, driver, way, cuts[i], (int)end.stop, far);
    }
  }
  km_free(json);
  return agrees;
}
