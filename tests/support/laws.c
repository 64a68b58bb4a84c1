#include "support/laws.h"

#include "analysis/mobility.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"
#include "kinematics/poses.h"

#include <string.h>

/* Central differences with h = 1e-5 err by h²·|e'''|/6 ≈ 2e-11·(a few) and by 1e-16/h = 1e-11. */
void law_jacobian(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  const double h = 1e-5;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
    km_loops_update(m, f->state, sub);
    double *J = KM_NEW(double, rows *columns), *saved = KM_NEW(double, 3 * columns), *step = KM_NEW(double, columns);
    double *plus = KM_NEW(double, rows);
    km_state_jacobian_dense(f->state, sub, J);
    km_state_save(f->state, sub, saved);
    for (size_t c = 0; c < columns; ++c) {
      memset(step, 0, columns * sizeof *step);
      step[c] = h;
      km_state_move(m, f->state, sub, step);
      km_loops_update(m, f->state, sub);
      memcpy(plus, km_state_error(f->state, sub), rows * sizeof *plus);
      km_state_restore(f->state, sub, saved);
      step[c] = -h;
      km_state_move(m, f->state, sub, step);
      km_loops_update(m, f->state, sub);
      for (size_t i = 0; i < rows; ++i)
        assert_near((plus[i] - km_state_error(f->state, sub)[i]) / (2 * h), J[c * rows + i], 1e-9);
      km_state_restore(f->state, sub, saved);
    }
    km_free(J);
    km_free(saved);
    km_free(step);
    km_free(plus);
  }
}

/* J N = 0 for the whole six-row Jacobian, which also shows that the dropped rows were dependent. */
void law_null_space(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_update(m, f->state, &mobility);
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    const km_partition *p = &f->state->partition[s];
    const double *Z = km_state_basis(f->state, s), *weight = m->column_weight + sub->column_start;
    int rows;
    double *J = whole_jacobian(f, s, &rows);
    for (int k = 0; k < km_partition_freedom(p); ++k) {
      for (int i = 0; i < rows; ++i) {
        double sum = 0.0;
        for (int c = 0; c < sub->columns; ++c)
          sum += J[c * rows + i] * Z[k * sub->columns + c] / weight[c];
        assert_near(sum, 0.0, 1e-12 * fmax(1.0, 1.0 / weight[0]));
      }
    }
    km_free(J);
  }
}

void law_numbers(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_update(m, f->state, &mobility);
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    assert_true(f->state->numbers[c] >= 0.0 && f->state->numbers[c] <= 1.0 + 1e-12);
    sum += f->state->numbers[c];
  }
  assert_near(sum, mobility.mobility, 1e-12 * (1 + m->coordinate_count));
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    double *numbers = KM_NEW(double, (size_t)sub->columns);
    assert_int_equal(numbers_by_svd(f, s, numbers), f->state->partition[s].rank);
    for (int k = 0; k < sub->columns; ++k)
      assert_near(f->state->numbers[m->column_coordinate[sub->column_start + k]], numbers[k], 1e-10);
    km_free(numbers);
  }
}

/* With a driver's column forced independent the numbers are the same: they belong to the space. */
void law_forced(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    km_mobility_update(m, f->state, &mobility);
    int driver = below(r, sub->columns);
    double *free_numbers = KM_NEW(double, (size_t)sub->columns);
    for (int k = 0; k < sub->columns; ++k)
      free_numbers[k] = f->state->numbers[m->column_coordinate[sub->column_start + k]];
    km_pivot(m, f->state, s, driver, km_rank_tolerance(m, sub, 0.0));
    km_numbers_update(m, f->state, s);
    for (int k = 0; k < sub->columns; ++k)
      assert_near(f->state->numbers[m->column_coordinate[sub->column_start + k]], free_numbers[k], 1e-11);
    km_free(free_numbers);
  }
}

/* Central difference of a frame's position over ±h of the driver; false if the driver can't go there. */
static bool difference(fixture *f, km_drive *drive, int frame, double start, double h, double out[3]) {
  double ahead[3], behind[3];
  bool reached = !km_drive_to(drive, start + h).stop;
  km_poses_update(f->mechanism, f->state);
  km_frame_position(f->mechanism, f->state, frame, ahead);
  reached = !km_drive_to(drive, start - h).stop && reached;
  km_poses_update(f->mechanism, f->state);
  km_frame_position(f->mechanism, f->state, frame, behind);
  for (int k = 0; k < 3; ++k)
    out[k] = (ahead[k] - behind[k]) / (2.0 * h);
  return reached;
}

/* Body twists from the joints' rates against finite differences of the poses, in trees and loops. The error
 * of a central difference is a third of its change when h doubles. */
void law_twists(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  int c = below(r, m->coordinate_count), frame = f->model->frame_count - 1;
  if (m->ball_of[c] >= 0)
    return;
  double *rates = KM_NEW(double, (size_t)m->coordinate_count);
  km_drive *drive;
  assert_int_equal(km_drive_create(m, f->state, c, true, &drive, NULL), KM_OK);
  km_poses_update(m, f->state);
  if (km_drive_tangent(drive, rates)) {
    const km_model_frame *def = &f->model->frames[frame];
    km_twist t = {{0, 0, 0}, {0, 0, 0}};
    for (int body = def->body; body > 0; body = m->topology.parent[body])
      t = km_twist_axpy(1.0, km_body_twist(m, f->state, body, rates), t);
    km_vec3 p = km_pose_point(&f->state->pose[def->body], def->pose.p);
    km_vec3 velocity = km_vec3_add(t.v, km_vec3_cross(t.w, p));
    double factor = km_model_coordinate_factor(f->model, c), start = km_state_coordinate(f->state, c);
    double h = 1e-5 * m->unit[c] / factor, near[3], far[3];
    const double v[3] = {velocity.x * factor, velocity.y * factor, velocity.z * factor};
    if (difference(f, drive, frame, start, h, near) && difference(f, drive, frame, start, 2.0 * h, far))
      for (int k = 0; k < 3; ++k)
        assert_near(near[k], v[k], fabs(far[k] - near[k]) + 1e-8 * (km_vec3_norm(p) / m->unit[c] + 1.0 + fabs(v[k])));
  }
  km_drive_free(drive);
  km_free(rates);
}
