/* Matrices with a border, for tests. */
#include "support/bordered.h"

#include "kinematics/body_poses.h"

km_wrench applied_to(const km_forces *forces, int body) {
  double w[6];
  km_forces_on_body(forces, body, w);
  return (km_wrench){km_vec3_from_array(w), km_vec3_from_array(w + 3)};
}

static void fill_joint(const km_mechanism *m, const km_state *s, double reach, bordered *e, int j) {
  const km_model *model = m->model;
  const km_model_joint *joint = &model->joints[j];
  const km_model_frame *frame = &model->frames[joint->frame[1]];
  km_pose X = km_pose_product(&s->pose[frame->body], &frame->pose);
  size_t ld = (size_t)e->rows;
  for (int k = 0; k < 6; ++k) {
    km_vec3 axis = X.R.axis[k % 3], none = {0, 0, 0};
    km_wrench w = k < 3 ? km_wrench_at(axis, none, X.p) : (km_wrench){none, axis};
    const double parts[6] = {w.f.x, w.f.y, w.f.z, w.t.x / reach, w.t.y / reach, w.t.z / reach};
    double *column = e->A + (size_t)(6 * j + k) * ld;
    for (int end = 0; end < 2; ++end) {
      int body = model->frames[joint->frame[end]].body;
      for (int i = 0; i < 6 && body > 0; ++i)
        column[6 * (body - 1) + i] = (end ? 1.0 : -1.0) * parts[i];
    }
    for (int c = joint->first_coordinate; c < joint->first_coordinate + km_model_freedom(model, j); ++c) {
      km_twist h = km_coordinate_twist(m, s, c);
      column[6 * (model->body_count - 1) + c] = km_wrench_power(w, h);
    }
  }
}

bordered bordered_make(const km_mechanism *m, const km_state *s, const km_forces *forces, const double *held,
                       double reach) {
  const km_model *model = m->model;
  int bodies = model->body_count - 1;
  bordered e = {.rows = 6 * bodies + model->coordinate_count,
                .columns = 6 * model->joint_count + model->coupling_count};
  e.A = KM_NEW(double, (size_t)e.rows *(size_t)e.columns);
  e.rhs = KM_NEW(double, (size_t)(e.rows > e.columns ? e.rows : e.columns));
  for (int j = 0; j < model->joint_count; ++j)
    fill_joint(m, s, reach, &e, j);
  for (int i = 0; i < model->coupling_count; ++i)
    for (int k = 0; k < model->couplings[i].count; ++k)
      e.A[(size_t)(6 * model->joint_count + i) * (size_t)e.rows +
          (size_t)(6 * bodies + model->couplings[i].coordinates[k])] = -model->couplings[i].ratios[k];
  for (int body = 1; body <= bodies; ++body) {
    km_wrench w = applied_to(forces, body);
    const double parts[6] = {w.f.x, w.f.y, w.f.z, w.t.x / reach, w.t.y / reach, w.t.z / reach};
    for (int i = 0; i < 6; ++i)
      e.rhs[6 * (body - 1) + i] = -parts[i];
  }
  for (int c = 0; c < model->coordinate_count; ++c)
    e.rhs[6 * bodies + c] = held[c] + km_forces_in_joint(forces, c);
  return e;
}

void bordered_free(bordered *e) {
  km_free(e->A);
  km_free(e->rhs);
}
