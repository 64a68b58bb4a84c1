/* Jacobian with six rows per loop in the inertial frame (theory 7.1); motion spaces omit the dependent ones. */
#include "mobility/full_jacobian.h"

#include "kinematics/loop_equations.h"

#include <string.h>

/* Writes the couplings' entries: coupling i and a column at entries[i · row_stride + column · column_stride]. */
static void write_couplings(const km_mechanism *m, const km_state *s, const km_substructure *sub, double *entries,
                            size_t row_stride, size_t column_stride) {
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      if (term->column >= 0)
        km_term_value(m, s, term, &entries[(size_t)i * row_stride + (size_t)term->column * column_stride]);
    }
  }
}

/* The columns of a joint are written into the rows of every loop through it. */
void km_full_jacobian(const km_mechanism *m, const km_state *s, int index, const km_twist *twist, km_vec3 about,
                      size_t row_stride, size_t column_stride, double *J) {
  const km_topology *t = &m->topology;
  const km_substructure *sub = &m->substructures[index];
  size_t loop_rows = 6 * (size_t)sub->loop_count;
  memset(J, 0, (loop_rows + (size_t)sub->coupling_count) * (size_t)sub->columns * sizeof *J);
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k], joint = m->model->coordinates[c].joint;
    double entry[6];
    km_twist_entries(sub, twist[c], about, m->unit[c], entry);
    for (int i = t->joint_loop_start[joint]; i < t->joint_loop_start[joint + 1]; ++i) {
      double *to = J + 6 * (size_t)t->joint_loop[i].loop * row_stride + (size_t)k * column_stride;
      for (size_t r = 0; r < 6; ++r)
        to[r * row_stride] = t->joint_loop[i].sign * entry[r];
    }
  }
  write_couplings(m, s, sub, J + loop_rows * row_stride, row_stride, column_stride);
}
