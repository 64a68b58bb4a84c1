/* Recomputes every joint by textbook matrices, apart from the library's: X_child = X_parent · motion(q). */
#include "judge.h"

#include "kmech/inspect.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "kmech/model.h"

#include <math.h>

#include <string.h>

/* A rotation by rows, and a place. */
typedef struct km_frame_pose place;

static place turned(const double axis[3], double angle) { /* Rodrigues */
  place x = {{0}, {0}};
  double c = cos(angle), s = sin(angle);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      x.R[3 * i + k] = (i == k) * c + (1.0 - c) * axis[i] * axis[k];
  x.R[1] -= s * axis[2], x.R[2] += s * axis[1], x.R[5] -= s * axis[0];
  x.R[3] += s * axis[2], x.R[6] -= s * axis[1], x.R[7] += s * axis[0];
  return x;
}

static place moved(int axis, double length) {
  place x = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}};
  x.p[axis] = length;
  return x;
}

static place about(int axis, double angle) {
  double u[3] = {0};
  u[axis] = 1.0;
  return turned(u, angle);
}

static place by_vector(const double v[3]) {
  double angle = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double u[3] = {angle > 0.0 ? v[0] / angle : 1.0, angle > 0.0 ? v[1] / angle : 0.0,
                       angle > 0.0 ? v[2] / angle : 0.0};
  return turned(u, angle);
}

static place product(const place *a, const place *b) {
  place x;
  for (int i = 0; i < 3; ++i) {
    x.p[i] = a->p[i];
    for (int k = 0; k < 3; ++k) {
      x.R[3 * i + k] = 0.0;
      x.p[i] += a->R[3 * i + k] * b->p[k];
      for (int n = 0; n < 3; ++n)
        x.R[3 * i + k] += a->R[3 * i + n] * b->R[3 * n + k];
    }
  }
  return x;
}

static place then(place a, place b) {
  return product(&a, &b);
}

/* False if it can't be determined from outside: a screw's pitch. */
static bool motion_of(km_joint_type type, const double *q, place *out) {
  *out = moved(0, 0.0);
  if (type <= KM_RZ)
    *out = about((int)type, q[0]);
  else if (type <= KM_TZ)
    *out = moved((int)type - (int)KM_TX, q[0]);
  else if (type == KM_SPHERICAL)
    *out = by_vector(q);
  else if (type == KM_FLOAT)
    *out = then(then(then(moved(0, q[0]), moved(1, q[1])), moved(2, q[2])), by_vector(q + 3));
  else if (type == KM_CYLINDRICAL)
    *out = then(moved(2, q[0]), about(2, q[1]));
  else if (type == KM_UNIVERSAL)
    *out = then(about(0, q[0]), about(1, q[1]));
  else if (type == KM_PLANAR)
    *out = then(then(moved(0, q[0]), moved(1, q[1])), about(2, q[2]));
  return type != KM_SCREW;
}

static double farthest(const place *a, const place *b) {
  double most = 0.0;
  for (int k = 0; k < 3; ++k)
    most = fmax(most, fmax(fabs(a->p[k]), fabs(b->p[k])));
  return most;
}

/* Distance of a frame from its body's origin, by components, which determines the rounding of its position. */
static double reach(const km_model *model, int frame) {
  double R[9], T[3] = {0};
  if (km_model_frame_pose(model, frame, R, T, NULL))
    fuzz_fail("a joint's frame isn't in the model");
  return fmax(fabs(T[0]), fmax(fabs(T[1]), fabs(T[2])));
}

/* True if the pins of a planar loop lie at different heights, by which the frames of a joint then differ. */
static bool has_offset_pins(const km_mechanism *mechanism, km_state *state) {
  km_messages *notes = km_messages_create();
  km_geometry_notes(mechanism, state, notes);
  bool has = km_messages_count(notes) > 0;
  km_messages_free(notes);
  return has;
}

void fuzz_closed(const km_model *model, const km_mechanism *mechanism, km_state *state, double residual) {
  double unit = km_model_units(model).angle->si, size = 0.0, gap = 0.0, turn = 0.0, angle = 0.0;
  for (int j = 0; j < km_model_joint_count(model); ++j) {
    int first = 0, freedom = km_model_joint_freedom(model, j, &first);
    double q[KM_MAX_FREEDOM] = {0};
    place from, to, motion;
    for (int k = 0; k < freedom; ++k) {
      bool length = km_model_coordinate_is_length(model, first + k);
      q[k] = km_state_coordinate(state, first + k) * (length ? 1.0 : unit);
      angle = length ? angle : fmax(angle, fabs(q[k]));
      size = length ? fmax(size, fabs(q[k])) : size;
    }
    if (km_frame_place(mechanism, state, km_model_joint_frame(model, j, false), &from, NULL) ||
        km_frame_place(mechanism, state, km_model_joint_frame(model, j, true), &to, NULL))
      fuzz_fail("a joint's frame has no place");
    if (!motion_of((km_joint_type)km_model_joint_type(model, j), q, &motion))
      continue;
    place there = product(&from, &motion);
    size = fmax(size, farthest(&from, &to));
    for (int side = 0; side < 2; ++side)
      size = fmax(size, reach(model, km_model_joint_frame(model, j, side)));
    for (int k = 0; k < 3; ++k)
      gap = fmax(gap, fabs(there.p[k] - to.p[k]));
    for (int k = 0; k < 9; ++k)
      turn = fmax(turn, fabs(there.R[k] - to.R[k]));
  }
  double tolerance =
      10.0 * residual + 1e-9 + 1e-14 * angle; /* lengths of loops are over their size, at most this one */
  if ((!(gap <= tolerance * size) && !has_offset_pins(mechanism, state)) || !(turn <= tolerance))
    fuzz_fail("a joint's own motion doesn't lead from one of its frames to the other");
}
