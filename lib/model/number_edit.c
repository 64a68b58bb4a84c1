/* Changes the numbers of a model. */
#include "kmech/model.h"

#include "model/builder.h"
#include "model/geometry/mass_properties.h"

#include <string.h>

static void *copy(km_arena *arena, const void *items, int count, size_t size) {
  void *out = km_arena_alloc(arena, (size_t)count + 1, size);
  if (out && count > 0)
    memcpy(out, items, (size_t)count * size);
  return out;
}

km_status km_model_keep_unedited(km_model *m, km_error *error) {
  if (m->unedited)
    return KM_OK;
  km_arena own = {0}; /* the arena's failure is reset, because the model is unchanged */
  km_unedited *kept = km_arena_alloc(&own, 1, sizeof *kept);
  if (kept)
    *kept = (km_unedited){copy(&own, m->bodies, m->body_count, sizeof *m->bodies),
                          copy(&own, m->frames, m->frame_count, sizeof *m->frames),
                          copy(&own, m->coordinates, m->coordinate_count, sizeof *m->coordinates),
                          copy(&own, m->loads, m->load_count, sizeof *m->loads)};
  if (own.failed) {
    km_arena_free(&own);
    return km_fail(error, KM_MEMORY, "out of memory for a change of the model");
  }
  km_arena_merge(&m->arena, &own);
  m->unedited = kept;
  return KM_OK;
}

static km_status no_element(const char *kind, int index, int count, km_error *error) {
  return km_fail(error, KM_USAGE, "%s %d: expected one of 0 to %d", kind, index, count - 1);
}

static km_status not_finite(km_error *error) {
  return km_fail(error, KM_MODEL, "found a number that is not finite; expected magnitudes up to 1e60");
}

km_status km_model_set_frame(km_model *m, int frame, const double T[3], const double R[9], km_error *error) {
  if (!m || !T || frame < 0 || frame >= m->frame_count)
    return no_element("frame", frame, m ? m->frame_count : 0, error);
  if (!km_builder_sane(T, 3) || (R && !km_builder_sane(R, 9)))
    return not_finite(error);
  km_rotation rotation = m->frames[frame].pose.R;
  double misfit = 0.0;
  km_status status = R ? km_model_rotation(R, &rotation, &misfit, error) : KM_OK;
  if (!status)
    status = km_model_keep_unedited(m, error);
  if (status)
    return status;
  m->frames[frame].pose = (km_pose){rotation, km_vec3_from_array(T)};
  m->rotation_misfit = fmax(m->rotation_misfit, misfit);
  return KM_OK;
}

km_status km_model_set_position(km_model *m, int coordinate, double position, km_error *error) {
  if (!m || coordinate < 0 || coordinate >= m->coordinate_count)
    return no_element("coordinate", coordinate, m ? m->coordinate_count : 0, error);
  if (!km_builder_sane(&position, 1))
    return not_finite(error);
  km_status status = km_model_keep_unedited(m, error);
  if (!status)
    m->coordinates[coordinate].position = position;
  return status;
}

km_status km_model_set_limits(km_model *m, int coordinate, double low, double high, km_error *error) {
  if (!m || coordinate < 0 || coordinate >= m->coordinate_count)
    return no_element("coordinate", coordinate, m ? m->coordinate_count : 0, error);
  if (!(low <= high))
    return km_fail(error, KM_MODEL, "found limits [%g, %g]; expected low ≤ high", low, high);
  km_status status = km_model_keep_unedited(m, error);
  if (status)
    return status;
  m->coordinates[coordinate].low = low;
  m->coordinates[coordinate].high = high;
  return KM_OK;
}

km_status km_model_set_mass(km_model *m, int body, double mass, const double center_of_mass[3], const double inertia[6],
                            km_error *error) {
  if (!m || body < 1 || body >= m->body_count)
    return no_element("body", body, m ? m->body_count : 0, error);
  if (!km_builder_sane(&mass, 1) || (center_of_mass && !km_builder_sane(center_of_mass, 3)) ||
      (inertia && !km_builder_sane(inertia, 6)))
    return not_finite(error);
  if (mass < 0.0)
    return km_fail(error, KM_MODEL, "found a mass of %g; expected at least 0", mass);
  double moments[3] = {0.0, 0.0, 0.0}, size = 0.0;
  for (int k = 0; inertia && k < 6; ++k)
    size = fmax(size, fabs(inertia[k]));
  if (inertia)
    km_principal_moments(inertia, moments);
  if (moments[0] < -1e-9 * size)
    return km_fail(error, KM_MODEL, "a principal moment is negative: %.4g; expected moments of at least 0", moments[0]);
  km_status status = km_model_keep_unedited(m, error);
  if (status)
    return status;
  km_model_body *to = &m->bodies[body];
  to->mass = mass;
  if (center_of_mass)
    to->center_of_mass = km_vec3_from_array(center_of_mass);
  if (inertia)
    memcpy(to->inertia, inertia, sizeof to->inertia);
  return KM_OK;
}

km_status km_model_set_load(km_model *m, int load, const double force[3], const double torque[3], km_error *error) {
  if (!m || load < 0 || load >= m->load_count)
    return no_element("load", load, m ? m->load_count : 0, error);
  if ((force && !km_builder_sane(force, 3)) || (torque && !km_builder_sane(torque, 3)))
    return not_finite(error);
  km_status status = km_model_keep_unedited(m, error);
  if (status)
    return status;
  if (force)
    m->loads[load].force = km_vec3_from_array(force);
  if (torque)
    m->loads[load].torque = km_vec3_from_array(torque);
  return KM_OK;
}
