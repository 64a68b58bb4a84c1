/* A number of a design in a compiled mechanism (space/design_number.h). */
#include "space/design_number.h"

#include "kmech/model.h"

#include <math.h>
#include <string.h>

/* Reads the model with the number. */
static km_status read_model(const km_design_number *n, double value, km_model **out, km_error *error) {
  const km_assignment assignment = {n->path, value};
  const km_read_def definition = {.file = n->file, .assignments = &assignment, .assignment_count = 1};
  return km_model_read_as(n->bytes.data, n->bytes.size, &definition, NULL, out, error);
}

/* Compiles the model with the held joints of `like`. */
static km_status compile(km_design_number *n, const km_mechanism *like, const km_state *at, km_error *error) {
  km_hold *holds = KM_NEW(km_hold, (size_t)like->coordinate_count + 1);
  int count = 0;
  if (!holds)
    return km_fail(error, KM_MEMORY, "out of memory for a number of the design");
  for (int c = 0; c < like->coordinate_count; ++c)
    if (like->held[c])
      holds[count++] = (km_hold){c, km_state_value(at, c)};
  km_status status = km_mechanism_compile(n->model, holds, count, &n->m, error);
  km_free(holds);
  return status;
}

km_status km_design_number_open(const km_mechanism *like, const km_state *at, int substructure, const char *file,
                                const char *path, km_design_number *n, km_error *error) {
  *n = (km_design_number){.path = path, .file = file, .substructure = substructure};
  bool is_plain;
  km_status status = km_file_read(file, &n->bytes, error);
  if (!status)
    status = km_model_read_numbers(n->bytes.data, n->bytes.size, &n->path, 1, &n->value, &is_plain, error);
  if (!status)
    status = read_model(n, n->value, &n->model, error);
  if (!status && n->model->coordinate_count != like->coordinate_count)
    status = km_fail(error, KM_USAGE, "%s isn't the file of the mechanism", file);
  if (!status)
    status = compile(n, like, at, error);
  if (!status)
    status = km_state_create(n->m, &n->s, error);
  if (status)
    return status;
  km_model_numbers_list(n->model, &n->numbers);
  n->saved = KM_NEW(double, (size_t)(KM_SAVED_PER_COLUMN * n->m->substructures[substructure].columns) + 1);
  n->q = KM_NEW(double, (size_t)n->m->coordinate_count + 1);
  bool is_ok = !n->numbers.failed && n->saved && n->q;
  for (int i = 0; i < KM_READ_NUMBERS; ++i) {
    n->read[i] = (km_read_numbers){nan(""), KM_NEW(double, n->numbers.count + 1)};
    is_ok = is_ok && n->read[i].numbers;
  }
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for a number of the design");
  km_state_copy(n->m, n->s, at);
  return KM_OK;
}

void km_design_number_close(km_design_number *n) {
  km_model_numbers_free(&n->numbers);
  km_free(n->saved);
  km_free(n->q);
  for (int i = 0; i < KM_READ_NUMBERS; ++i)
    km_free(n->read[i].numbers);
  km_state_free(n->s);
  km_mechanism_free(n->m);
  km_model_free(n->model);
  km_text_free(&n->bytes);
  *n = (km_design_number){0};
}

/* Returns the numbers of the model with this value; NULL: n->status states why not. */
static const double *numbers_at(km_design_number *n, double value) {
  for (int i = 0; i < KM_READ_NUMBERS; ++i)
    if (n->read[i].value == value)
      return n->read[i].numbers;
  km_read_numbers *at = &n->read[n->oldest];
  km_model *variant = NULL;
  km_model_numbers numbers = {0};
  n->status = read_model(n, value, &variant, NULL);
  if (!n->status)
    km_model_numbers_list(variant, &numbers);
  if (!n->status)
    n->status = numbers.failed ? KM_MEMORY : numbers.count == n->numbers.count ? KM_OK : KM_PARTIAL;
  for (size_t i = 0; !n->status && i < numbers.count; ++i)
    at->numbers[i] = *numbers.items[i].at;
  at->value = n->status ? nan("") : value;
  n->oldest = (n->oldest + 1) % KM_READ_NUMBERS;
  km_model_numbers_free(&numbers);
  km_model_free(variant);
  return n->status ? NULL : at->numbers;
}

bool km_design_number_set(km_design_number *n, double value) {
  n->status = KM_OK;
  if (value == n->value)
    return true;
  const double *numbers = numbers_at(n, value);
  if (!numbers)
    return false;
  km_state_save(n->s, &n->m->substructures[n->substructure], n->saved);
  memcpy(n->q, n->s->q, (size_t)n->m->coordinate_count * sizeof *n->q);
  for (size_t i = 0; i < n->numbers.count; ++i)
    *n->numbers.items[i].at = numbers[i];
  n->status = km_mechanism_renumber(n->m, NULL);
  n->value = n->status ? nan("") : value; /* the mechanism still has its last numbers, the model not */
  km_state_restart(n->s);
  for (int c = 0; c < n->m->coordinate_count; ++c)
    if (n->m->ball_of[c] < 0)
      n->s->q[c] = n->q[c];
  km_state_restore(n->s, &n->m->substructures[n->substructure], n->saved);
  return !n->status;
}
