/* Random inertias: positive semidefinite ones are a body's, the others aren't. */
#include "support/motion_families.h"
#include "support/support.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "model/units.h"

#include <stdio.h>
#include <string.h>

static const char *const unit_words[5][4] = {[KM_ANGLE] = {"radians", "degrees"},
                                             [KM_LENGTH] = {"meters", "millimeters", "inches"},
                                             [KM_MASS] = {"kilograms", "grams", "pounds"},
                                             [KM_TIME] = {"seconds", "milliseconds"},
                                             [KM_FORCE] = {"newtons", "pounds-force"}};

static const char *any_unit(randomness *r, int quantity) {
  int count = 0;
  while (unit_words[quantity][count])
    ++count;
  return unit_words[quantity][below(r, count)];
}

/* Σ λ_k u_k u_kᵀ, u orthonormal by a random rotation. */
static void compose(randomness *r, const double moments[3], double I[6]) {
  km_vec3 turn = {uniform(r, -3, 3), uniform(r, -3, 3), uniform(r, -3, 3)};
  km_rotation R = km_quaternion_rotation(km_quaternion_exp(turn));
  memset(I, 0, 6 * sizeof *I);
  for (int k = 0; k < 3; ++k) {
    km_vec3 u = R.axis[k];
    const double products[6] = {u.x * u.x, u.y * u.y, u.z * u.z, u.x * u.y, u.y * u.z, u.z * u.x};
    for (int i = 0; i < 6; ++i)
      I[i] += moments[k] * products[i];
  }
}

static km_status read_with(randomness *r, const double I[6], double mass, double length, km_model **model) {
  char text[2048];
  snprintf(text, sizeof text,
           "{\"model_parameters\": {\"units\": {\"length\": \"%s\", \"mass\": \"%s\", \"angle\": \"%s\"}}, "
           "\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": %.17g, \"frames\": [{\"name\": "
           "\"f\", \"T\": [%.17g, 0, 0]}], \"moment_of_inertia\": {\"Ixx\": %.17g, \"Iyy\": %.17g, \"Izz\": %.17g, "
           "\"Ixy\": %.17g, \"Iyz\": %.17g, \"Izx\": %.17g}}], \"joints\": [{\"name\": \"J\", \"type\": \"Rx\", "
           "\"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}",
           any_unit(r, KM_LENGTH), any_unit(r, KM_MASS), any_unit(r, KM_ANGLE), mass, length, I[0], I[1], I[2], I[3],
           I[4], I[5]);
  return km_model_read(text, strlen(text), NULL, model, NULL);
}

/* The model's text in other units, read again. */
static bool reads_in(randomness *r, km_model **model) {
  km_units units = km_units_default();
  for (int quantity = 0; quantity < KM_QUANTITIES; ++quantity)
    *km_units_slot(&units, (km_quantity)quantity) = km_unit_find((km_quantity)quantity, any_unit(r, quantity));
  km_arena arena = {0};
  km_text text = {0};
  const km_value *tree;
  bool good = !km_model_convert(*model, &units, NULL, false, &arena, &tree, NULL);
  if (good)
    km_json_write(tree, &text);
  km_model_free(*model);
  *model = NULL;
  good = good && !km_model_read(text.data, text.size, NULL, model, NULL);
  km_text_free(&text);
  km_arena_free(&arena);
  return good;
}

bool family_inertia(uint64_t seed) {
  randomness r = {seed};
  int rank = below(&r, 4);
  double mass = pow(10.0, uniform(&r, -6, 4)), length = pow(10.0, uniform(&r, -4, 3)), moments[3] = {0}, I[6];
  double size = mass * length * length * pow(10.0, uniform(&r, -4, 0));
  for (int k = 0; k < rank; ++k)
    moments[k] = size * pow(10.0, uniform(&r, -3, 0));
  bool good = below(&r, 3) > 0 || rank == 0;
  if (!good)
    moments[2] = -size * pow(10.0, uniform(&r, -6, 0));
  compose(&r, moments, I);
  if (rank == 0 && below(&r, 2)) /* residue of cancelled moments */
    I[5] = 2.4e-16 * mass * length * length;
  km_model *model = NULL;
  bool accepted = !read_with(&r, I, mass, length, &model);
  bool agrees = accepted == good;
  for (int times = 0; times < 4 && agrees && accepted; ++times)
    agrees = reads_in(&r, &model);
  km_model_free(model);
  if (!agrees)
    fprintf(stderr, "inertia of seed %llu, rank %d, %s: %.17g %.17g %.17g %.17g %.17g %.17g\n",
            (unsigned long long)seed, rank, good ? "refused" : "accepted", I[0], I[1], I[2], I[3], I[4], I[5]);
  return agrees;
}
