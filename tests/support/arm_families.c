/* Random arms and paths: what their tracks must keep. */
#include "support/arm_families.h"

#include <stdio.h>
#include <string.h>

static km_rotation random_rotation(randomness *r) {
  km_quaternion q = {uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1)};
  return km_quaternion_rotation(km_quaternion_normalised(q));
}

static void write_frame(km_text *out, const char *name, km_vec3 p, const km_rotation *R) {
  const km_vec3 *a = R->axis;
  km_text_format(out,
                 "{\"name\": \"%s\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, "
                 "%.17g], [%.17g, %.17g, %.17g]]}",
                 name, p.x, p.y, p.z, a[0].x, a[1].x, a[2].x, a[0].y, a[1].y, a[2].y, a[0].z, a[1].z, a[2].z);
}

/* Transformation from one joint's frame to the next. `meet`: intersection of a group's axes, along the axis of the
 * previous joint. */
static km_pose next_hinge(randomness *r, arm_shape shape, bool inside, double *meet) {
  km_pose pose = {random_rotation(r), {uniform(r, -0.5, 0.5), uniform(r, -0.5, 0.5), uniform(r, -0.5, 0.5)}};
  if (inside && shape == ARM_PARALLEL)
    pose.R = km_quaternion_rotation(km_quaternion_exp((km_vec3){0, 0, uniform(r, -3, 3)}));
  if (inside && shape == ARM_MEETING) {
    double along = uniform(r, -0.3, 0.3);
    pose.p = km_vec3_axpy(-along, pose.R.axis[2], (km_vec3){0, 0, *meet});
    *meet = along;
  }
  return pose;
}

static void write_joint(km_text *out, randomness *r, int k, int n, bool limited, bool roomy) {
  char child[16] = "hand";
  if (k + 1 < n)
    snprintf(child, sizeof child, "l%d", k + 1);
  km_text_format(out, ", {\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l%d\", \"t\"], \"%s\"]", k + 1,
                 k, child);
  double middle = uniform(r, -1, 1), half = uniform(r, 1.5, 3.1);
  if (roomy && below(r, 2))
    half = uniform(r, 3.3, 5.5);
  if (limited)
    km_text_format(out, ", \"limits\": [%.17g, %.17g]", middle - half, middle + half);
  km_text_add(out, "}");
}

fixture random_arm(randomness *r, int n, arm_shape shape, int first, bool limited, bool roomy) {
  km_text out = {0};
  double meet = uniform(r, -0.3, 0.3);
  km_text_add(&out, "{\"assemblies\": [{\"name\": \"arm\", \"bodies\": [");
  for (int k = 0; k <= n; ++k) {
    bool inside = k > first && k <= first + 2;
    km_pose pose = next_hinge(r, shape, inside, &meet);
    if (k < n)
      km_text_format(&out, "%s{\"name\": \"l%d\", \"frames\": [", k ? ", " : "", k);
    else
      km_text_add(&out, ", {\"name\": \"hand\", \"frames\": [");
    write_frame(&out, k < n ? "t" : "tool", pose.p, &pose.R);
    km_text_add(&out, "]}");
  }
  km_text_add(&out, "], \"joints\": [{\"name\": \"bolt\", \"type\": \"rigid\", \"body_frame_pairs\": "
                    "[\"fixed\", \"l0\"]}");
  for (int k = 0; k < n; ++k)
    write_joint(&out, r, k, n, limited, roomy);
  km_text_add(&out, "]}]}");
  fixture f = fixture_read(out.data);
  km_text_free(&out);
  return f;
}

static void write_vector(km_text *out, const char *key, km_vec3 v) {
  km_text_format(out, ", \"%s\": [%.17g, %.17g, %.17g]", key, v.x, v.y, v.z);
}

static void write_turn(km_text *out, const char *key, const km_rotation *R) {
  const km_vec3 *a = R->axis;
  km_text_format(out, ", \"%s\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]]", key, a[0].x,
                 a[1].x, a[2].x, a[0].y, a[1].y, a[2].y, a[0].z, a[1].z, a[2].z);
}

static km_vec3 random_vector(randomness *r, double size) {
  return (km_vec3){uniform(r, -size, size), uniform(r, -size, size), uniform(r, -size, size)};
}

static void write_segment(km_text *out, randomness *r, km_vec3 *at) {
  km_rotation R = random_rotation(r);
  km_vec3 to = km_vec3_add(*at, random_vector(r, 0.5));
  int kind = below(r, 5);
  km_text_format(out, "{\"steps\": %d", 2 + below(r, 9));
  if (kind == 0) { /* a line: travel, turn or both */
    int what = 1 + below(r, 3);
    km_text_add(out, ", \"type\": \"line\"");
    if (what & 1)
      write_vector(out, "to", to);
    if (what & 2)
      write_turn(out, "R_to", &R);
    *at = what & 1 ? to : *at;
  } else if (kind == 1) {
    km_text_format(out, ", \"type\": \"helix\", \"angle\": %.17g, \"pitch\": %.17g, \"turn\": %s", uniform(r, 0.5, 6),
                   uniform(r, -0.2, 0.2), below(r, 2) ? "true" : "false");
    write_vector(out, "center", km_vec3_add(*at, random_vector(r, 0.3)));
    write_vector(out, "axis", random_vector(r, 1));
  } else if (kind == 2) {
    km_text_format(out, ", \"type\": \"weave\", \"amplitude\": %.17g, \"waves\": %.17g", uniform(r, 0.01, 0.1),
                   uniform(r, 0.5, 3));
    write_vector(out, "to", to);
    write_turn(out, "R_to", &R);
    write_vector(out, "sideways", random_vector(r, 1));
    *at = to;
  } else {
    km_text_add(out, ", \"type\": \"spline\", \"points\": [");
    for (int k = 0; k < 3; ++k) {
      R = random_rotation(r);
      *at = km_vec3_add(*at, random_vector(r, 0.4));
      km_text_format(out, "%s{\"T\": [%.17g, %.17g, %.17g]", k ? ", " : "", at->x, at->y, at->z);
      write_turn(out, "R", &R);
      km_text_add(out, "}");
    }
    km_text_add(out, "]");
  }
  km_text_add(out, "}");
}

/* Travel and turn of interval i by many poses: chords, whose error falls with the square of their number. */
static void measure(const km_path *path, int i, double *travel, double *turn) {
  double found[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
  for (int fine = 0; fine < 2; ++fine) {
    const int pieces = fine ? 400 : 200;
    km_pose last = path->points[i].pose;
    for (int k = 1; k <= pieces; ++k) {
      km_pose pose = k < pieces ? km_path_at(path, i, (double)k / pieces).pose : path->points[i + 1].pose;
      km_rotation back = km_rotation_inverse(&last.R), step = km_rotation_product(&pose.R, &back);
      found[fine][0] += km_vec3_norm(km_vec3_sub(pose.p, last.p));
      found[fine][1] += km_vec3_norm(km_quaternion_log(km_rotation_quaternion(&step)));
      last = pose;
    }
  }
  *travel = (4.0 * found[1][0] - found[0][0]) / 3.0 * path->arm->length;
  *turn = (4.0 * found[1][1] - found[0][1]) / 3.0;
}

static bool times_agree(const km_path *path, double speed, double turn_speed, char *why, size_t size) {
  double all_travel = 0.0, all_turn = 0.0;
  for (int i = 0; i + 1 < km_path_samples(path); ++i) {
    double travel, turn;
    measure(path, i, &travel, &turn);
    double pace = turn_speed > 0.0 ? turn_speed : travel < 1e-9 ? 1.0 : HUGE_VAL;
    double expected = fmax(travel / speed, turn / pace), found = km_path_time(path, i + 1) - km_path_time(path, i);
    all_travel += travel;
    all_turn += turn;
    double lengths = fabs(km_path_travel(path, i + 1) - all_travel) + fabs(km_path_turn(path, i + 1) - all_turn);
    if (!(fabs(found - expected) <= 1e-5 * expected + 1e-9 / speed) || !(lengths <= 1e-5 * (all_travel + all_turn))) {
      snprintf(why, size, "interval %d takes %.9g s, expected %.9g s; travel %.9g (%.9g), turn %.9g (%.9g)", i, found,
               expected, km_path_travel(path, i + 1), all_travel, km_path_turn(path, i + 1), all_turn);
      return false;
    }
  }
  return true;
}

bool family_path_times(uint64_t seed, char *why, size_t size) {
  randomness r = {seed};
  fixture f = random_arm(&r, 7, ARM_GENERAL, 0, false, false);
  km_arm *arm = arm_of(&f, "hand", "tool", KM_TASK_POSE);
  double q[7] = {0}, speed = uniform(&r, 0.01, 2.0), turn_speed = below(&r, 2) ? uniform(&r, 0.05, 5.0) : 0.0;
  km_vec3 at = effector_by_bodies(&f, arm, q).p;
  km_text text = {0};
  km_text_format(
      &text, "{\"effector\": [\"hand\", \"tool\"], \"q0\": [0, 0, 0, 0, 0, 0, 0], \"path\": {\"speed\": %.17g", speed);
  if (turn_speed > 0.0)
    km_text_format(&text, ", \"turn_speed\": %.17g", turn_speed);
  km_text_format(&text, ", \"start\": {\"T\": [%.17g, %.17g, %.17g]}, \"segments\": [", at.x, at.y, at.z);
  for (int k = 0, count = 1 + below(&r, 2); k < count; ++k) {
    km_text_add(&text, k ? ", " : "");
    write_segment(&text, &r, &at);
  }
  km_text_add(&text, "]}}");
  km_study *study = study_of(&f, text.data);
  bool agrees = times_agree(study->path, speed, turn_speed, why, size);
  km_study_free(study);
  km_text_free(&text);
  km_arm_free(arm);
  fixture_close(&f);
  return agrees;
}

/* No row may break a rate, by its own columns or by the change from row to row; nor a limit. */
static bool rows_allowed(const km_track *t, const double *rates, char *why, size_t size) {
  const km_arm *a = t->arm;
  for (size_t i = 0; i < km_table_rows(t->table); ++i) {
    const double *row = km_table_row(t->table, i), *last = i ? km_table_row(t->table, i - 1) : NULL;
    for (int k = 0; k < a->n; ++k) {
      double v = row[3 + a->n + k], mean = last ? (row[3 + k] - last[3 + k]) / (row[2] - last[2]) : 0.0;
      if (!(fabs(v) <= rates[k] * (1.0 + 1e-8)) || !(fabs(mean) <= rates[k] * (1.0 + 1e-6)) ||
          !(row[3 + k] >= a->low[k] - 1e-9 && row[3 + k] <= a->high[k] + 1e-9)) {
        snprintf(why, size, "%s, row %zu of %zu: joint %d at %.9g has the rate %.9g, mean %.9g, of %.9g; stop %d",
                 t->plan.method.word, i, km_table_rows(t->table), k + 1, row[3 + k], v, mean, rates[k],
                 (int)t->end.stop);
        return false;
      }
    }
  }
  return true;
}

static void write_numbers(km_text *out, const char *key, const double *values, int count) {
  km_text_format(out, "\"%s\": [", key);
  for (int k = 0; k < count; ++k)
    km_text_format(out, "%s%.17g", k ? ", " : "", values[k]);
  km_text_add(out, "]");
}

/* The reported cause of a stop is present: a named limit is reached. */
static bool end_stands(const km_track *t, char *why, size_t size) {
  const km_arm *a = t->arm;
  size_t rows = km_table_rows(t->table);
  if (t->end.stop != KM_TRACK_LIMIT || rows == 0)
    return true;
  int k = t->end.column;
  double q = km_table_row(t->table, rows - 1)[3 + k], left = fmin(fabs(q - a->low[k]), fabs(a->high[k] - q));
  if (left <= 1e-9)
    return true;
  snprintf(why, size, "%s: joint %d is said to be at its limit, from which %.3g is left", t->plan.method.word, k + 1,
           left);
  return false;
}

bool family_workspace_edge(uint64_t seed, char *why, size_t size) {
  randomness r = {seed};
  const int n = 6 + below(&r, 3);
  fixture f = random_arm(&r, n, (arm_shape)below(&r, 3), below(&r, n - 2), true, below(&r, 2));
  km_arm *arm = arm_of(&f, "hand", "tool", KM_TASK_POSE);
  double q[8], rates[8];
  random_pose(arm, &r, q);
  km_vec3 to = km_vec3_add(effector_by_bodies(&f, arm, q).p, random_vector(&r, 6.0));
  km_text text = {0};
  for (int k = 0; k < n; ++k)
    rates[k] = uniform(&r, 1.0, 4.0);
  km_text_add(&text, "{\"effector\": [\"hand\", \"tool\"], ");
  write_numbers(&text, "q0", q, n);
  km_text_add(&text, ", ");
  write_numbers(&text, "rates", rates, n);
  km_text_format(&text, ", \"path\": {\"speed\": %.17g, \"segments\": [{\"type\": \"line\", \"steps\": %d",
                 uniform(&r, 0.02, 0.5), 20 + below(&r, 200));
  write_vector(&text, "to", to);
  km_text_add(&text, "}]}, \"methods\": [\"greedy\", \"dls\", \"gradient\", \"fixed\", \"lookahead\"]}");
  km_study *study = study_of(&f, text.data);
  bool fine = true;
  for (int m = 0; m < study->method_count && fine; ++m) {
    km_track *track = track_of(study, m, 1);
    fine = rows_allowed(track, rates, why, size) && end_stands(track, why, size);
    km_track_free(track);
  }
  km_study_free(study);
  km_text_free(&text);
  km_arm_free(arm);
  fixture_close(&f);
  return fine;
}

fixture dh_arm(const double (*dh)[3], int n, const double *limit, bool hangs) {
  km_text out = {0};
  km_rotation base = km_quaternion_rotation(km_quaternion_exp((km_vec3){hangs ? M_PI : 0.0, 0, 0}));
  km_text_add(&out, "{\"assemblies\": [{\"name\": \"arm\", \"bodies\": [{\"name\": \"l0\", \"frames\": [");
  write_frame(&out, "t", (km_vec3){0, 0, 0}, &base);
  for (int k = 0; k < n; ++k) {
    km_rotation R = km_quaternion_rotation(km_quaternion_exp((km_vec3){dh[k][0], 0, 0}));
    km_text_format(&out, "]}, {\"name\": \"l%d\", \"frames\": [", k + 1);
    write_frame(&out, "t", (km_vec3){dh[k][1], 0, dh[k][2]}, &R);
  }
  km_text_add(&out,
              "]}], \"joints\": [{\"name\": \"bolt\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"l0\"]}");
  for (int k = 0; k < n; ++k) {
    km_text_format(&out, ", {\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l%d\", \"t\"], \"l%d\"]",
                   k + 1, k, k + 1);
    if (limit[k] > 0.0)
      km_text_format(&out, ", \"limits\": [%.17g, %.17g]", -limit[k], limit[k]);
    km_text_add(&out, "}");
  }
  km_text_add(&out, "]}]}");
  fixture f = fixture_read(out.data);
  km_text_free(&out);
  return f;
}

/* Kinova Gen3 with seven joints, by its published parameters; every second joint turns freely. */
static fixture gen3(void) {
  static const double limit[7] = {0, 2.41, 0, 2.66, 0, 2.23, 0};
  static const double quarter = 0.5 * M_PI;
  const double dh[7][3] = {{quarter, 0, -0.2848}, {quarter, 0, -0.0118}, {quarter, 0, -0.4208}, {quarter, 0, -0.0128},
                           {quarter, 0, -0.3143}, {quarter, 0, 0},       {M_PI, 0, -0.1674}};
  return dh_arm(dh, 7, limit, true);
}

bool family_dp_work(uint64_t seed, char *why, size_t size) {
  static const double rates[7] = {1.3, 1.3, 1.3, 1.3, 1.2, 1.2, 1.2};
  const unsigned long most =
      30000000; /* Jacobians: of four passes, each with the whole of its work in one stage more */
  randomness r = {seed};
  fixture f = gen3();
  km_arm *arm = arm_of(&f, "l7", "t", KM_TASK_POSE);
  double q[7];
  random_pose(arm, &r, q);
  km_vec3 to = km_vec3_add(effector_by_bodies(&f, arm, q).p, random_vector(&r, uniform(&r, 0.02, 1.0)));
  km_text text = {0};
  km_text_add(&text, "{\"effector\": [\"l7\", \"t\"], ");
  write_numbers(&text, "q0", q, 7);
  km_text_add(&text, ", ");
  write_numbers(&text, "rates", rates, 7);
  km_text_format(&text, ", \"path\": {\"speed\": %.17g, \"segments\": [{\"type\": \"line\", \"steps\": 25",
                 uniform(&r, 0.02, 0.6));
  write_vector(&text, "to", to);
  km_text_add(&text, "}]}, \"methods\": [\"dp\", \"greedy\"]}");
  km_study *study = study_of(&f, text.data);
  km_track *dp = track_of(study, 0, 1), *greedy = track_of(study, 1, 1);
  bool fine = rows_allowed(dp, rates, why, size) && end_stands(dp, why, size);
  if (fine && dp->summary.evaluations > most) {
    snprintf(why, size, "%lu Jacobians for 26 samples", dp->summary.evaluations);
    fine = false;
  }
  if (fine && greedy->end.stop == KM_TRACK_COMPLETE && dp->end.stop != KM_TRACK_COMPLETE) {
    snprintf(why, size, "greedy comes to the end, dynamic programming to sample %d", dp->end.sample);
    fine = false;
  }
  km_track_free(dp);
  km_track_free(greedy);
  km_study_free(study);
  km_text_free(&text);
  km_arm_free(arm);
  fixture_close(&f);
  return fine;
}
