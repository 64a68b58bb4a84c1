/* A family of single loops in space: what an actuator holds along sweeps against displacements alone. An actuator's
 * force f and the work W of what acts satisfy f dq + dW = 0. */
#include "support/course.h"

#include "base/text.h"
#include "kinematics/body_poses.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SAMPLES = 2500, MOST_JOINTS = 4 };

/* Bodies 1 … joints − 1 between the joints of a loop from the ground to the ground. */
typedef struct loop {
  int joints;
  const char *type[MOST_JOINTS];
  km_vec3 place[MOST_JOINTS], axis[MOST_JOINTS];
  double mass[MOST_JOINTS];
  km_vec3 centre[MOST_JOINTS]; /* pose of body i */
} loop;

static km_vec3 random_vector(randomness *r) {
  return (km_vec3){uniform(r, -1.0, 1.0), uniform(r, -1.0, 1.0), uniform(r, -1.0, 1.0)};
}

/* Spherical four-bars; R-S-S-R, whose rod spins idly; R-U-S-R; R-C-C-C. */
static loop random_loop(randomness *r) {
  static const char *const types[4][MOST_JOINTS] = {{"Rz", "Rz", "Rz", "Rz"},
                                                    {"Rz", "spherical", "spherical", "Rz"},
                                                    {"Rz", "universal", "spherical", "Rz"},
                                                    {"Rz", "cylindrical", "cylindrical", "cylindrical"}};
  int kind = below(r, 4);
  loop l = {.joints = MOST_JOINTS};
  km_vec3 meet = random_vector(r);
  for (int i = 0; i < l.joints; ++i) {
    l.type[i] = types[kind][i];
    l.axis[i] = random_vector(r);
    l.axis[i] = km_vec3_scale(1.0 / km_vec3_norm(l.axis[i]), l.axis[i]);
    l.place[i] = kind == 0 ? km_vec3_axpy(uniform(r, -1.0, 1.0), l.axis[i], meet) : random_vector(r);
    l.mass[i] = uniform(r, 0.0, 3.0);
    l.centre[i] = random_vector(r);
  }
  if (kind == 1) /* nothing turns the rod about its line */
    l.centre[2] = km_vec3_axpy(uniform(r, 0.0, 1.0), km_vec3_sub(l.place[2], l.place[1]), l.place[1]);
  return l;
}

static void write_frame(const loop *l, int joint, km_text *out) {
  km_vec3 c = l->axis[joint], other = fabs(c.x) < 0.6 ? (km_vec3){1, 0, 0} : (km_vec3){0, 1, 0};
  km_vec3 a = km_vec3_cross(other, c);
  a = km_vec3_scale(1.0 / km_vec3_norm(a), a);
  km_vec3 b = km_vec3_cross(c, a), p = l->place[joint];
  km_text_format(out,
                 "{\"name\": \"j%d\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, "
                 "%.17g], [%.17g, %.17g, %.17g]]}",
                 joint, p.x, p.y, p.z, a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z);
}

static char *text_of(const loop *l) {
  km_text out = {0};
  km_text_add(&out, "{\"fixed\": {\"frames\": [");
  write_frame(l, 0, &out);
  km_text_add(&out, ", ");
  write_frame(l, l->joints - 1, &out);
  km_text_add(&out, "]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int b = 1; b < l->joints; ++b) {
    km_vec3 c = l->centre[b];
    km_text_format(&out,
                   "%s{\"name\": \"b%d\", \"mass\": %.17g, \"center_of_mass\": [%.17g, %.17g, %.17g], \"frames\": [",
                   b > 1 ? ", " : "", b, l->mass[b], c.x, c.y, c.z);
    write_frame(l, b - 1, &out);
    km_text_add(&out, ", ");
    write_frame(l, b, &out);
    km_text_add(&out, "]}");
  }
  km_text_add(&out, "], \"joints\": [");
  for (int i = 0; i < l->joints; ++i) {
    char parent[16] = "fixed", child[16] = "fixed";
    if (i > 0)
      snprintf(parent, sizeof parent, "b%d", i);
    if (i + 1 < l->joints)
      snprintf(child, sizeof child, "b%d", i + 1);
    km_text_format(
        &out, "%s{\"name\": \"J%d\", \"type\": \"%s\", \"body_frame_pairs\": [[\"%s\", \"j%d\"], [\"%s\", \"j%d\"]]}",
        i ? ", " : "", i, l->type[i], parent, i, child, i);
  }
  km_text_add(&out, "]}]}");
  return out.data;
}

/* One sweep and what acts: weights and a force on the crank's or the rocker's end. */
typedef struct spatial_case {
  loop l;
  km_sweep_plan plan;
  int actuator;
  km_vec3 gravity, force;
  int loaded; /* body */
  course course;
  double last_s, last_q, last_work;
} spatial_case;

static spatial_case make(randomness *r) {
  spatial_case k = {.l = random_loop(r)};
  k.gravity = km_vec3_scale(9.0, random_vector(r));
  k.force = km_vec3_scale(20.0, random_vector(r));
  k.loaded = below(r, 2) ? 1 : 3;
  k.plan = (km_sweep_plan){.coordinate = 0,
                           .direction = -1,
                           .sign = 1.0,
                           .to = (below(r, 2) ? 1.0 : -1.0) * uniform(r, 0.5, 4.0),
                           .steps = 1 + below(r, 60)};
  if (strcmp(k.l.type[1], "spherical") != 0 && below(r, 3) == 0)
    k.plan.arclength = uniform(r, 1.0, 5.0) / k.plan.steps;
  return k;
}

/* The frame of the loaded body where the force acts: that of its joint to the next body. */
static int frame_of(const spatial_case *k, const fixture *f) {
  return f->model->joints[k->loaded].frame[0];
}

static double work(const spatial_case *k, fixture *f) {
  km_poses_compute(f->mechanism, f->state);
  double sum = 0.0;
  for (int b = 1; b < k->l.joints; ++b)
    sum += k->l.mass[b] * km_vec3_dot(k->gravity, km_pose_point(&f->state->pose[b], k->l.centre[b]));
  const km_model_frame *frame = &f->model->frames[frame_of(k, f)];
  return sum + km_vec3_dot(k->force, km_pose_point(&f->state->pose[k->loaded], frame->pose.p));
}

/* n and d by differences, midway between samples; at the last one the end itself if it is a dead point of the
 * driver. */
static void look(void *context, fixture *f, int i, double s) {
  spatial_case *k = context;
  course *c = &k->course;
  double q = f->state->q[k->actuator], W = work(k, f);
  if (i > 0) {
    c->s[i - 1] = i == SAMPLES && c->by_root ? s : 0.5 * (s + k->last_s);
    c->n[i - 1] = k->last_work - W;
    c->d[i - 1] = q - k->last_q;
  }
  k->last_s = s;
  k->last_q = q;
  k->last_work = W;
}

static km_status sweep_of(const spatial_case *k, fixture *f, km_statics_sweep *sweep) {
  km_load load = {frame_of(k, f), {k->force.x, k->force.y, k->force.z}, {0, 0, 0}, false, NULL};
  km_forces *forces = NULL;
  km_statics statics = {0};
  km_status status =
      km_forces_create(f->mechanism, (double[3]){k->gravity.x, k->gravity.y, k->gravity.z}, &load, 1, &forces, NULL);
  if (!status)
    status = km_statics_create(f->mechanism, &k->actuator, 1, KM_AXES_JOINT, &statics, NULL);
  if (!status)
    status = km_statics_sweep_run(f->mechanism, f->state, &k->plan, forces, &statics, sweep, NULL);
  km_statics_free(&statics);
  km_forces_free(forces);
  return status;
}

bool family_spatial_forces(uint64_t seed, family_count *count) {
  randomness r = {seed};
  spatial_case k = make(&r);
  char *text = text_of(&k.l);
  fixture f = fixture_read(text), g = fixture_read(text);
  km_free(text);
  /* The last hinge, which passes its dead points; of cylinders, any coordinate but the driver. */
  int last = f.model->coordinate_count - 1;
  k.actuator = strcmp(k.l.type[1], "cylindrical") == 0 ? 1 + below(&r, last) : below(&r, 4) ? last : 0;
  km_statics_sweep sweep = {0};
  km_status status = sweep_of(&k, &f, &sweep);
  bool right = status == KM_OK || status == KM_PARTIAL;
  k.course = course_make(SAMPLES, &k.plan, &sweep.motion);
  k.course.differences = true;
  bool long_enough = fabs(sweep.motion.end.position) > 0.01; /* else differences are rounding */
  if (right && long_enough && sweep.motion.start.stop == KM_STOP_NONE &&
      course_walk(&g, &k.plan, &sweep.motion, SAMPLES + 1, look, &k)) {
    /* Half-way between two poses the difference errs by the square of their distance. */
    right = course_agrees(&k.course, &sweep, 0, 1e-6, count);
  }
  if (!right)
    print_error("spatial forces, seed %llu: %s-%s-%s-%s, %s\n", (unsigned long long)seed, k.l.type[0], k.l.type[1],
                k.l.type[2], k.l.type[3], k.plan.arclength > 0.0 ? "by arc length" : "by a driver");
  course_free(&k.course);
  km_statics_sweep_free(&sweep);
  fixture_close(&f);
  fixture_close(&g);
  return right;
}
