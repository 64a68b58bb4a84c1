/* Mechanisms from models: where no link has a length, the assembled pose gives the characteristic length. */
#include "kinematics/body_poses.h"

#include "base/arguments.h"
#include "base/memory.h"
#include "topology/compile.h"

#include <stdlib.h>

/* A joint's place and its distance from the middle of all. */
typedef struct place {
  km_vec3 p;
  double radius;
} place;

static int by_radius(const void *a, const void *b) {
  double x = ((const place *)a)->radius, y = ((const place *)b)->radius;
  return (x < y) - (x > y);
}

/* The greatest distance between two of the places, outermost first: two are no further apart than the sum of their radii. */
static double greatest_distance(place *places, int count, double grain) {
  const double rounding = 1.0 + 1e-9; /* of the radii */
  double furthest = 0.0;
  qsort(places, (size_t)count, sizeof *places, by_radius);
  for (int j = 0; j < count; ++j)
    for (int k = 0; k < j; ++k) {
      if ((places[j].radius + places[k].radius) * rounding <= fmax(furthest, grain))
        break;
      furthest = fmax(furthest, sqrt(km_squared_distance(places[j].p, places[k].p, grain)));
    }
  return furthest;
}

/* The greatest distance between two joints in the assembled pose; 0 if that is rounding, or the loops don't close. */
static double joints_apart(const km_mechanism *m) {
  km_state *s = NULL;
  const int count = m->model->joint_count;
  double furthest = 0.0;
  place *places = KM_NEW(place, (size_t)count + 1);
  if (places && !km_state_create(m, &s, NULL) && !km_assemble(m, s, NULL, NULL)) {
    km_vec3 middle = {0, 0, 0};
    km_poses_compute(m, s);
    for (int j = 0; j < count; ++j) {
      places[j].p = km_joint_pose(m, s, j).p;
      middle = km_vec3_add(middle, km_vec3_scale(1.0 / count, places[j].p));
    }
    for (int j = 0; j < count; ++j)
      places[j].radius = km_vec3_norm(km_vec3_sub(places[j].p, middle));
    furthest = greatest_distance(places, count, m->position_rounding);
  }
  km_state_free(s);
  km_free(places);
  return furthest;
}

km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(model != NULL, "model", error);
  if (fits)
    return fits;
  km_compiling how = {.holds = holds, .hold_count = hold_count};
  km_status status = km_mechanism_compile_as(model, &how, out, error);
  if (status || (*out)->length_source != KM_LENGTH_UNIT)
    return status;
  how.length = joints_apart(*out);
  how.length_source = KM_LENGTH_JOINTS;
  if (how.length == 0.0)
    return KM_OK;
  km_mechanism_free(*out);
  return km_mechanism_compile_as(model, &how, out, error);
}
