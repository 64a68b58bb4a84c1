/* Units and their conversion. */
#include "model/units.h"

#include "model/model.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static const km_unit angles[] = {{"radians", "rad", 1.0}, {"degrees", "deg", M_PI / 180.0}, {0}};
static const km_unit lengths[] = {
    {"meters", "m", 1.0}, {"millimeters", "mm", 1e-3}, {"centimeters", "cm", 1e-2}, {"inches", "in", 0.0254}, {0}};
static const km_unit masses[] = {{"kilograms", "kg", 1.0}, {"grams", "g", 1e-3}, {"pounds", "lb", 0.45359237}, {0}};
static const km_unit times[] = {{"seconds", "s", 1.0}, {"milliseconds", "ms", 1e-3}, {0}};
static const km_unit forces[] = {{"newtons", "N", 1.0}, {"pounds-force", "lbf", 4.4482216152605}, {0}};

static const km_unit *const tables[KM_QUANTITIES] = {angles, lengths, masses, times, forces};

static bool is_quantity(km_quantity quantity) {
  return (int)quantity >= 0 && quantity < KM_QUANTITIES;
}

km_units km_units_default(void) {
  return (km_units){angles, lengths, masses, times, forces};
}

const char *km_quantity_name(km_quantity quantity) {
  if (!is_quantity(quantity))
    return "";
  static const char *const names[KM_QUANTITIES] = {"angle", "length", "mass", "time", "force"};
  return names[quantity];
}

const km_unit *km_quantity_units(km_quantity quantity) {
  return tables[quantity];
}

const km_unit *km_unit_find(km_quantity quantity, const char *word) {
  if (!is_quantity(quantity) || !word)
    return NULL;
  for (const km_unit *unit = tables[quantity]; unit->word; ++unit)
    if (strcmp(unit->word, word) == 0 || strcmp(unit->suffix, word) == 0)
      return unit;
  return NULL;
}

const km_unit **km_units_slot(km_units *units, km_quantity quantity) {
  if (!units || !is_quantity(quantity))
    return NULL;
  const km_unit **slots[KM_QUANTITIES] = {&units->angle, &units->length, &units->mass, &units->time, &units->force};
  return slots[quantity];
}

km_dimension km_dimension_product(km_dimension a, km_dimension b) {
  return (km_dimension){(signed char)(a.angle + b.angle), (signed char)(a.length + b.length),
                        (signed char)(a.mass + b.mass), (signed char)(a.time + b.time),
                        (signed char)(a.force + b.force)};
}

km_dimension km_dimension_power(km_dimension a, int n) {
  return (km_dimension){(signed char)(n * a.angle), (signed char)(n * a.length), (signed char)(n * a.mass),
                        (signed char)(n * a.time), (signed char)(n * a.force)};
}

double km_units_factor(const km_units *units, km_dimension d) {
  if (!units || !units->angle || !units->length || !units->mass || !units->time || !units->force)
    return nan("");
  return pow(units->angle->si, d.angle) * pow(units->length->si, d.length) * pow(units->mass->si, d.mass) *
         pow(units->time->si, d.time) * pow(units->force->si, d.force);
}

double km_inertial_factor(const km_model *model) {
  static const km_dimension inertial = {.length = 1, .mass = 1, .time = -2, .force = -1};
  return km_units_factor(&model->units, inertial);
}
