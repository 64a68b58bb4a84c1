/* Columns about the transmission from an input to an output: metrics of the loop, angles of the hinges, joint force
 * index, and quality indices of the Jacobian J D⁻¹ of the input's substructure over the sweep (theory 8.4).
 *
 *   zhang     : √det(J Jᵀ) / max √det(J Jᵀ) = ∏ σ / max ∏ σ
 *   lee_duffy : |det J₋| / max |det J₋|,  J₋ the independent rows of J without the input's column, square with one
 *               freedom;  by Cauchy and Binet |det J₋| = |z_i| ∏ σ,  z the unit null vector
 *
 * The maxima are those of the sweep's rows. Sources: J. Lee, J. Duffy and M. Keller 1996; Y. Zhang (K. Wehage 2016,
 * equations 259 and 260). */
#include "sweep/transmission_columns.h"

#include "kinematics/state.h"
#include "topology/mechanism.h"
#include "transfer/transmission_metrics.h"

#include <math.h>

enum { QUALITY = 2 };
static const char *const quality_names[QUALITY] = {"lee_duffy", "zhang"};

km_status km_transmission_columns_create(const km_mechanism *m, const km_port *input, const km_port *output,
                                         km_transmission_columns *out, km_error *error) {
  *out = (km_transmission_columns){.mechanism = m, .input = input->kind == KM_PORT_JOINT ? input->coordinate : -1};
  const km_status status = km_transmission_create(m, input, output, &out->metrics, error);
  return status ? status : km_joint_transmission_create(m, input, output, &out->joints, error);
}

void km_transmission_columns_free(km_transmission_columns *w) {
  km_joint_transmission_free(w->joints);
  km_transmission_free(w->metrics);
  *w = (km_transmission_columns){0};
}

bool km_transmission_columns_add(km_transmission_columns *w, const km_port *output, km_table *table) {
  bool added = true;
  w->first = km_table_columns(table);
  for (int i = 0; i < KM_METRIC_COLUMNS && added; ++i) {
    const char *unit = km_transmission_unit(w->mechanism->model, output, i);
    added = km_table_add_joined_column(table, km_transmission_name(i), "", "", unit[0] ? unit : NULL);
  }
  added = added && km_joint_transmission_columns(w->joints, table);
  for (int i = 0; i < QUALITY && added; ++i)
    added = km_table_add_joined_column(table, quality_names[i], "", "", NULL);
  return added;
}

/* Size of the input's entry in the unit null vector, z = D q̇ / |D q̇| over the substructure; NaN with several
 * freedoms. */
static double input_entry(const km_transmission_columns *w, const km_state *s, const double *rates) {
  const km_mechanism *m = w->mechanism;
  const int index = w->input < 0 ? -1 : m->substructure_of[w->input];
  if (index < 0 || km_factor_freedom(s->factor[index]) != 1)
    return nan("");
  const km_substructure *sub = &m->substructures[index];
  double sum = 0.0;
  for (int k = 0; k < sub->columns; ++k) {
    const int c = m->column_coordinate[sub->column_start + k];
    sum += m->scale[c] * rates[c] * m->scale[c] * rates[c];
  }
  return fabs(m->scale[w->input] * rates[w->input]) / sqrt(sum);
}

double *km_transmission_columns_write(km_transmission_columns *w, km_state *s, const double *rates, double *cell) {
  km_transmission_compute(w->mechanism, s, w->metrics, &w->last);
  km_transmission_values(&w->last, cell);
  cell += KM_METRIC_COLUMNS;
  w->failed = !km_joint_transmission_compute(s, w->joints, rates, cell) || w->failed;
  cell += km_joint_transmission_count(w->joints);
  cell[0] = input_entry(w, s, rates) * w->last.manipulability.value;
  cell[1] = w->last.manipulability.value;
  return cell + QUALITY;
}

void km_transmission_columns_finish(const km_transmission_columns *w, km_sweep *sweep) {
  const size_t first = w->first + KM_METRIC_COLUMNS + km_joint_transmission_count(w->joints);
  km_table *const tables[2] = {sweep->table, sweep->between};
  for (size_t c = first; c < first + QUALITY; ++c) {
    const size_t row = km_table_extreme_row(sweep->table, c, -1.0);
    const double most = row < km_table_rows(sweep->table) ? km_table_row(sweep->table, row)[c] : nan("");
    for (int i = 0; i < 2; ++i)
      for (size_t r = 0; r < km_table_rows(tables[i]); ++r)
        km_table_cells(tables[i], r)[c] /= most;
  }
}
