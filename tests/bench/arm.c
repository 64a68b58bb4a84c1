/* A greedy step of a 7R arm (forward kinematics, Jacobian, partition, rotation onto the path) against the same rates by
 * LAPACK's singular values, Eigen's LLT and Orocos KDL; and the nodes of look-ahead against greedy steps. */
#include "bench.h"
#include "machine.h"

#ifdef BENCH_KDL
#include "kdl.h"
#endif
#ifdef BENCH_EIGEN
#include "eigen.h"
#endif
#include "arm/path_control.h"
#include "arm/study/path_study.h"
#include "arm/tracking/seven_joint_arm.h"
#include "arm/tracking/track.h"
#include "arm/tracking/tracker.h"

#include <lapacke.h>
#include <stdio.h>
#include <string.h>

enum { POSES = 16, N = 7 };
static const char name[] = "arm/iiwa14";

typedef struct problem {
  bench_machine machine;
  km_arm *arm;
  km_arm_space space;
  double q[POSES][N], xi[POSES][6], rates[N];
  double path[N + 1], self[N];
  double J[6 * N], U[36], VT[6 * N], sigma[6], work[1024];
  lapack_int integers[64];
  int pose;
#ifdef BENCH_KDL
  bench_kdl *kdl;
#endif
} problem;

static int frame_of(const bench_machine *machine) {
  const char *names[2] = {"flange", "tool"};
  int frame;
  if (km_model_find_frame(machine->model, names, 2, &frame, NULL))
    bench_fail(name, "the model has no flange/tool");
  return frame;
}

static void read_problem(problem *p) {
  p->machine = bench_machine_load("iiwa14");
  if (km_arm_create(p->machine.mechanism, p->machine.state, frame_of(&p->machine), KM_TASK_POSE, &p->arm, NULL) ||
      !km_arm_space_create(p->arm, &p->space))
    bench_fail(name, "no arm");
  for (int i = 0; i < POSES; ++i) {
    double size = 0.0;
    for (int k = 0; k < N; ++k)
      p->q[i][k] = 0.4 * sin(1.0 + 0.3 * i + 1.7 * k) + (k == 3 ? -1.4 : 0.3);
    for (int r = 0; r < 6; ++r) {
      p->xi[i][r] = cos(0.5 * i + 2.3 * r);
      size += p->xi[i][r] * p->xi[i][r];
    }
    for (int r = 0; r < 6; ++r)
      p->xi[i][r] /= sqrt(size);
  }
}

static void run_own(void *context) {
  problem *p = context;
  int i = p->pose = (p->pose + 1) % POSES;
  km_arm_update(p->arm, &p->space, p->q[i]);
  km_control_factor(p->arm, &p->space, p->xi[i], NULL);
  double scale = 1.0 / km_control_columns(p->arm, &p->space, p->self, p->path, p->self);
  for (int k = 0; k < N; ++k)
    p->rates[k] = p->path[k] * scale;
}

/* q̇ = V Σ⁻¹ Uᵀ ξ. */
static void run_svd(void *context) {
  problem *p = context;
  int i = p->pose = (p->pose + 1) % POSES;
  km_arm_update(p->arm, &p->space, p->q[i]);
  memcpy(p->J, p->space.jacobian, sizeof p->J);
  LAPACKE_dgesdd_work(LAPACK_COL_MAJOR, 'S', 6, N, p->J, 6, p->sigma, p->U, 6, p->VT, 6, p->work, 1024, p->integers);
  memset(p->rates, 0, sizeof p->rates);
  for (int r = 0; r < 6; ++r) {
    double along = 0.0;
    for (int c = 0; c < 6; ++c)
      along += p->U[6 * r + c] * p->xi[i][c];
    for (int k = 0; k < N; ++k)
      p->rates[k] += along / p->sigma[r] * p->VT[6 * k + r];
  }
}

#ifdef BENCH_EIGEN
static void run_eigen(void *context) {
  problem *p = context;
  int i = p->pose = (p->pose + 1) % POSES;
  km_arm_update(p->arm, &p->space, p->q[i]);
  bench_eigen_llt(p->space.jacobian, p->xi[i], p->rates);
}
#endif

#ifdef BENCH_KDL
static void make_kdl(problem *p) {
  double zero[N] = {0}, axis[3 * N], point[3 * N], tip[3] = {p->space.pose.p.x, p->space.pose.p.y, p->space.pose.p.z};
  km_arm_update(p->arm, &p->space, zero);
  tip[0] = p->space.pose.p.x;
  tip[1] = p->space.pose.p.y;
  tip[2] = p->space.pose.p.z;
  for (int k = 0; k < N; ++k) {
    memcpy(axis + 3 * k, &p->space.seven->axis[k], 3 * sizeof *axis);
    memcpy(point + 3 * k, &p->space.seven->point[k], 3 * sizeof *point);
  }
  p->kdl = bench_kdl_create(N, axis, point, tip);
}

static void run_kdl_pinv(void *context) {
  problem *p = context;
  int i = p->pose = (p->pose + 1) % POSES;
  bench_kdl_pinv(p->kdl, p->q[i], p->xi[i], p->rates);
}

static void run_kdl_wdls(void *context) {
  problem *p = context;
  int i = p->pose = (p->pose + 1) % POSES;
  bench_kdl_wdls(p->kdl, p->q[i], p->xi[i], p->rates);
}
#endif

static void agree(problem *p, const bench_contender *a, const bench_contender *b, double tolerance) {
  double rates[N];
  for (int i = 0; i < POSES; ++i) {
    p->pose = i;
    a->run(p);
    memcpy(rates, p->rates, sizeof rates);
    p->pose = i;
    b->run(p);
    bench_agree(name, b->name, rates, p->rates, N, tolerance);
  }
}

static void bench_step(void) {
  static problem p;
  read_problem(&p);
  bench_contender c[] = {
      {.name = "greedy step", .run = run_own, .context = &p},
      {.name = "by LAPACK's singular values", .run = run_svd, .context = &p},
#ifdef BENCH_EIGEN
      {.name = "own kinematics with Eigen's LLT", .run = run_eigen, .context = &p},
#endif
#ifdef BENCH_KDL
      {.name = "KDL pinv", .run = run_kdl_pinv, .context = &p},
      {.name = "KDL wdls", .run = run_kdl_wdls, .context = &p},
#endif
  };
  int count = sizeof c / sizeof *c;
#ifdef BENCH_KDL
  make_kdl(&p);
#endif
  for (int i = 1; i < count; ++i)
    agree(&p, &c[0], &c[i], 1e-9);
  bench_time(c, count);
  bench_figure(name, "greedy step, ns", c[0].median);
  for (int i = 1; i < count; ++i) {
    char text[80];
    snprintf(text, sizeof text, "%s / greedy step", c[i].name);
    bench_figure(name, text, bench_ratio(&c[i], &c[0]));
  }
#ifdef BENCH_KDL
  bench_kdl_free(p.kdl);
#endif
  km_arm_space_free(&p.space);
  km_arm_free(p.arm);
  bench_machine_free(&p.machine);
}

static const char study_text[] =
    "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0],"
    "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [0.4, 0.45, 0.5], \"steps\": 192}]},"
    "\"methods\": \"lookahead\", \"objective\": \"path-control\"}";

typedef struct walker {
  const km_study *study;
  int jobs;
  km_tracker tracker;
  km_tracker_space space;
  km_arena arena;
  km_path_node start, nodes[2], siblings[KM_STEP_BATCH];
} walker;

static void run_steps(void *context) {
  static const km_step_choice greedy_choice = {0};
  walker *w = context;
  km_path_node_copy(w->tracker.arm, &w->nodes[0], &w->start);
  for (int i = 0; i < w->study->path->samples - 1; ++i)
    if (km_tracker_step(&w->tracker, &w->space, i, 1.0, &w->nodes[i % 2], &greedy_choice, &w->nodes[1 - i % 2]).stop)
      bench_fail(name, "the track stops");
}

/* Eight branches from the start, and the same one by one. */
static const double tan_phis[KM_STEP_BATCH] = {-0.5, -0.3, -0.1, 0.0, 0.1, 0.2, 0.3, 0.5};

static void run_abreast(void *context) {
  walker *w = context;
  const km_path_node *from[KM_STEP_BATCH];
  km_path_node *to[KM_STEP_BATCH];
  km_step_choice choices[KM_STEP_BATCH];
  km_step_end ends[KM_STEP_BATCH];
  static const int samples[KM_STEP_BATCH] = {0};
  for (int i = 0; i < KM_STEP_BATCH; ++i) {
    from[i] = &w->start;
    to[i] = &w->siblings[i];
    choices[i] = (km_step_choice){.tan_phi = &tan_phis[i]};
  }
  km_tracker_steps(&w->tracker, &w->space, samples, KM_STEP_BATCH, from, choices, to, ends);
}

static void run_one_by_one(void *context) {
  walker *w = context;
  for (int i = 0; i < KM_STEP_BATCH; ++i) {
    const km_step_choice choice = {.tan_phi = &tan_phis[i]};
    km_tracker_step(&w->tracker, &w->space, 0, 1.0, &w->start, &choice, &w->siblings[i]);
  }
}

static void run_look_ahead(void *context) {
  walker *w = context;
  km_track_plan plan = km_study_plan(w->study, 0);
  km_track *track;
  plan.jobs = w->jobs;
  if (km_track_run(km_study_arm(w->study), &plan, &track, NULL))
    bench_fail(name, "the track stops");
  km_track_free(track);
}

/* Steps of all the trees of a run: levels of `stride` samples, cut at the path's end. */
static double tree_steps(int samples, int branches, int levels) {
  int stride = samples / 12;
  double steps = 0.0;
  for (int i = 0; i < samples - 1; ++i) {
    int left = samples - 1 - i;
    double nodes = 1.0;
    for (int l = 0; l < levels && left > 0; ++l) {
      nodes *= branches;
      steps += nodes * (left < stride ? left : stride);
      left -= stride;
    }
  }
  return steps;
}

static walker walker_of(const km_study *study, int jobs) {
  static const km_step_choice greedy_choice = {0};
  walker w = {.study = study, .jobs = jobs, .tracker = {study->arm, study->path, &study->objective}};
  double q[N];
  bool is_ok = km_tracker_space_create(study->arm, &w.space) && km_path_node_create(study->arm, &w.arena, &w.start);
  for (int i = 0; i < 2 && is_ok; ++i)
    is_ok = km_path_node_create(study->arm, &w.arena, &w.nodes[i]);
  for (int i = 0; i < KM_STEP_BATCH && is_ok; ++i)
    is_ok = km_path_node_create(study->arm, &w.arena, &w.siblings[i]);
  if (!is_ok)
    bench_fail(name, "out of memory");
  for (int k = 0; k < N; ++k)
    q[k] = km_arm_from_units(study->arm, k, study->start[k]);
  km_tracker_compute_node(&w.tracker, &w.space, 0, q, &greedy_choice, &w.start);
  return w;
}

static void walker_free(walker *w) {
  km_tracker_space_free(&w->space);
  km_arena_free(&w->arena);
}

static void agree_abreast(walker *w) {
  double q[KM_STEP_BATCH][N];
  run_abreast(w);
  for (int i = 0; i < KM_STEP_BATCH; ++i)
    memcpy(q[i], w->siblings[i].q, sizeof q[i]);
  run_one_by_one(w);
  for (int i = 0; i < KM_STEP_BATCH; ++i)
    bench_agree(name, "siblings side by side", q[i], w->siblings[i].q, N, 0.0);
}

static void bench_nodes(void) {
  bench_machine machine = bench_machine_load("iiwa14");
  km_study_def def = km_study_def_default();
  km_study *study;
  if (km_study_read(study_text, strlen(study_text), "", NULL, &def, NULL) ||
      km_study_bind(machine.mechanism, machine.state, &def, 1, NULL, &study, NULL))
    bench_fail(name, "no study");
  walker one = walker_of(study, 1), two = walker_of(study, 2);
  agree_abreast(&one);
  bench_contender c[] = {{.name = "192 greedy steps on a path", .run = run_steps, .context = &one},
                         {.name = "eight siblings one by one", .run = run_one_by_one, .context = &one},
                         {.name = "eight siblings side by side", .run = run_abreast, .context = &one},
                         {.name = "look-ahead", .run = run_look_ahead, .context = &one},
                         {.name = "look-ahead on two threads", .run = run_look_ahead, .context = &two}};
  int intervals = study->path->samples - 1;
  double nodes = tree_steps(study->path->samples, 3, 3);
  bench_time(c, sizeof c / sizeof *c);
  bench_figure(name, "greedy, steps on a path a second", intervals / c[0].median * 1e9);
  bench_figure(name, "siblings one by one / side by side", bench_ratio(&c[1], &c[2]));
  bench_figure(name, "look-ahead, nodes a second", nodes / c[3].median * 1e9);
  bench_figure(name, "look-ahead, nodes a second on two threads", nodes / c[4].median * 1e9);
  bench_figure(name, "greedy step on a path / look-ahead node", bench_ratio(&c[0], &c[3]) * nodes / intervals);
  walker_free(&one);
  walker_free(&two);
  km_study_free(study);
  km_study_def_free(&def);
  bench_machine_free(&machine);
}

void bench_arm(void) {
  bench_step();
  bench_nodes();
}
