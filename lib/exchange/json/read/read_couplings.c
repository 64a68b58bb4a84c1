/* Couplings between coordinates. */
#include "exchange/json/read/reader.h"

/* The coordinates of a coupling; false if the coupling goes (left out, or an error was reported). */
static bool coupled(km_reader *reader, const km_value *value, int assembly, const km_place *place,
                    km_model_coupling *coupling) {
  km_place at = {place, "joints", 0};
  km_place item = {&at, NULL, 0};
  size_t errors = km_messages_errors(reader->messages);
  for (const km_value *j = km_value_get(value, "joints")->first; j; j = j->next, ++item.index) {
    int coordinate = km_reader_coordinate(reader, j, assembly, &item);
    if (coordinate == KM_LEFT_OUT)
      km_reader_note(reader, place, "coupling \"%.80s\" is left out with its joint", coupling->name);
    if (coordinate < 0)
      return false;
    if (km_model_turns(reader->model, coordinate))
      km_reader_error(reader, &item, "\"%s\" is a component of a rotation vector; expected a coordinate of its own",
                      reader->model->coordinates[coordinate].label);
    for (int k = 0; k < coupling->count; ++k)
      if (coupling->coordinates[k] == coordinate)
        km_reader_error(reader, &item, "the coupling names this joint twice; expected each joint once");
    coupling->coordinates[coupling->count++] = coordinate;
  }
  return km_messages_errors(reader->messages) == errors;
}

/* Number of nonzero entries. */
static int read_numbers(const km_value *list, double *out) {
  int some = 0;
  for (const km_value *v = list->first; v; v = v->next) {
    some += v->number != 0.0;
    *out++ = v->number;
  }
  return some;
}

static void read_ratios(km_reader *reader, const km_value *value, const km_place *place, km_model_coupling *out) {
  const km_value *joints = km_value_get(value, "joints"), *ratios = km_value_get(value, "ratios");
  km_place at = {place, "ratios", 0};
  if (joints->count == 0 || joints->count != ratios->count) {
    km_reader_error(reader, &at, "found %zu ratios for %zu joints; expected one ratio for each of one or more joints",
                    ratios->count, joints->count);
    return;
  }
  out->ratios = KM_ARENA_NEW(&reader->model->arena, double, ratios->count);
  if (out->ratios && read_numbers(ratios, out->ratios) == 0)
    km_reader_error(reader, &at, "every ratio is 0; expected at least one that isn't");
  out->constant_given = km_value_get(value, "constant") != NULL;
  out->constant = km_reader_number(value, "constant", 0.0);
}

static void read_polynomial(km_reader *reader, const km_value *value, const km_place *place, km_model_coupling *out) {
  const km_value *joints = km_value_get(value, "joints"), *list = km_value_get(value, "polynomial");
  km_place at = {place, "polynomial", 0}, constant = {place, "constant", 0};
  if (joints->count != 2 || list->count == 0) {
    km_reader_error(reader, &at, "found %zu coefficients for %zu joints; expected one or more for two joints",
                    list->count, joints->count);
    return;
  }
  if (km_value_get(value, "constant"))
    km_reader_error(reader, &constant, "found a constant beside a polynomial; expected it as the first coefficient");
  out->polynomial = KM_ARENA_NEW(&reader->model->arena, double, list->count);
  out->polynomial_count = (int)list->count;
  if (out->polynomial)
    read_numbers(list, out->polynomial);
}

static void read_coupling(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  km_model *model = reader->model;
  if (!km_reader_active(value))
    return;
  km_reader_named(reader, value, place);
  size_t count = km_value_get(value, "joints")->count, errors = km_messages_errors(reader->messages);
  bool ratios = km_value_get(value, "ratios") != NULL, polynomial = km_value_get(value, "polynomial") != NULL;
  km_model_coupling coupling = {.name = km_reader_string(value, "name"), .where = km_reader_where(reader, place)};
  coupling.coordinates = KM_ARENA_NEW(&model->arena, int, count);
  if (ratios == polynomial)
    km_reader_error(reader, place, "found %s; expected either \"ratios\" or a \"polynomial\"",
                    ratios ? "\"ratios\" and a \"polynomial\"" : "no law of the coupling");
  else if (ratios)
    read_ratios(reader, value, place, &coupling);
  else
    read_polynomial(reader, value, place, &coupling);
  if (model->arena.failed || km_messages_errors(reader->messages) > errors ||
      !coupled(reader, value, assembly, place, &coupling))
    return;
  reader->origin->couplings[model->coupling_count] = value;
  model->couplings[model->coupling_count++] = coupling;
}

static void couplings_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "couplings", index, place, read_coupling);
}

void km_read_couplings(km_reader *reader, const km_value *root) {
  if (!reader->model->arena.failed)
    km_reader_visit(reader, root, couplings_of);
}
