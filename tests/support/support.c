/* Fixtures, random poses, and Jacobians independent of the library. */
#include "support/support.h"

#include "kmech/exchange.h"

#include "kmech/mobility.h"

#include "kinematics/loop_equations.h"
#include "kmech/model.h"

#include "base/file.h"
#include "topology/chain.h"

#include <lapacke.h>
#include <stdio.h>
#include <string.h>

const char *const all_models[] = {"fourbar",     "slider_crank", "bricard", "sarrus3",      "sarrus4",      "klann",
                                  "excavator",   "brake",        "bennett", "stewart",      "delta",        "robot7r",
                                  "panda",       "iiwa14",       "vehicle", "scissor_lift", "toggle_press", "jansen",
                                  "peaucellier", "rssr",         "bonnet",  "andrews",      "a02",          NULL};

bool has_one_freedom(const char *name) {
  static const char *const several[] = {"stewart", "delta", "vehicle", "rssr", NULL};
  for (const char *const *s = several; *s; ++s)
    if (strcmp(*s, name) == 0)
      return false;
  return true;
}

char *read_model_text(const char *name) {
  km_text path = {0}, text = {0};
  km_error error;
  km_text_format(&path, "%s/%s.json", MODELS_DIR, name);
  if (km_file_read(path.data, &text, &error))
    fail_msg("%s", error.text);
  km_text_free(&path);
  return text.data;
}

fixture fixture_of(km_model *model) {
  fixture f = {.model = model};
  km_error error;
  if (km_mechanism_compile(model, NULL, 0, &f.mechanism, &error) || km_state_create(f.mechanism, &f.state, &error) ||
      km_assemble(f.mechanism, f.state, NULL, &error))
    fail_msg("%s", error.text);
  return f;
}

char *edited(const char *text, const char *place, const char *from, const char *to) {
  const char *behind = place ? strstr(text, place) : text, *at = behind ? strstr(behind, from) : NULL;
  assert_non_null(at);
  km_text out = {0};
  km_text_bytes(&out, text, (size_t)(at - text));
  km_text_add(&out, to);
  km_text_add(&out, at + strlen(from));
  return out.data;
}

fixture fixture_read(const char *json) {
  km_model *model;
  km_error error;
  if (km_model_read(json, strlen(json), NULL, &model, &error))
    fail_msg("%s", error.text);
  return fixture_of(model);
}

fixture fixture_in_units(const fixture *f, const char *angle, const char *length, const char *mass, const char *time) {
  km_arena arena = {0};
  km_text json = {0};
  const km_value *tree;
  km_units units = f->model->units;
  units.angle = angle ? km_unit_find(KM_ANGLE, angle) : units.angle;
  units.length = length ? km_unit_find(KM_LENGTH, length) : units.length;
  units.mass = mass ? km_unit_find(KM_MASS, mass) : units.mass;
  units.time = time ? km_unit_find(KM_TIME, time) : units.time;
  assert_int_equal(km_model_convert(f->model, &units, NULL, false, &arena, &tree, NULL), KM_OK);
  km_json_write(tree, &json);
  fixture g = fixture_read(json.data);
  km_text_free(&json);
  km_arena_free(&arena);
  return g;
}

fixture fixture_written(void (*write)(km_text *out, int n), int n) {
  km_text text = {0};
  write(&text, n);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

km_status fixture_try(const char *json, fixture *f, km_error *error) {
  *f = (fixture){0};
  km_status status = km_model_read(json, strlen(json), NULL, &f->model, error);
  if (!status)
    status = km_mechanism_compile(f->model, NULL, 0, &f->mechanism, error);
  if (!status)
    status = km_state_create(f->mechanism, &f->state, error);
  return status ? status : km_assemble(f->mechanism, f->state, NULL, error);
}

fixture fixture_open(const char *name) {
  char *text = read_model_text(name);
  fixture f = fixture_read(text);
  km_free(text);
  return f;
}

/* Every component of every frame's place times a factor of its own: what is 0 stays 0, so a plane stays a plane. */
static void vary(km_model *m, randomness *r, double spread) {
  for (int f = 0; f < m->frame_count; ++f) {
    km_vec3 p = m->frames[f].pose.p;
    const double T[3] = {p.x * uniform(r, 1 - spread, 1 + spread), p.y * uniform(r, 1 - spread, 1 + spread),
                         p.z * uniform(r, 1 - spread, 1 + spread)};
    assert_int_equal(km_model_set_frame(m, f, T, NULL, NULL), KM_OK);
  }
}

fixture fixture_open_variant(const char *name, uint64_t seed) {
  randomness r = {seed};
  fixture f = fixture_open(name);
  if (seed > 0)
    vary(f.model, &r, 2e-3);
  km_state_restart(f.state);
  if (km_mechanism_renumber(f.mechanism, NULL) || km_assemble(f.mechanism, f.state, NULL, NULL)) {
    fixture_close(&f);
    f = fixture_open(name);
  }
  return f;
}

fixture parallelogram(double angle) {
  static const char text[] =
      "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [2, 0, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "["
      "{\"name\": \"l\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}, {\"name\": \"c\", \"frames\": [{\"name\": "
      "\"t\", \"T\": [2, 0, 0]}]},"
      "{\"name\": \"r\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"l\"], \"initial_displacement\": %.17g},"
      "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l\", \"t\"], \"c\"], \"initial_displacement\": "
      "%.17g},"
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c\", \"t\"], [\"r\", \"t\"]], "
      "\"initial_displacement\": %.17g},"
      "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"r\"], "
      "\"initial_displacement\": %.17g}]}]}";
  char buffer[2048];
  snprintf(buffer, sizeof buffer, text, angle, -angle, angle, angle);
  return fixture_read(buffer);
}

char *fixture_notes(fixture *f) {
  km_messages *notes = km_messages_create();
  km_text text = {0};
  km_geometry_notes(f->mechanism, f->state, notes);
  km_text_add(&text, "");
  for (size_t i = 0; i < km_messages_count(notes); ++i)
    km_text_format(&text, "%s\n", km_messages_text(notes, i));
  km_messages_free(notes);
  return text.data;
}

void fixture_close(fixture *f) {
  km_state_free(f->state);
  km_mechanism_free(f->mechanism);
  km_model_free(f->model);
}

void assert_near_at(double a, double b, double tolerance, const char *what, const char *file, int line) {
  evidence_compare(a, b, tolerance);
  if (fabs(a - b) <= tolerance)
    return;
  print_error("%s: %.17g is not %.17g within %.3g (off by %.3g)\n", what, a, b, tolerance, fabs(a - b));
  _fail(file, line);
}

void assert_same_bits_at(const double *a, const double *b, size_t count, const char *what, const char *file, int line) {
  for (size_t i = 0; i < count; ++i) {
    evidence_compare(a[i], b[i], 0.0);
    if (memcmp(&a[i], &b[i], sizeof a[i]) == 0)
      continue;
    print_error("%s: %.17g has other bits than %.17g, at %zu\n", what, a[i], b[i], i);
    _fail(file, line);
  }
}

static uint64_t next(randomness *r) {
  uint64_t z = (r->state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double uniform(randomness *r, double low, double high) {
  return low + (high - low) * ((double)(next(r) >> 11) * 0x1p-53);
}

int below(randomness *r, int count) {
  return (int)(next(r) % (uint64_t)count);
}

static void drive_a_bit(fixture *f, int coordinate, double by) {
  km_driver_motion *drive;
  km_error error;
  if (km_driver_motion_create(f->mechanism, f->state, coordinate, true, &drive, &error))
    fail_msg("%s", error.text);
  double factor = km_model_coordinate_factor(f->model, coordinate);
  km_driver_motion_move_to(drive, km_state_coordinate(f->state, coordinate) + by / factor);
  km_driver_motion_free(drive);
}

void go_somewhere(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->substructure_of[c] < 0 && m->ball_of[c] < 0)
      f->state->q[c] += uniform(r, -1.0, 1.0);
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    for (int i = 0; i < 3; ++i) {
      int c = m->column_coordinate[sub->column_start + below(r, sub->columns)];
      if (m->ball_of[c] < 0)
        drive_a_bit(f, c, uniform(r, -0.3, 0.3) * m->unit[c]);
    }
  }
}

/* The frame before motion `which` of a joint, in the inertial frame, by the user's sense. */
km_twist column_in_space(const fixture *f, int coordinate) {
  const km_mechanism *m = f->mechanism;
  const km_model_coordinate *def = &f->model->coordinates[coordinate];
  km_joint_traversal p;
  km_joint_traverse(f->model, def->joint, false, &p);
  const km_model_frame *entry = &f->model->frames[p.entry];
  km_pose X = km_pose_product(&f->state->pose[entry->body], &entry->pose);
  double pitch = f->model->joints[def->joint].pitch / (2.0 * M_PI);
  for (int i = 0; i < p.count; ++i) {
    int freedom = km_primitive_freedom(p.motion[i].primitive), first = p.coordinate[i];
    if (coordinate >= first && coordinate < first + freedom)
      return km_motion_twist(p.motion[i], pitch, &X, coordinate - first);
    km_pose motion;
    if (p.motion[i].primitive == KM_BALL)
      motion = (km_pose){km_quaternion_rotation(f->state->ball[m->ball_of[first]]), {0, 0, 0}};
    else
      motion = km_motion_pose(p.motion[i], pitch, &f->state->q[first]);
    X = km_pose_product(&X, &motion);
  }
  fail_msg("coordinate %d is in no motion", coordinate);
  return (km_twist){{0, 0, 0}, {0, 0, 0}};
}

static km_vec3 place_of(const fixture *f, int joint) {
  const km_model_frame *frame = &f->model->frames[f->model->joints[joint].frame[0]];
  return km_pose_point(&f->state->pose[frame->body], frame->pose.p);
}

/* +1 if the traversal of the loop (out along the virtual side, back along the other) has the user's sense. */
static double sense(const km_member *member) {
  return member->side * (member->is_reversed ? -1.0 : 1.0);
}

double *whole_jacobian(const fixture *f, int substructure, int *rows) {
  const km_mechanism *m = f->mechanism;
  const km_topology *t = &m->topology;
  const km_substructure *sub = &m->substructures[substructure];
  *rows = 6 * sub->loop_count + sub->coupling_count;
  size_t ld = (size_t)*rows;
  double *J = KM_NEW(double, ld *(size_t)sub->columns);
  km_poses_compute(m, f->state);
  km_vec3 about = place_of(f, t->joint[t->joint_start[substructure]]);
  for (int i = 0; i < sub->loop_count; ++i) {
    int loop = t->loop[t->loop_start[substructure] + i];
    for (int k = t->member_start[loop]; k < t->member_start[loop + 1]; ++k) {
      const km_model_joint *joint = &f->model->joints[t->member[k].joint];
      for (int c = joint->first_coordinate;
           c < joint->first_coordinate + km_model_freedom(f->model, t->member[k].joint); ++c) {
        if (m->column_of[c] < 0)
          continue;
        km_twist h = column_in_space(f, c);
        h.v = km_vec3_scale(m->unit[c] / sub->size, km_vec3_add(h.v, km_vec3_cross(h.w, about)));
        double s = sense(&t->member[k]), *out = J + (size_t)m->column_of[c] * ld + 6 * (size_t)i;
        const double column[6] = {h.v.x, h.v.y, h.v.z, h.w.x, h.w.y, h.w.z};
        for (int r = 0; r < 6; ++r)
          out[r] = s * column[r];
      }
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      if (term->column >= 0)
        km_term_value(m, f->state, term, &J[(size_t)term->column * ld + 6 * (size_t)sub->loop_count + (size_t)i]);
    }
  }
  return J;
}

int numbers_by_svd(const fixture *f, int substructure, double *numbers) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = &m->substructures[substructure];
  const double *weight = m->column_weight + sub->column_start;
  int rows, n = sub->columns;
  double *J = whole_jacobian(f, substructure, &rows);
  /* The null space of J D⁻¹ is D times that of J. */
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < rows; ++r)
      J[(size_t)c * (size_t)rows + (size_t)r] /= weight[c];
  int least = rows < n ? rows : n, rank = 0;
  double *sigma = KM_NEW(double, (size_t)least + 1), *U = KM_NEW(double, (size_t)rows *(size_t)rows);
  double *Vt = KM_NEW(double, (size_t)n *(size_t)n);
  int info = rows ? LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'A', rows, n, J, rows, sigma, U, rows, Vt, n) : 0;
  assert_int_equal(info, 0);
  while (rank < least && sigma[rank] > 1e-9 * sigma[0])
    ++rank;
  for (int c = 0; c < n; ++c) {
    numbers[c] = 0.0;
    for (int k = rank; k < n; ++k)
      numbers[c] += Vt[(size_t)c * (size_t)n + (size_t)k] * Vt[(size_t)c * (size_t)n + (size_t)k];
  }
  km_free(J);
  km_free(sigma);
  km_free(U);
  km_free(Vt);
  return rank;
}

int fixture_coordinate(const fixture *f, const char *label) {
  int c;
  assert_int_equal(km_model_find_coordinate(f->model, label, &c, NULL), KM_OK);
  return c;
}

double table_cell(const km_table *table, size_t row, const char *column) {
  int c = km_table_find(table, column);
  assert_true(c >= 0);
  return km_table_row(table, row)[c];
}
