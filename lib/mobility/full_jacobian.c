/* Jacobian with six rows per loop in the inertial frame (theory 7.1); motion spaces omit the dependent ones. */
#include "mobility/full_jacobian.h"

#include "kinematics/loop_equations.h"

#include <string.h>

static void write_loop_rows(const km_mechanism *m, const km_substructure *sub, int loop, const km_twist *twist,
                            km_vec3 about, int rows, double *J) {
  const km_topology *t = &m->topology;
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i) {
    const km_member *member = &t->member[i];
    int entries = m->model->joints[member->joint].first_coordinate;
    for (int c = entries; c < entries + km_model_freedom(m->model, member->joint); ++c) {
      if (m->column_of[c] < 0)
        continue;
      double column[6], sign = km_member_sign(member);
      km_twist_entries(sub, twist[c], about, m->unit[c], column);
      for (int r = 0; r < 6; ++r)
        J[(size_t)m->column_of[c] * (size_t)rows + (size_t)r] = sign * column[r];
    }
  }
}

void km_coupling_entries(const km_mechanism *m, const km_state *s, const km_substructure *sub, double *entries,
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

void km_full_jacobian(const km_mechanism *m, const km_state *s, int index, const km_twist *twist, km_vec3 about,
                      double *J) {
  const km_topology *t = &m->topology;
  const km_substructure *sub = &m->substructures[index];
  int rows = 6 * sub->loop_count + sub->coupling_count;
  memset(J, 0, (size_t)rows * (size_t)sub->columns * sizeof *J);
  for (int i = 0; i < sub->loop_count; ++i)
    write_loop_rows(m, sub, t->loop[t->loop_start[index] + i], twist, about, rows, J + 6 * i);
  km_coupling_entries(m, s, sub, J + 6 * sub->loop_count, 1, (size_t)rows);
}
