/* A family of planar linkages of one or two freedoms: actuators' forces along sweeps against Cramer's rule. */
#include "support/course.h"
#include "support/planar.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 3000, MOST_LOADS = 2 };

/* Tolerance of events: with two freedoms the path depends on its steps, by 1e-4 a step of the sweep. */
static const double least_path = 5e-3;

/* One sweep and what acts. */
typedef struct planar_case {
  planar p;
  km_sweep_plan plan;
  int actuators[2];
  double gravity[2];
  planar_load loads[MOST_LOADS];
  int loaded[MOST_LOADS]; /* joints at whose places they act, on the child */
  int load_count;
  course course[2];
} planar_case;

static planar_case make(randomness *r, int freedoms) {
  planar_case k = {.load_count = below(r, MOST_LOADS + 1), .gravity = {uniform(r, -9.0, 9.0), uniform(r, -9.0, 9.0)}};
  k.p = planar_random(r, freedoms, 1 + below(r, 2), false);
  for (int i = 0; i < k.load_count; ++i) {
    const planar_joint *j = &k.p.joint[k.loaded[i] = below(r, k.p.joints)];
    k.loads[i] =
        (planar_load){j->child, {j->place[0], j->place[1]}, {uniform(r, -20.0, 20.0), uniform(r, -20.0, 20.0)}};
  }
  for (int i = 0; i < freedoms; ++i)
    do
      k.actuators[i] = below(r, k.p.joints);
    while (i == 1 && k.actuators[1] == k.actuators[0]);
  bool by_length = freedoms == 1 && below(r, 2);
  k.plan = (km_sweep_plan){.coordinate = below(r, 2) ? 0 : below(r, k.p.joints),
                           .direction = -1,
                           .sign = 1.0,
                           .to = (below(r, 2) ? 1.0 : -1.0) * uniform(r, 0.4, 2.5),
                           .steps = 1 + below(r, 60)};
  if (by_length)
    k.plan.arclength = uniform(r, 1.0, 4.0) / k.plan.steps;
  return k;
}

/* Cramer's rule: n and d of every actuator at the pose. */
static void ratios(const planar_case *k, const fixture *f, double *n, double *d) {
  planar_balance b;
  double M[PLANAR_MOST_SIZE * PLANAR_MOST_SIZE];
  planar_balance_at(&k->p, f, k->gravity, k->loads, k->load_count, &b);
  size_t rows = (size_t)b.rows, reactions = 2 * (size_t)k->p.joints, column = sizeof(double) * rows;
  for (int which = -1; which < k->p.freedoms; ++which) {
    memcpy(M, b.A, reactions * column);
    for (int a = 0; a < k->p.freedoms; ++a) {
      double *to = M + (reactions + (size_t)a) * rows;
      memcpy(to, b.A + (reactions + (size_t)k->actuators[a]) * rows, column);
      for (size_t i = 0; i < rows && a == which; ++i)
        to[i] = -b.load[i];
    }
    double det = planar_determinant(M, b.rows);
    if (which < 0)
      *d = det;
    else
      n[which] = det;
  }
}

static void look(void *context, fixture *f, int i, double s) {
  planar_case *k = context;
  double n[2] = {0}, d = 1.0;
  ratios(k, f, n, &d);
  for (int a = 0; a < k->p.freedoms; ++a) {
    k->course[a].s[i] = s;
    k->course[a].n[i] = n[a];
    k->course[a].d[i] = d;
  }
}

static km_status sweep_of(const planar_case *k, fixture *f, km_statics_sweep *sweep) {
  km_load loads[MOST_LOADS];
  for (int i = 0; i < k->load_count; ++i) {
    km_vec3 force = planar_in_space(&k->p, k->loads[i].force);
    loads[i] = (km_load){f->model->joints[k->loaded[i]].frame[1], {force.x, force.y, force.z}, {0, 0, 0}, false, NULL};
  }
  km_vec3 g = planar_in_space(&k->p, k->gravity);
  km_forces *forces = NULL;
  km_statics statics = {0};
  km_status status = km_forces_create(f->mechanism, (double[3]){g.x, g.y, g.z}, loads, k->load_count, &forces, NULL);
  if (!status)
    status = km_statics_create(f->mechanism, k->actuators, k->p.freedoms, KM_AXES_JOINT, &statics, NULL);
  if (!status)
    status = km_statics_sweep_run(f->mechanism, f->state, &k->plan, forces, &statics, sweep, NULL);
  km_statics_free(&statics);
  km_forces_free(forces);
  return status;
}

/* True if the set of actuators moves all freedoms somewhere. */
static bool drives(const course *c) {
  double largest = 0.0;
  for (int i = 0; i < c->count; ++i)
    largest = fmax(largest, fabs(c->d[i]));
  return largest > 1e-9;
}

static bool family(uint64_t seed, int freedoms, family_count *count) {
  randomness r = {seed};
  planar_case k = make(&r, freedoms);
  char *text = planar_text(&k.p);
  fixture f = fixture_read(text), g = fixture_read(text);
  course *c = k.course;
  km_statics_sweep sweep = {0};
  km_free(text);
  km_status status = sweep_of(&k, &f, &sweep);
  c[0] = course_make(SAMPLES, &k.plan, &sweep.motion);
  c[1] = course_make(SAMPLES, &k.plan, &sweep.motion);
  bool right = status == KM_OK || status == KM_PARTIAL;
  if (right && sweep.motion.start.stop == KM_STOP_NONE && course_walk(&g, &k.plan, &sweep.motion, SAMPLES, look, &k) &&
      drives(c)) {
    for (int a = 0; a < k.p.freedoms; ++a)
      right = course_agrees(&c[a], &sweep, a, k.p.freedoms > 1 ? least_path : 1e-8, count) && right;
  }
  if (!right)
    print_error("planar forces, seed %llu: %d freedoms, %s\n", (unsigned long long)seed, k.p.freedoms,
                k.plan.arclength > 0.0 ? "by arc length" : "by a driver");
  course_free(&c[0]);
  course_free(&c[1]);
  km_statics_sweep_free(&sweep);
  fixture_close(&f);
  fixture_close(&g);
  return right;
}

bool family_planar_forces(uint64_t seed, family_count *count) {
  return family(seed, 1, count);
}

bool family_two_freedoms(uint64_t seed, family_count *count) {
  return family(seed, 2, count);
}
