/* Arms and path studies for tests. */
#include "support/arms.h"

#include "base/file.h"
#include "kinematics/body_poses.h"

#include <stdio.h>
#include <string.h>

km_arm *arm_of(const fixture *f, const char *body, const char *frame, km_task task) {
  const char *names[2] = {body, frame};
  int index;
  km_arm *arm = NULL;
  km_error error = {0};
  if (km_model_find_frame(f->model, names, 2, &index, &error) ||
      km_arm_create(f->mechanism, f->state, index, task, &arm, &error))
    fail_msg("%s", error.text);
  return arm;
}

/* Mass, its centre and its inertia of body k of the odd arm, which differ from body to body. */
#define MASS(m, x, y, z, xx, yy, zz, xy)                                                                               \
  ", \"mass\": " #m ", \"center_of_mass\": [" #x ", " #y ", " #z "], \"moment_of_inertia\": {\"Ixx\": " #xx            \
  ", \"Iyy\": " #yy ", \"Izz\": " #zz ", \"Ixy\": " #xy ", \"Iyz\": -0.002, \"Izx\": 0.003}"

fixture odd_arm(void) {
  return fixture_read(
      "{\"model_parameters\": {\"gravity\": [1.5, -2, -9.5]},"
      "\"fixed\": {\"frames\": [{\"name\": \"far\", \"T\": [300, -200, 50], \"R\": [[0, 0, 1], [1, 0, 0], [0, 1, "
      "0]]}]},"
      "\"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "{\"name\": \"base\"" MASS(
          9, 0, 0, 0.1, 0.2, 0.2, 0.1,
          0.01) "},"
                "{\"name\": \"l1\"" MASS(
                    2, 0.1, 0.1, -0.1, 0.06, 0.05, 0.04,
                    0.002) ", \"frames\": [{\"name\": \"t\", \"T\": [0.1, 0.4, 0.2]}]},"
                           "{\"name\": \"l2\"" MASS(
                               1.5, 0.2, 0, 0.05, 0.05, 0.07, 0.03,
                               -0.001) ", \"frames\": [{\"name\": \"t\", \"T\": [0.5, 0, 0.1], \"R\": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}]},"
                                       "{\"name\": \"l3\"" MASS(
                                           1.2, 0, 0.15, 0.02, 0.03, 0.02, 0.04,
                                           0.003) ", \"frames\": [{\"name\": \"t\", \"T\": [0, 0.3, 0]}]},"
                                                  "{\"name\": \"l4\"" MASS(
                                                      0.9, 0.1, 0, 0.1, 0.02, 0.03, 0.02,
                                                      0.001) ", \"frames\": [{\"name\": \"t\", \"T\": [0.2, 0, 0.3], \"R\": [[1, 0, 0], [0, 0, -1], [0, 1, 0]]}]},"
                                                             "{\"name\": \"l5\"" MASS(
                                                                 0.7, -0.02, 0.05, 0.1, 0.02, 0.02, 0.01,
                                                                 -0.002) ", \"frames\": [{\"name\": \"t\", \"T\": [0, 0, 0.25]}]},"
                                                                         "{\"name\": \"hand\"" MASS(
                                                                             0.5, 0.05, 0.01, 0.02, 0.01, 0.012, 0.008,
                                                                             0.001) ", \"frames\": [{\"name\": \"tip\", \"T\": [0.1, 0, 0.1], \"R\": [[0, 1, 0], [0, 0, 1], [1, 0, 0]]}]},"
                                                                                    "{\"name\": \"side\"" MASS(
                                                                                        0.8, 0.2, 0.1, 0.15, 0.03, 0.02,
                                                                                        0.025,
                                                                                        0.002) "},"
                                                                                               "{\"name\": \"finger\"" MASS(
                                                                                                   0.3, 0.1, 0, 0.05,
                                                                                                   0.01, 0.012, 0.009,
                                                                                                   -0.001) "}],"
                                                                                                           "\"joints\": ["
                                                                                                           "{\"name\": \"bolt\", \"type\": \"rigid\", \"body_frame_pairs\": [[\"fixed\", \"far\"], \"base\"]},"
                                                                                                           "{\"name\": \"rail\", \"type\": \"Tx\", \"body_frame_pairs\": [\"base\", \"l1\"], \"limits\": [-2, 2],"
                                                                                                           " \"damping\": 3, \"armature\": 0.7},"
                                                                                                           "{\"name\": \"back\", \"type\": \"Ry\", \"body_frame_pairs\": [\"l2\", [\"l1\", \"t\"]], "
                                                                                                           "\"initial_displacement\": 0.4},"
                                                                                                           "{\"name\": \"screw\", \"type\": \"screw\", \"pitch\": 0.2, \"body_frame_pairs\": [[\"l2\", \"t\"], \"l3\"],"
                                                                                                           " \"damping\": 0.4},"
                                                                                                           "{\"name\": \"pair\", \"type\": \"universal\", \"body_frame_pairs\": [[\"l4\", \"t\"], [\"l3\", \"t\"]],"
                                                                                                           " \"initial_displacement\": [0.3, -0.5]},"
                                                                                                           "{\"name\": \"tube\", \"type\": \"cylindrical\", \"body_frame_pairs\": [\"l4\", \"l5\"], "
                                                                                                           "\"initial_displacement\": [0.1, 0.2]},"
                                                                                                           "{\"name\": \"wrist\", \"type\": \"Rx\", \"body_frame_pairs\": [[\"l5\", \"t\"], \"hand\"], \"limits\": [-2.5, "
                                                                                                           "2], \"armature\": 0.02},"
                                                                                                           "{\"name\": \"elbow\", \"type\": \"Ry\", \"body_frame_pairs\": [\"l3\", \"side\"], \"initial_displacement\": 0.8},"
                                                                                                           "{\"name\": \"grip\", \"type\": \"Tz\", \"body_frame_pairs\": [\"hand\", \"finger\"],"
                                                                                                           " \"initial_displacement\": 0.1}]}]}");
}

#undef MASS

void random_pose(const km_arm *arm, randomness *r, double *q) {
  for (int k = 0; k < arm->n; ++k)
    q[k] = uniform(r, fmax(arm->low[k], -2.0), fmin(arm->high[k], 2.0));
}

km_study *study_of(const fixture *f, const char *json) {
  km_study *study = NULL;
  km_study_def def = km_study_def_default();
  km_error error = {0};
  if (km_study_read(json, strlen(json), "", NULL, &def, &error) ||
      km_study_bind(f->mechanism, f->state, &def, 1, NULL, &study, &error))
    fail_msg("%s", error.text);
  km_study_def_free(&def);
  return study;
}

km_track *track_of(const km_study *study, int method, int jobs) {
  km_track_plan plan = km_study_plan(study, method);
  km_track *track = NULL;
  km_error error = {0};
  plan.jobs = jobs;
  km_status status = km_track_run(km_study_arm(study), &plan, &track, &error);
  if (status && status != KM_PARTIAL)
    fail_msg("%s", error.text);
  return track;
}

double track_cell(const km_track *track, size_t row, const char *column) {
  int index = km_table_find(km_track_rows(track), column);
  if (index < 0)
    fail_msg("no column %s", column);
  return km_table_row(km_track_rows(track), row)[index];
}

km_pose effector_by_bodies(const fixture *f, const km_arm *arm, const double *q) {
  const km_model_frame *frame = &f->model->frames[arm->frame];
  double all[128];
  memcpy(all, f->state->q, (size_t)f->mechanism->coordinate_count * sizeof *all);
  for (int k = 0; k < arm->n; ++k)
    all[arm->coordinate[k]] = q[k] * arm->unit[k];
  km_state_set(f->mechanism, f->state, all);
  km_poses_compute(f->mechanism, f->state);
  return km_pose_product(&f->state->pose[frame->body], &frame->pose);
}

void assert_on_path(const fixture *f, const km_study *study, const km_track *track) {
  const km_arm *arm = study->arm;
  size_t rows = km_table_rows(track->table);
  km_track_summary s = km_track_summarise(track);
  assert_true(s.error_position <= 1e-9 * arm->length && s.error_rotation <= 1e-9);
  assert_int_equal(s.violations, 0);
  for (size_t r = 0; r < rows && r <= (size_t)track->end.sample; ++r) {
    double q[KM_ARM_MAX_JOINTS], values[12];
    for (int k = 0; k < arm->n; ++k)
      q[k] = km_arm_from_units(arm, k, km_table_row(track->table, r)[3 + k]);
    km_pose at = effector_by_bodies(f, arm, q);
    km_frame_pose want;
    km_path_pose(study->path, (int)r, &want);
    double got[12] = {at.p.x, at.p.y, at.p.z};
    for (int k = 0; k < 3; ++k) {
      values[k] = want.p[k];
      for (int i = 0; i < 3; ++i)
        values[3 + 3 * k + i] = want.R[3 * i + k];
      got[3 + 3 * k] = at.R.axis[k].x;
      got[4 + 3 * k] = at.R.axis[k].y;
      got[5 + 3 * k] = at.R.axis[k].z;
    }
    for (int k = 0; k < 12; ++k)
      assert_near(got[k], values[k], k < 3 ? 1e-9 * arm->length : 1e-9);
    assert_int_equal(km_arm_limit_passed(arm, q), -1);
  }
}

void assert_same_rows(const km_track *a, const km_track *b) {
  assert_int_equal(km_table_rows(a->table), km_table_rows(b->table));
  for (size_t r = 0; r < km_table_rows(a->table); ++r)
    assert_memory_equal(km_table_row(a->table, r), km_table_row(b->table, r),
                        km_table_columns(a->table) * sizeof(double));
}

opened_study study_open(const char *name) {
  char path[1024], model[2048];
  km_text text = {0};
  km_error error = {0};
  opened_study o = {0};
  km_study_def def = km_study_def_default();
  snprintf(path, sizeof path, "%s/%s", STUDIES_DIR, name);
  snprintf(model, sizeof model, "%s/study.json", path);
  if (km_file_read(model, &text, &error) || km_study_read(text.data, text.size, path, NULL, &def, &error))
    fail_msg("%s", error.text);
  km_text_free(&text);
  snprintf(model, sizeof model, "%s/%s", path, def.model);
  km_model *read;
  if (km_model_read_file(model, NULL, &read, &error))
    fail_msg("%s", error.text);
  o.f = fixture_of(read);
  if (km_study_bind(o.f.mechanism, o.f.state, &def, 1, NULL, &o.study, &error))
    fail_msg("%s", error.text);
  km_study_def_free(&def);
  return o;
}
