/* Masses and inertias: as the file states them, or from a mesh and a density. */
#include "exchange/json/read/reader.h"

static bool shapes_weigh(const km_value *body) {
  const km_value *shapes = km_value_get(body, "shapes");
  for (const km_value *s = shapes ? shapes->first : NULL; s; s = s->next)
    if (km_value_get(s, "density"))
      return true;
  return false;
}

static void read_density(km_reader *reader, const km_value *value, const km_place *place, const km_model_body *body) {
  km_place density = {place, "density", 0};
  km_reader_positive(reader, place, "density", body->density);
  if (body->density > 0.0 && !km_value_get(value, "definition"))
    km_reader_error(reader, &density, "there is no mesh to go with it; expected a definition");
}

/* Mass properties from a density are computed later, when the model's folder and include_dir have been checked. */
static void warn_stated(km_reader *reader, const km_value *value, const km_place *place) {
  static const char *const instead[] = {"mass", "center_of_mass", "moment_of_inertia", NULL};
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
  if (km_value_get(value, "density") || shapes_weigh(value))
    warn_stated(reader, value, place);
}
