/* Linearised equations of motion: text, record and MATLAB's file. */
#include "kmech/report.h"

#include "kinematics/state.h"

#include "report/record/record.h"
#include "topology/mechanism.h"

#include <stdint.h>
#include <string.h>

enum { MOST_NAMED = 3 };

/* The joints that move most in mode k, with their parts of the largest. */
static void add_movers(const km_mechanism *m, const km_linear *l, int k, km_text *out) {
  int n = l->coordinate_count, named[MOST_NAMED], count = 0;
  const double *mode = l->modes + (size_t)k * 2 * (size_t)n;
  for (; count < MOST_NAMED; ++count) {
    double most = 0.05;
    named[count] = -1;
    for (int c = 0; c < n; ++c) {
      double size = m->scale[c] * hypot(mode[c], mode[n + c]);
      bool taken = false;
      for (int i = 0; i < count; ++i)
        taken = taken || named[i] == c;
      if (!taken && size > most) {
        most = size;
        named[count] = c;
      }
    }
    if (named[count] < 0)
      return;
    km_text_format(out, "%s%s %.2f", count ? ", " : "", m->model->coordinates[named[count]].label, most);
  }
}

/* Pairs of conjugate eigenvalues are one line. */
void km_linear_print(const km_mechanism *m, const km_linear *l, km_text *out) {
  if (!m || !l || l->coordinate_count != m->coordinate_count || !out)
    return;
  double second = m->model->units.time->si;
  km_text_format(out, "  %-14s %-12s %-12s %s\n", "frequency Hz", "period s", "damping", "moves");
  for (int k = 0; k < 2 * l->freedom; ++k) {
    double re = l->real[k] / second, im = l->imaginary[k] / second, size = hypot(re, im);
    double damping = fabs(re) > 1e-9 * size ? -re / size : 0.0;
    km_linear_kind kind = km_linear_kind_of(l, k);
    if (im < 0.0)
      continue;
    if (kind == KM_LINEAR_ZERO)
      km_text_format(out, "  %-14s %-12s %-12s ", "0", "-", "-");
    else if (kind == KM_LINEAR_OSCILLATES)
      km_text_format(out, "  %-14.6g %-12.6g %-12.4g ", im / (2.0 * M_PI), 2.0 * M_PI / im, damping);
    else
      km_text_format(out, "  %-14s %-12s %s %-8.4g ", kind == KM_LINEAR_DECAYS ? "dies away" : "grows", "-", "in s",
                     1.0 / fabs(re));
    add_movers(m, l, k, out);
    km_text_add(out, "\n");
  }
}

static void add_matrix(const double *matrix, int rows, int columns, const char *key, km_value *record,
                       km_arena *arena) {
  km_value *list = km_value_add(arena, record, key, KM_LIST);
  for (int r = 0; r < rows && !arena->failed; ++r) {
    km_value *row = km_value_add(arena, list, NULL, KM_LIST);
    for (int c = 0; c < columns && !arena->failed; ++c)
      km_value_number(arena, row, NULL, matrix[(size_t)c * (size_t)rows + (size_t)r]);
  }
}

const km_value *km_linear_record(const km_mechanism *m, const km_state *s, const km_linear *l, const char *tool,
                                 const char *name, km_arena *arena) {
  if (km_check_state(m, s, NULL) || !l || l->coordinate_count != m->coordinate_count || !tool || !name || !arena)
    return NULL;
  km_value *record = km_record_head(m, tool, name, arena);
  km_value_number(arena, record, "freedom", l->freedom);
  km_value *independent = km_value_add(arena, record, "independent", KM_LIST);
  for (int k = 0; k < l->freedom && !arena->failed; ++k)
    km_value_string(arena, independent, NULL, m->model->coordinates[l->independent[k]].label);
  km_value *all = km_value_add(arena, record, "coordinates", KM_LIST);
  for (int c = 0; c < l->coordinate_count && !arena->failed; ++c)
    km_value_string(arena, all, NULL, m->model->coordinates[c].label);
  add_matrix(l->A, 2 * l->freedom, 2 * l->freedom, "A", record, arena);
  add_matrix(l->B, 2 * l->freedom, l->coordinate_count, "B", record, arena);
  add_matrix(l->N, l->coordinate_count, l->freedom, "N", record, arena);
  km_value *values = km_value_add(arena, record, "eigenvalues", KM_LIST);
  for (int k = 0; k < 2 * l->freedom && !arena->failed; ++k) {
    km_value *value = km_value_add(arena, values, NULL, KM_OBJECT);
    km_value_number(arena, value, "real", l->real[k]);
    km_value_number(arena, value, "imaginary", l->imaginary[k]);
  }
  km_value_string(arena, record, "stability", km_stability_name(km_linear_stability(l)));
  km_value_number(arena, record, "residual_acceleration", l->residual);
  km_configuration_record(m, s, record, arena);
  return arena->failed ? NULL : record;
}

static void add_mat(const char *name, const double *values, int rows, int columns, km_text *out) {
  const int32_t head[5] = {0, rows, columns, 0, (int32_t)strlen(name) + 1};
  km_text_bytes(out, head, sizeof head);
  km_text_bytes(out, name, strlen(name) + 1);
  km_text_bytes(out, values, (size_t)rows * (size_t)columns * sizeof *values);
}

void km_linear_mat(const km_linear *l, km_text *out) {
  if (!l || !out)
    return;
  int size = 2 * l->freedom;
  add_mat("A", l->A, size, size, out);
  add_mat("B", l->B, size, l->coordinate_count, out);
  add_mat("N", l->N, l->coordinate_count, l->freedom, out);
  add_mat("eigenvalues_real", l->real, size, 1, out);
  add_mat("eigenvalues_imaginary", l->imaginary, size, 1, out);
}

void km_matrix_csv(const double *matrix, int rows, int columns, km_text *out) {
  if (!matrix || !out)
    return;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (c)
        km_text_add(out, ",");
      km_text_number(out, matrix[(size_t)c * (size_t)rows + (size_t)r]);
    }
    km_text_add(out, "\r\n");
  }
}
