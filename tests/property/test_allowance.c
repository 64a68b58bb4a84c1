/* Allowance of redundant constraints: the ratio of support functions against a search over all directions; misfits and
 * ratios against mechanisms that are assembled with errors and play by their full kinematics; the statistical bound
 * against samples; other units; couplings; no redundant constraint, no play.
 *
 *   assembled: λ* = min over δ, q of max_j |δ_j|/c_j subject to the closure of the loops, found by weights that grow
 *              with |δ_j|/c_j: an upper bound of λ* that the support ratio, a lower one, must meet */
#include "support/support.h"

#include "allowance/strain_forces.h"
#include "base/table.h"
#include "kinematics/body_poses.h"
#include "model/initial_poses.h"
#include "rounding/loop_gaps.h"

#include <math.h>

#include <string.h>

/* ---- The ratio of support functions */

enum { FEW_ROWS = 24 };

static km_support_terms random_terms(randomness *r, int n, double *W, double *length, km_support_term *terms) {
  km_support_terms t = {FEW_ROWS, n, W, length, terms, terms + FEW_ROWS / 3, 4, 4};
  for (int k = 0; k < FEW_ROWS; ++k) {
    length[k] = 0.0;
    for (int i = 0; i < n; ++i) {
      W[k * n + i] = uniform(r, -1.0, 1.0);
      length[k] = hypot(length[k], W[k * n + i]);
    }
  }
  for (int k = 0; k < FEW_ROWS / 3; ++k)
    terms[k < 4 ? k : k + FEW_ROWS / 3 - 4] = (km_support_term){uniform(r, 0.2, 2.0), 3 * k, 1 + below(r, 3), k};
  return t;
}

/* Largest ratio over a grid of directions of up to three components, refined around the best one. */
static double largest_on_grid(const km_support_terms *t, bool squared) {
  double best = 0.0, at[2] = {0.0, 0.0}, width = M_PI;
  for (int round = 0; round < 8; ++round, width *= round == 1 ? 0.02 : 0.1) {
    const double centre[2] = {at[0], at[1]};
    const int points = round == 0 ? 150 : 20, others = t->dimension == 3 ? points : 0;
    for (int i = -points; i <= points; ++i)
      for (int k = -others; k <= others; ++k) {
        double u = centre[0] + width * i / points, v = centre[1] + width * k / points;
        double a[3] = {cos(u) * cos(v), sin(u) * cos(v), sin(v)};
        double ratio = km_support(t, t->error, t->error_count, a, squared, -1) /
                       km_support(t, t->play, t->play_count, a, false, -1);
        if (ratio > best) {
          best = ratio;
          at[0] = u;
          at[1] = v;
        }
      }
  }
  return best;
}

static void test_ratio_by_search(void **state) {
  (void)state;
  randomness r = {5};
  for (int i = 0; i < 24; ++i) {
    double W[3 * FEW_ROWS], length[FEW_ROWS];
    km_support_term terms[2 * FEW_ROWS / 3];
    const int n = 1 + i % 3;
    const bool squared = i % 2 == 0;
    km_support_terms t = random_terms(&r, n, W, length, terms);
    km_arena arena = {0};
    km_ratio_search search;
    assert_true(km_ratio_search_create(n, 4, &arena, &search));
    double found = km_ratio_search_next(&search, &t, squared, NULL);
    double sought = largest_on_grid(&t, squared);
    assert_near(found / sought, 1.0, 2e-4); /* an ascent ends with a gain of 1e-6 a step */
    assert_near(km_support(&t, t.error, t.error_count, search.track, squared, -1) /
                    km_support(&t, t.play, t.play_count, search.track, false, -1),
                found, 2e-6 * found); /* equal maxima are one, to 1e-6 */
    bool counts[FEW_ROWS / 3] = {false};
    search.count = 0;
    assert_true(km_ratio_search_next(&search, &t, squared, counts) == HUGE_VAL);
    km_arena_free(&arena);
  }
}

/* ---- Mechanisms assembled with errors and play */

enum { PLAYS = 3 }; /* parts of a play: across the axis, along it, angular */
enum { MOST_JOINTS = 24, MOST_ROWS = 60 };

/* A configuration of a mechanism, with its self-stresses and loop equations. */
typedef struct assembled {
  fixture f;
  km_self_stress stress;
  km_support_terms terms;
  km_fit_defaults fits;
  km_arena arena;
  km_loop_gaps gaps;
  km_pose *exact;      /* [frame] */
  double (*error)[12]; /* [joint] displacement and rotation of the parent's and the child's frame */
  double (*play)[6];   /* [joint] displacement and rotation of the child's side */
} assembled;

static assembled assemble_at(const char *name, bool moves, const km_fit_defaults *fits) {
  assembled a = {.f = fixture_open(name), .fits = *fits};
  km_mobility numbers;
  km_misfit_component component[KM_MAX_ALLOWANCE];
  int index = 0;
  while (a.f.mechanism->substructures[index].loop_count == 0)
    ++index;
  if (moves) {
    randomness r = {7};
    go_somewhere(&a.f, &r);
  }
  assert_int_equal(km_mobility_compute(a.f.mechanism, a.f.state, &numbers), KM_OK);
  km_poses_compute(a.f.mechanism, a.f.state);
  assert_true(km_self_stress_count(a.f.state, index) > 0);
  assert_true(km_misfit_components_choose(a.f.mechanism, a.f.state, index, component));
  assert_true(km_self_stress_compute(a.f.mechanism, a.f.state, index, component, &a.arena, &a.stress));
  assert_true(km_fit_terms_create(a.f.mechanism, &a.stress, &a.fits, &a.arena, &a.terms));
  assert_true(km_loop_gaps_create(a.f.mechanism, a.f.state, index, &a.arena, &a.gaps));
  a.gaps.keeps_planes = false;
  const km_model *model = a.f.mechanism->model;
  a.exact = KM_ARENA_NEW(&a.arena, km_pose, (size_t)model->frame_count);
  a.error = km_arena_alloc(&a.arena, (size_t)model->joint_count, sizeof *a.error);
  a.play = km_arena_alloc(&a.arena, (size_t)model->joint_count, sizeof *a.play);
  for (int i = 0; i < model->frame_count; ++i)
    a.exact[i] = model->frames[i].pose;
  return a;
}

static void close_assembled(assembled *a) {
  km_arena_free(&a->arena);
  fixture_close(&a->f);
}

static km_pose displaced(const km_pose *pose, const double by[6], double sense) {
  km_pose step = {.R = km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(sense, km_vec3_from_array(by + 3)))),
                  .p = km_vec3_scale(sense, km_vec3_from_array(by))};
  return km_pose_product(pose, &step);
}

/* Sets the frames of all joints to their errors and plays; a play is a displacement of the child's side by −δ. */
static void set_frames(assembled *a) {
  km_model *model = a->f.model;
  for (int j = 0; j < model->joint_count; ++j) {
    const int *frame = model->joints[j].frame;
    model->frames[frame[0]].pose = displaced(&a->exact[frame[0]], a->error[j], 1.0);
    km_pose child = displaced(&a->exact[frame[1]], a->error[j] + 6, 1.0);
    model->frames[frame[1]].pose = displaced(&child, a->play[j], -1.0);
  }
}

/* Misfit of all loops per unit of each play, by differences, P[rows × 6 joints]. */
static void play_columns(assembled *a, double *P, double *e, double *J) {
  static const double step = 1e-6;
  const int rows = a->gaps.rows;
  for (int i = 0; i < a->stress.joint_count; ++i)
    for (int k = 0; k < 6; ++k) {
      double *play = &a->play[a->stress.joint[i]][k], kept = *play, *column = P + (size_t)(6 * i + k) * (size_t)rows;
      for (int side = 1; side >= -1; side -= 2) {
        *play = kept + side * step;
        set_frames(a);
        km_loop_gaps_compute(&a->gaps, e, J);
        for (int r = 0; r < rows; ++r)
          column[r] = side > 0 ? e[r] : (column[r] - e[r]) / (2.0 * step);
      }
      *play = kept;
    }
  set_frames(a);
}

static int axis_of(const km_model *model, int joint) {
  const km_joint_type type = model->joints[joint].type;
  return type == KM_RX || type == KM_TX ? 0 : type == KM_RY || type == KM_TY ? 1 : 2;
}

/* Solves the positive definite system S x = b by Gauss elimination; x replaces b. */
static void solve_symmetric(double *S, double *b, int n) {
  for (int i = 0; i < n; ++i)
    for (int r = i + 1; r < n; ++r) {
      double factor = S[r * n + i] / S[i * n + i];
      for (int k = i; k < n; ++k)
        S[r * n + k] -= factor * S[i * n + k];
      b[r] -= factor * b[i];
    }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k)
      b[i] -= S[i * n + k] * b[k];
    b[i] /= S[i * n + i];
  }
}

/* Part of a joint's play to which component k of its displacement belongs. */
static int part_of(const assembled *a, int joint, int k) {
  return k >= 3 ? 2 : k == axis_of(a->f.mechanism->model, joint) ? 1 : 0;
}

/* A linear problem: e + J dq + P δ = 0 with the least largest |δ|/c. */
typedef struct closing {
  int rows, columns, joints;
  double e[MOST_ROWS], J[MOST_ROWS * MOST_ROWS], P[MOST_ROWS * 6 * MOST_JOINTS];
  double weight[PLAYS * MOST_JOINTS];
  double delta[MOST_JOINTS][6], dq[MOST_ROWS];
} closing;

/* The δ, dq of least Σ weight |δ/c|², where dq costs a thousandth; the largest |δ|/c, and each in used[]. */
static double solve_weighted(const assembled *a, closing *l, double *used) {
  static double S[MOST_ROWS * MOST_ROWS], y[MOST_ROWS];
  const int rows = l->rows;
  const double cheap = 1e3 * a->fits.play * a->fits.play;
  memset(S, 0, sizeof S);
  double scale[6 * MOST_JOINTS];
  for (int k = 0; k < 6 * l->joints; ++k) {
    const double play = k % 6 < 3 ? a->fits.play : a->fits.angle;
    scale[k] = play * play / l->weight[PLAYS * (k / 6) + part_of(a, a->stress.joint[k / 6], k % 6)];
  }
  for (int r = 0; r < rows; ++r) {
    for (int q = 0; q < rows; ++q) {
      for (int c = 0; c < l->columns; ++c)
        S[r * rows + q] += cheap * l->J[c * rows + r] * l->J[c * rows + q];
      for (int k = 0; k < 6 * l->joints; ++k)
        S[r * rows + q] += scale[k] * l->P[k * rows + r] * l->P[k * rows + q];
    }
    y[r] = -l->e[r];
  }
  solve_symmetric(S, y, rows);
  for (int c = 0; c < l->columns; ++c) {
    l->dq[c] = 0.0;
    for (int r = 0; r < rows; ++r)
      l->dq[c] += cheap * l->J[c * rows + r] * y[r];
  }
  double square[PLAYS * MOST_JOINTS] = {0}, most = 0.0;
  for (int k = 0; k < 6 * l->joints; ++k) {
    double delta = 0.0, play = k % 6 < 3 ? a->fits.play : a->fits.angle;
    for (int r = 0; r < rows; ++r)
      delta += scale[k] * l->P[k * rows + r] * y[r];
    l->delta[k / 6][k % 6] = delta;
    square[PLAYS * (k / 6) + part_of(a, a->stress.joint[k / 6], k % 6)] += delta * delta / (play * play);
  }
  for (int g = 0; g < PLAYS * l->joints; ++g)
    most = fmax(most, used[g] = sqrt(square[g]));
  return most;
}

/* Raises the weights of plays that are used more than others; returns the least largest |δ|/c. */
static double least_play(const assembled *a, closing *l) {
  double best = HUGE_VAL, used[PLAYS * MOST_JOINTS], delta[MOST_JOINTS][6], dq[MOST_ROWS];
  for (int g = 0; g < PLAYS * l->joints; ++g)
    l->weight[g] = 1.0;
  for (int step = 0; step < 600; ++step) {
    double most = solve_weighted(a, l, used), sum = 0.0;
    if (most < best) {
      best = most;
      memcpy(delta, l->delta, sizeof delta);
      memcpy(dq, l->dq, sizeof dq);
    }
    for (int g = 0; g < PLAYS * l->joints; ++g)
      sum += l->weight[g] *= pow(fmax(used[g] / most, 1e-6), 0.5);
    for (int g = 0; g < PLAYS * l->joints; ++g)
      l->weight[g] = fmax(l->weight[g] * PLAYS * l->joints / sum, 1e-5);
  }
  memcpy(l->delta, delta, sizeof delta);
  memcpy(l->dq, dq, sizeof dq);
  return best;
}

/* Least largest |δ_j|/c_j for which the loops close with the errors, by full kinematics. */
static double needed_play(assembled *a) {
  static closing l;
  const km_substructure *sub = &a->f.mechanism->substructures[a->gaps.index];
  double needed = 0.0, e[MOST_ROWS], J[MOST_ROWS * MOST_ROWS];
  l.rows = a->gaps.rows;
  l.columns = a->gaps.columns;
  l.joints = a->stress.joint_count;
  assert_true(l.rows <= MOST_ROWS && l.columns <= MOST_ROWS && l.joints <= MOST_JOINTS);
  for (int round = 0; round < 3; ++round) {
    play_columns(a, l.P, e, J);
    km_loop_gaps_compute(&a->gaps, l.e, l.J);
    for (int k = 0; k < 6 * l.joints; ++k)
      for (int r = 0; r < l.rows; ++r)
        l.e[r] -= l.P[k * l.rows + r] * a->play[a->stress.joint[k / 6]][k % 6];
    needed = least_play(a, &l);
    for (int i = 0; i < l.joints; ++i)
      memcpy(a->play[a->stress.joint[i]], l.delta[i], sizeof l.delta[i]);
    for (int c = 0; c < l.columns; ++c) {
      int coordinate = a->f.mechanism->column_coordinate[sub->column_start + c];
      a->f.state->q[coordinate] += l.dq[c] * a->f.mechanism->unit[coordinate];
    }
  }
  set_frames(a);
  km_loop_gaps_compute(&a->gaps, e, J);
  for (int r = 0; r < l.rows; ++r)
    assert_at_most(e[r], 1e-9);
  return needed;
}

/* Normal errors with a third of the tolerance as standard deviation, in every joint of the substructure. */
static void draw_errors(assembled *a, randomness *r) {
  for (int i = 0; i < a->stress.joint_count; ++i)
    for (int k = 0; k < 12; ++k) {
      double normal = -6.0;
      for (int n = 0; n < 12; ++n)
        normal += uniform(r, 0.0, 1.0);
      a->error[a->stress.joint[i]][k] = normal / 3.0 * (k % 6 < 3 ? a->fits.position : a->fits.direction);
    }
}

/* The row g of the errors: misfits Σ_j ± (f·displacement + m·rotation) per self-stress, in W's order of components. */
static void errors_row(const assembled *a, double *g) {
  const int n = a->stress.count;
  memset(g, 0, (size_t)n * sizeof *g);
  for (int i = 0; i < a->stress.joint_count; ++i) {
    const int joint = a->stress.joint[i], axis = axis_of(a->f.mechanism->model, joint);
    const km_model_joint *def = &a->f.mechanism->model->joints[joint];
    const double *W = a->stress.wrench + i * KM_STRESS_ROWS * n, *error = a->error[joint];
    km_pose motion = km_model_joint_motion(a->f.mechanism->model, joint, a->f.state->q + def->first_coordinate);
    km_vec3 dp = km_rotate(&motion.R, km_vec3_from_array(error + 6)),
            dt = km_rotate(&motion.R, km_vec3_from_array(error + 9));
    const double move[3] = {error[0] - dp.x, error[1] - dp.y, error[2] - dp.z}, turn[3] = {dt.x, dt.y, dt.z};
    for (int k = 0; k < n; ++k) {
      for (int c = 0; c < 3; ++c) {
        g[k] += W[((c - axis + 2) % 3) * n + k] * move[c];
        g[k] += W[(6 + c) * n + k] * error[3 + c] - W[(3 + c) * n + k] * turn[c];
      }
    }
  }
}

/* The ratio for errors that are known: max gᵀa / c(a). */
static double ratio_of_errors(const assembled *a, double *W, double *length) {
  const km_support_terms *t = &a->terms;
  const int n = t->dimension;
  double g[KM_MAX_ALLOWANCE];
  errors_row(a, g);
  memcpy(W, t->W, (size_t)(t->rows * n) * sizeof *W);
  memcpy(W + t->rows * n, g, (size_t)n * sizeof *W);
  memcpy(length, t->length, (size_t)t->rows * sizeof *length);
  length[t->rows] = 1.0;
  km_support_term known = {1.0, t->rows, 1, 0};
  km_support_terms all = {t->rows + 1, n, W, length, &known, t->play, 1, t->play_count};
  km_arena arena = {0};
  km_ratio_search search;
  assert_true(km_ratio_search_create(n, 2, &arena, &search));
  memcpy(search.track, g, (size_t)n * sizeof *g); /* the maximum is the only one: gᵀa over a convex c */
  search.count = 1;
  double ratio = km_ratio_search_next(&search, &all, false, NULL);
  km_arena_free(&arena);
  return ratio;
}

static const struct {
  const char *model;
  bool moves; /* another configuration than the model's */
} cases[] = {{"bennett", false}, {"bennett", true}, {"sarrus3", false}, {"sarrus4", true},  {"fourbar", true},
             {"klann", false},   {"jansen", true},  {"bricard", false}, {"governor", true}, {"peaucellier", true}};

enum { KNOWN = 4, SAMPLES = 1000 };

static void test_assembled_with_play(void **state) {
  (void)state;
  randomness r = {11};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    const km_fit_defaults fits = {1e-6, 2e-6, 3e-6, 2e-6, false};
    static double W[(MOST_JOINTS * KM_STRESS_ROWS + 1) * KM_MAX_ALLOWANCE], length[MOST_JOINTS * KM_STRESS_ROWS + 1];
    for (int k = 0; k < KNOWN; ++k) {
      assembled a = assemble_at(cases[i].model, cases[i].moves, &fits);
      draw_errors(&a, &r);
      double ratio = ratio_of_errors(&a, W, length), needed = needed_play(&a);
      if (!(needed >= ratio * 0.998 && needed <= ratio * 1.02))
        fail_msg("%s: %g of the play closes the loops, the support ratio is %g", cases[i].model, needed, ratio);
      close_assembled(&a);
    }
  }
}

/* The largest ratio, worst case or statistical, of an assembled configuration. */
static double largest_ratio(const assembled *a, bool statistical) {
  km_arena arena = {0};
  km_ratio_search search;
  assert_true(km_ratio_search_create(a->terms.dimension, 4, &arena, &search));
  double ratio = km_ratio_search_next(&search, &a->terms, statistical, NULL);
  km_arena_free(&arena);
  return statistical ? km_statistical_factor(a->stress.count) * ratio : ratio;
}

/* Samples stay below both bounds: all errors within their tolerances below the worst case, 99.73 % of normal errors
 * below the statistical one. */
static void test_samples_stay_below(void **state) {
  (void)state;
  randomness r = {13};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    const km_fit_defaults fits = {1e-4, 2e-3, 3e-4, 2e-3, false};
    static double W[(MOST_JOINTS * KM_STRESS_ROWS + 1) * KM_MAX_ALLOWANCE], length[MOST_JOINTS * KM_STRESS_ROWS + 1];
    assembled a = assemble_at(cases[i].model, cases[i].moves, &fits);
    double worst = largest_ratio(&a, false), statistical = largest_ratio(&a, true);
    int beyond = 0;
    for (int k = 0; k < SAMPLES; ++k) {
      draw_errors(&a, &r);
      double ratio = ratio_of_errors(&a, W, length);
      beyond += ratio > statistical;
      for (int j = 0; j < a.stress.joint_count; ++j) /* errors at the surface of the tolerances */
        for (int part = 0; part < 4; ++part) {
          double *error = a.error[a.stress.joint[j]] + 3 * part,
                 size = sqrt(error[0] * error[0] + error[1] * error[1] + error[2] * error[2]);
          for (int c = 0; c < 3; ++c)
            error[c] *= (part % 2 ? fits.direction : fits.position) / size;
        }
      assert_true(ratio_of_errors(&a, W, length) <= worst * (1.0 + 1e-6));
    }
    /* 0.27 % of 1 000 samples, and four standard deviations of their number */
    if (beyond > 0.0027 * SAMPLES + 4.0 * sqrt(0.0027 * SAMPLES))
      fail_msg("%s: %d of %d samples need more than the statistical play", cases[i].model, beyond, SAMPLES);
    close_assembled(&a);
  }
}

/* ---- Forces without play */

/* The forces of known errors without play are those of least elastic energy: they equal the minimum-norm solution of
 * the six-row system, with the stiffnesses as weights. */
static void test_forces_by_least_energy(void **state) {
  (void)state;
  static const double force_stiffness = 3e4, moment_stiffness = 7e2;
  static double W[(MOST_JOINTS * KM_STRESS_ROWS + 1) * KM_MAX_ALLOWANCE], length[MOST_JOINTS * KM_STRESS_ROWS + 1];
  static closing l;
  randomness r = {17};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    /* equal weights of the parts, |δ|²/c² with c² = 1/k, are the elastic energy */
    const km_fit_defaults fits = {1e-7, 1e-7, 1.0 / sqrt(force_stiffness), 1.0 / sqrt(moment_stiffness), false};
    assembled a = assemble_at(cases[i].model, cases[i].moves, &fits);
    draw_errors(&a, &r);
    ratio_of_errors(&a, W, length);
    for (int j = 0; j < a.f.model->joint_count; ++j) {
      a.f.model->joints[j].fit.force_stiffness = force_stiffness;
      a.f.model->joints[j].fit.moment_stiffness = moment_stiffness;
    }
    km_support_term known = {1.0, a.terms.rows, 1, 0};
    km_support_terms all = {
        .rows = a.terms.rows + 1, .dimension = a.terms.dimension, .W = W, .error = &known, .error_count = 1};
    km_strain_forces forces[MOST_JOINTS];
    assert_true(km_strain_forces_compute(a.f.mechanism, &a.stress, &all, forces));
    l.rows = a.gaps.rows;
    l.columns = a.gaps.columns;
    l.joints = a.stress.joint_count;
    play_columns(&a, l.P, l.e, l.J);
    km_loop_gaps_compute(&a.gaps, l.e, l.J);
    double used[PLAYS * MOST_JOINTS], largest = 0.0;
    for (int g = 0; g < PLAYS * l.joints; ++g)
      l.weight[g] = 1e6; /* dear beside the coordinates, which are free */
    solve_weighted(&a, &l, used);
    for (int k = 0; k < l.joints; ++k)
      largest = fmax(largest, forces[k].force_worst);
    for (int k = 0; k < l.joints; ++k) {
      const double *d = l.delta[k];
      const double force = force_stiffness * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      assert_near(forces[k].force_worst / largest, force / largest, 1e-4); /* coordinates aren't quite free there */
      assert_near(forces[k].force_worst, forces[k].force_statistical, 1e-9 * largest); /* one known error */
    }
    close_assembled(&a);
  }
}

/* ---- Closed forms and invariance of the sweep */

static km_allowance_sweep sweep_of(const fixture *f, const km_fit_defaults *fits, const char *joint) {
  km_allowance_sweep out;
  km_sweep_plan plan = {.coordinate = -1};
  for (int c = 0; c < km_model_coordinate_count(f->model); ++c)
    if (strcmp(km_model_coordinate_label(f->model, c), joint) == 0)
      plan.coordinate = c;
  double start = km_state_coordinate(f->state, plan.coordinate),
         radian = km_model_coordinate_factor(f->model, plan.coordinate);
  plan.from = start;
  plan.to = start + 1.0 / radian;
  plan.steps = 10;
  km_error error;
  if (km_allowance_sweep_run(f->mechanism, f->state, &plan, fits, &out, &error))
    fail_msg("%s", error.text);
  return out;
}

static double cell(const km_allowance_sweep *a, size_t row, const char *column) {
  int at = km_table_find(a->motion.table, column);
  assert_true(at >= 0);
  return km_table_row(a->motion.table, row)[at];
}

/* A planar four-bar, closed at C: errors of four axes at both ends add up about x and y; along the normal those of the
 * places, and those of the axes times their distance to C. */
static void test_four_bar_in_closed_form(void **state) {
  (void)state;
  const km_fit_defaults fits = {1e-4, 2e-3, 1e-4, 2e-3, false};
  fixture f = fixture_open("fourbar");
  km_allowance_sweep a = sweep_of(&f, &fits, "A");
  assert_int_equal(a.constraint_count, 3);
  assert_int_equal(a.joint_count, 4);
  const size_t last = km_table_rows(a.motion.table) - 1;
  double sum = 0.0, squares = 0.0;
  km_vec3 c = km_joint_pose(f.mechanism, f.state, a.constraints[0].joint).p;
  for (int j = 0; j < 4; ++j) {
    double distance = km_vec3_norm(km_vec3_sub(km_joint_pose(f.mechanism, f.state, j).p, c));
    sum += 2.0 * (fits.position + fits.direction * distance);
    squares += 2.0 * (fits.position * fits.position + fits.direction * fits.direction * distance * distance);
  }
  assert_near(cell(&a, last, "gap.C.z.worst"), sum, 1e-12);
  assert_near(cell(&a, last, "gap.C.z.statistical"), sqrt(squares), 1e-12);
  for (size_t row = 0; row <= last; ++row) {
    assert_near(cell(&a, row, "gap.C.rx.worst"), 8.0 * fits.direction, 1e-12);
    assert_near(cell(&a, row, "gap.C.ry.statistical"), sqrt(8.0) * fits.direction, 1e-12);
    assert_near(cell(&a, row, "play.worst"), 2.0, 1e-5); /* each joint takes up its own two errors */
  }
  assert_near(a.joints[0].play_share + a.joints[1].play_share + a.joints[2].play_share + a.joints[3].play_share, 1.0,
              1e-9);
  assert_int_equal(a.remedies.remaining, 0);
  assert_int_equal(a.set_count, 1);
  assert_true(isfinite(a.set_worst) && a.set_worst >= a.worst.value);
  km_allowance_sweep_free(&a);
  fixture_close(&f);
}

/* Other units, and other clearances: lengths and angles scale, ratios don't; twice the play halves the ratio. */
static void test_units_and_scale(void **state) {
  (void)state;
  static const char *const names[] = {"bennett", "sarrus3", "klann"};
  for (int i = 0; i < 3; ++i) {
    const char *driver = i == 1 ? "B" : "A";
    const km_fit_defaults fits = {1e-4, 2e-3, 3e-4, 1e-3, false}, in_mm = {0.1, 2e-3, 0.3, 1e-3, false},
                          twice = {1e-4, 2e-3, 6e-4, 2e-3, false};
    fixture f = fixture_open(names[i]), mm = fixture_in_units(&f, "degrees", "millimeters", "kilograms", "seconds"),
            g = fixture_open(names[i]);
    km_allowance_sweep a = sweep_of(&f, &fits, driver), b = sweep_of(&mm, &in_mm, driver),
                       c = sweep_of(&g, &twice, driver);
    assert_near(a.worst.value / b.worst.value, 1.0, 1e-2); /* starts of the search differ */
    assert_near(a.worst.value / c.worst.value, 2.0, 2e-2);
    assert_int_equal(a.constraint_count, b.constraint_count);
    for (int k = 0; k < a.constraint_count; ++k) {
      double unit = a.constraints[k].component < 3 ? 1000.0 : 1.0;
      assert_int_equal(a.constraints[k].component, b.constraints[k].component);
      assert_near(unit * a.constraints[k].worst.value / b.constraints[k].worst.value, 1.0, 1e-9);
      assert_near(unit * a.constraints[k].statistical.value / b.constraints[k].statistical.value, 1.0, 1e-9);
    }
    km_allowance_sweep_free(&a);
    km_allowance_sweep_free(&b);
    km_allowance_sweep_free(&c);
    fixture_close(&f);
    fixture_close(&mm);
    fixture_close(&g);
  }
}

/* Clearances that joints state count in place of the defaults; without redundant constraints nothing is needed. */
static void test_stated_fits(void **state) {
  (void)state;
  const km_fit_defaults none = {1e-4, 2e-3, 0.0, 0.0, false}, fits = {1e-4, 2e-3, 3e-4, 1e-3, false};
  fixture f = fixture_open("bennett"), g = fixture_open("bennett"), h = fixture_open("rssr");
  for (int j = 0; j < 4; ++j)
    f.model->joints[j].fit = (km_joint_fit){.has_clearance = true, .radial = 3e-4, .axial = 3e-4, .angular = 1e-3};
  km_allowance_sweep a = sweep_of(&f, &none, "A"), b = sweep_of(&g, &fits, "A");
  assert_true(a.states_clearance && !b.states_clearance);
  assert_near(a.worst.value, b.worst.value, 0.0);
  km_allowance_sweep c = sweep_of(&h, &fits, km_model_coordinate_label(h.model, 0));
  assert_int_equal(c.constraint_count, 0);
  assert_near(cell(&c, 0, "play.worst"), 0.0, 0.0);
  const km_fit_defaults wrong = {1e-4, -1.0, 0.0, 0.0, false};
  km_sweep_plan plan = {.coordinate = 0, .from = 0.0, .to = 1.0, .steps = 2};
  km_allowance_sweep d;
  km_error error;
  assert_int_equal(km_allowance_sweep_run(g.mechanism, g.state, &plan, &wrong, &d, &error), KM_USAGE);
  km_allowance_sweep_free(&d);
  km_allowance_sweep_free(&a);
  km_allowance_sweep_free(&b);
  km_allowance_sweep_free(&c);
  fixture_close(&f);
  fixture_close(&g);
  fixture_close(&h);
}

/* A belt between two hinges of a parallelogram: no play of hinges takes up what it makes redundant in the plane, unless
 * they have radial play. Exact axes need no angular play. */
static void test_couplings_and_zero_errors(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"p\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}, {\"name\": "
      "\"c\"}], \"joints\": [{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", "
      "\"type\": \"revolute\", \"bodies\": [\"a\", \"b\"], \"at\": [0.5, 1]}, {\"name\": \"C\", \"type\": \"revolute\", \"bodies\": "
      "[\"b\", \"c\"], \"at\": [2.5, 1]}, {\"name\": \"D\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"c\"], \"at\": [2, 0]}], "
      "\"couplings\": [{\"name\": \"belt\", \"joints\": [\"A\", \"D\"], \"ratios\": [1, -1]}]}]}");
  const km_fit_defaults angular = {1e-4, 0.0, 0.0, 0.3, true}, radial = {1e-4, 0.0, 1e-3, 0.3, true},
                        exact = {0.0, 0.0, 1e-3, 0.0, true}, places = {1e-4, 0.0, 1e-4, 0.0, true};
  km_allowance_sweep a = sweep_of(&f, &angular, "A");
  assert_int_equal(a.constraint_count, 4);
  assert_true(a.worst.value == HUGE_VAL);
  km_allowance_sweep_free(&a);
  a = sweep_of(&f, &radial, "A");
  assert_true(isfinite(a.worst.value) && a.worst.value > 0.0);
  km_allowance_sweep_free(&a);
  a = sweep_of(&f, &exact, "A");
  assert_near(a.worst.value, 0.0, 0.0);
  km_allowance_sweep_free(&a);
  fixture_close(&f);
  f = fixture_open("fourbar");
  a = sweep_of(&f, &places, "A");
  assert_near(a.worst.value, 2.0, 1e-5); /* both errors of each joint add up along the normal */
  km_allowance_sweep_free(&a);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_couplings_and_zero_errors), cmocka_unit_test(test_ratio_by_search),
      cmocka_unit_test(test_assembled_with_play),       cmocka_unit_test(test_samples_stay_below),
      cmocka_unit_test(test_forces_by_least_energy),    cmocka_unit_test(test_four_bar_in_closed_form),
      cmocka_unit_test(test_units_and_scale),           cmocka_unit_test(test_stated_fits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
