/* Masses and inertias: as the file states them, or from a mesh and a density. */
#include "exchange/json/reader.h"
#include "model/mass_properties.h"

/* The mesh is weighed later, when the model's folder and include_dir are known to be good. */
static void read_density(km_reader *reader, const km_value *value, const km_place *place, const km_model_body *body) {
  static const char *const instead[] = {"mass", "center_of_mass", "moment_of_inertia", NULL};
  km_place density = {place, "density", 0};
  km_reader_positive(reader, place, "density", body->density);
  if (body->density > 0.0 && !km_value_get(value, "definition"))
    km_reader_error(reader, &density, "there is no mesh to go with it; expected a definition");
  for (const char *const *key = instead; *key; ++key) {
    km_place given = {place, *key, 0};
    if (km_value_get(value, *key))
      km_reader_warning(reader, &given, "doesn't count: density and mesh give it");
  }
}

void km_read_mass(km_reader *reader, const km_value *value, const km_place *place, km_model_body *body) {
  static const char *const keys[6] = {"Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Izx"};
  const km_value *inertia = km_value_get(value, "moment_of_inertia");
  body->mass = km_reader_number(value, "mass", 0.0);
  body->center_of_mass = km_reader_vector(value, "center_of_mass");
  body->density = km_reader_number(value, "density", -1.0);
  for (int k = 0; k < 6; ++k)
    body->inertia[k] = km_reader_number(inertia, keys[k], 0.0);
  km_place mass = {place, "mass", 0};
  if (body->mass < 0.0)
    km_reader_error(reader, &mass, "found %s; expected a mass of at least 0", KM_SHOWN(body->mass));
  if (km_value_get(value, "density"))
    read_density(reader, value, place, body);
}

/* How far the model reaches: the greatest distance of a frame or a centre of mass from its body's origin. */
static double reach(const km_model *model) {
  double far = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    far = fmax(far, km_vec3_norm(model->frames[f].pose.p));
  for (int b = 1; b < model->body_count; ++b)
    far = fmax(far, km_vec3_norm(model->bodies[b].center_of_mass));
  return far;
}

/* A principal moment below zero by less than this is rounding: of the matrix's own entries, or of moments m·l² about a
 * far point that should have cancelled. A light body may have been cut from a heavy one. */
static double moment_rounding(const km_model_body *body, double heaviest, double far) {
  double size = 0.0;
  for (int k = 0; k < 6; ++k)
    size = fmax(size, fabs(body->inertia[k]));
  return 1e-9 * size + 1e-12 * fmax(body->mass, 1e-3 * heaviest) * far * far;
}

void km_read_inertias(km_reader *reader) {
  const km_model *model = reader->model;
  double heaviest = 0.0, far = reach(model), moments[3];
  for (int b = 1; b < model->body_count; ++b)
    heaviest = fmax(heaviest, model->bodies[b].mass);
  for (int b = 1; b < model->body_count; ++b) {
    const km_model_body *body = &model->bodies[b];
    km_principal_moments(body->inertia, moments);
    if (moments[0] < -moment_rounding(body, heaviest, far))
      km_messages_add(reader->messages, KM_ERROR,
                      "%s.moment_of_inertia: a principal moment is negative: %.4g, beside %.4g and %.4g; expected "
                      "moments of at least 0",
                      body->where, moments[0], moments[1], moments[2]);
  }
}
