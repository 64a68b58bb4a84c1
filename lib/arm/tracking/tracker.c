/* Advances an arm along its path from sample to sample: predictor, Newton's corrector to the closest configuration,
 * step halving, checks of limits and rates, location of the end of a track (docs/theory.md 12.4). */
#include "arm/tracking/tracker.h"
#include "arm/tracking/joint_effort.h"
#include "arm/tracking/seven_joint_arm.h"

#include <string.h>

bool km_tracker_space_create(const km_arm *a, km_tracker_space *s) {
  *s = (km_tracker_space){0};
  if (km_arm_space_create(a, &s->arm) && km_path_node_create(a, &s->arm.arena, &s->here))
    return true;
  km_tracker_space_free(s);
  return false;
}

void km_tracker_space_free(km_tracker_space *s) {
  km_arm_space_free(&s->arm);
}

/* Computes the columns and the objective of a node, for whose q the space was updated. */
static void compute_columns(const km_tracker *w, km_tracker_space *s, const km_path_point *point,
                            const km_step_choice *choice, const double *guide, km_path_node *node) {
  double xi[KM_ARM_ROWS], values[KM_OBJECTIVES];
  km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
  km_control_factor(w->arm, &s->arm, xi, choice->fixed);
  node->z = km_control_columns(w->arm, &s->arm, guide, node->path, node->self);
  if (!w->objective)
    return;
  km_objective_values(w->arm, &s->arm, node->q, node->path, point->speed, w->objective, values);
  node->value = km_objective_sum(w->objective, values);
}

/* Orients the first pose-control columns, which have no predecessor: the largest entry is positive. A tie of equal
 * magnitudes is decided by position. */
static void orient_columns(const km_arm *a, double *self) {
  for (int k = 0; k < a->freedom; ++k) {
    double *c = self + k * a->n, largest = 0.0;
    for (int i = 0; i < a->n; ++i)
      if (fabs(c[i]) > 1.000001 * fabs(largest))
        largest = c[i];
    for (int i = 0; i < a->n && largest < 0.0; ++i)
      c[i] = -c[i];
  }
}

/* Computes the node of a configuration without the objectives from inverse dynamics. */
static void compute_node(const km_tracker *w, km_tracker_space *s, int sample, const double *q,
                         const km_step_choice *choice, km_path_node *out) {
  memmove(out->q, q, (size_t)w->arm->n * sizeof *q);
  km_arm_update(w->arm, &s->arm, q);
  compute_columns(w, s, &w->path->points[sample], choice, NULL, out);
  orient_columns(w->arm, out->self);
  out->correction_count = 0;
}

void km_tracker_compute_node(const km_tracker *w, km_tracker_space *s, int sample, const double *q,
                             const km_step_choice *choice, km_path_node *out) {
  compute_node(w, s, sample, q, choice, out);
  km_path_node_add_effort_at_rest(w, sample, out);
}

void km_tracker_compute_arrival(const km_tracker *w, km_tracker_space *s, int sample, const double *q,
                                const km_path_node *from, km_path_node *out) {
  static const km_step_choice greedy_choice = {0};
  compute_node(w, s, sample, q, &greedy_choice, out);
  if (from)
    km_path_node_add_effort(w, sample - 1, &w->path->points[sample], from, out);
  else
    km_path_node_add_effort_at_rest(w, sample, out);
}

/* Damped least squares: out = Jᵀ (J Jᵀ + λ²)⁻¹ ξ, by Cholesky factorisation of J Jᵀ + λ². J is that of the last
 * update. */
static void damped_rates(const km_arm *a, const km_arm_space *s, const double *xi, double lambda, double *out) {
  const int rows = a->rows, n = a->n;
  double A[KM_ARM_ROWS][KM_ARM_ROWS], y[KM_ARM_ROWS];
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = i == j ? lambda * lambda : 0.0;
      for (int k = 0; k < n; ++k)
        sum += s->jacobian[k * rows + i] * s->jacobian[k * rows + j];
      for (int k = 0; k < j; ++k)
        sum -= A[i][k] * A[j][k];
      A[i][j] = i == j ? sqrt(sum) : sum / A[j][j];
    }
  for (int i = 0; i < rows; ++i) {
    y[i] = xi[i];
    for (int k = 0; k < i; ++k)
      y[i] -= A[i][k] * y[k];
    y[i] /= A[i][i];
  }
  for (int i = rows - 1; i >= 0; --i) {
    for (int k = i + 1; k < rows; ++k)
      y[i] -= A[k][i] * y[k];
    y[i] /= A[i][i];
  }
  for (int k = 0; k < n; ++k) {
    out[k] = 0.0;
    for (int r = 0; r < rows; ++r)
      out[k] += s->jacobian[k * rows + r] * y[r];
  }
}

/* Damped rates if the smallest singular value is below choice->below, with λ² = λ₀² (1 − (σ_min/below)²); false
 * otherwise. */
static bool find_damped_rates(const km_tracker *w, km_tracker_space *s, const km_path_point *point,
                              const km_step_choice *choice, const km_path_node *here, double *rates) {
  double sigma[KM_ARM_ROWS], xi[KM_ARM_ROWS];
  km_arm_update(w->arm, &s->arm, here->q);
  km_arm_singular_values(w->arm, &s->arm, sigma);
  double part = sigma[w->arm->rows - 1] / choice->below;
  if (part >= 1.0)
    return false;
  km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
  damped_rates(w->arm, &s->arm, xi, choice->damping * sqrt(1.0 - part * part), rates);
  return true;
}

/* Newton's corrector: finds the configuration q with the target pose that is closest to the predictor. moved[n] = q
 * − predictor, as given and as returned; the iteration fails if it exceeds `most` or doesn't converge. The space is
 * then updated for q. */
static bool correct(const km_tracker *w, km_tracker_space *s, const km_path_point *point, const km_step_choice *choice,
                    double most, double *q, double *moved) {
  double e[KM_ARM_ROWS], x[KM_ARM_MAX_JOINTS], xi[KM_ARM_ROWS];
  const int n = w->arm->n;
  const bool extrapolated = km_joint_length(moved, n) > 0.0;
  for (int step = 0; step <= KM_NEWTON_MAX_STEPS; ++step) {
    km_arm_update(w->arm, &s->arm, q);
    double pose_error = km_arm_error(w->arm, &s->arm, &point->pose, e, NULL, NULL);
    if (pose_error <= KM_NEWTON_CONVERGED &&
        !(extrapolated && step == 0)) /* an extrapolated correction needs one step at least,
                                                            * which removes its part in the null space */
      return true;
    if (!(pose_error < KM_NEWTON_DIVERGED))
      return false;
    km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
    km_control_factor(w->arm, &s->arm, xi, choice->fixed);
    km_control_solve(w->arm, &s->arm, e, moved, choice->fixed, x);
    for (int k = 0; k < n; ++k) {
      moved[k] += x[k];
      q[k] += x[k];
    }
    if (!(km_joint_length(moved, n) <= most))
      return false;
  }
  return false;
}

/* One step from space->here to a point: predictor (damped near singular configurations), then corrector. False:
 * rejected. */
static bool try_step(const km_tracker *w, km_tracker_space *s, const km_path_point *from, const km_path_point *point,
                     const km_step_choice *choice, km_path_node *to) {
  const km_arm *a = w->arm;
  const km_path_node *here = &s->here;
  double ds = point->s - from->s, step[KM_ARM_MAX_JOINTS], moved[KM_ARM_MAX_JOINTS] = {0}, most = 1.0;
  if (choice->damping > 0.0 && find_damped_rates(w, s, from, choice, here, step)) {
    for (int k = 0; k < a->n; ++k)
      step[k] *= ds; /* the corrector makes up for the damping, so it may be as long as a step */
  } else {
    most = km_path_node_predict(a, here, choice, ds, step, moved);
  }
  for (int k = 0; k < a->n; ++k)
    to->q[k] = here->q[k] + step[k] + moved[k];
  if (!correct(w, s, point, choice, most, to->q, moved))
    return false;
  km_path_node_store_correction(a, here, choice, ds, moved, to);
  return true;
}

/* First joint that exceeds its rate; -1: none. */
static int joint_over_rate(const km_arm *a, const double *rates) {
  for (int k = 0; k < a->n; ++k)
    if (fabs(rates[k]) > a->rate[k] * (1.0 + 1e-9))
      return k;
  return -1;
}

static const km_step_end complete = {.stop = KM_TRACK_COMPLETE, .column = -1, .fraction = 1.0};

/* Checks a step: limits at its end, rates of its mean and of its end; at the first sample also those of its start. */
static km_step_end check_limits_and_rates(const km_tracker *w, int sample, const km_path_point *point,
                                          const km_path_node *from, const km_path_node *to) {
  const km_arm *a = w->arm;
  km_step_end end = complete;
  end.column = km_arm_limit_passed(a, to->q);
  if (end.column >= 0) {
    end.stop = KM_TRACK_LIMIT;
    return end;
  }
  double per_second = 1.0 / (point->t - w->path->points[sample].t), mean[KM_ARM_MAX_JOINTS] = {0},
         rates[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < a->n; ++k)
    mean[k] = (to->q[k] - from->q[k]) * per_second;
  end.column = joint_over_rate(a, mean);
  if (end.column < 0) {
    km_path_node_rates(a, to->path, to->self, point->speed, mean, rates);
    end.column = joint_over_rate(a, rates);
  }
  if (end.column < 0 && sample == 0) { /* other samples were checked as ends of steps */
    km_path_node_rates(a, from->path, from->self, w->path->points[0].speed, mean, rates);
    end.column = joint_over_rate(a, rates);
  }
  end.stop = end.column >= 0 ? KM_TRACK_RATE : KM_TRACK_COMPLETE;
  return end;
}

/* Advances over an interval in partial steps, which are halved after a rejection and doubled after success. */
km_step_end km_tracker_step(const km_tracker *w, km_tracker_space *s, int sample, double fraction,
                            const km_path_node *from, const km_step_choice *choice, km_path_node *to) {
  enum { MAX_PARTIAL_STEPS = 5000 };
  static const double least = 1e-10; /* least step, relative to the interval: shorter ones are rounding */
  km_path_point here = w->path->points[sample];
  double done = 0.0, h = fraction;
  km_path_node_copy(w->arm, &s->here, from);
  for (int jacobians = 0; done < fraction; ++jacobians) {
    if (jacobians == (choice->tries ? choice->tries : MAX_PARTIAL_STEPS) || h < least * fraction ||
        s->here.z < KM_PATH_ENTRY_LEAST)
      return (km_step_end){.stop = KM_TRACK_SINGULAR, .column = -1, .fraction = done};
    double next = fraction - done <= h * (1.0 + 1e-9) ? fraction : done + h;
    km_path_point point = next < 1.0 ? km_path_at(w->path, sample, next) : w->path->points[sample + 1];
    if (!try_step(w, s, &here, &point, choice, to)) {
      h *= 0.5;
      continue;
    }
    compute_columns(w, s, &point, choice, s->here.self, to);
    km_path_node_copy(w->arm, &s->here, to);
    here = point;
    done = next;
    h *= 2.0;
  }
  km_path_node_add_effort(w, sample, &here, from, to);
  return check_limits_and_rates(w, sample, &here, from, to);
}

/* Copies the result of lane l into a node. Jacobians of lanes that failed aren't counted: they are repeated as
 * single steps, so counts don't depend on batching. */
static void read_lane(const km_tracker *w, km_tracker_space *s, int sample, const km_lanes *lanes, int l,
                      const km_path_node *from, const km_step_choice *choice, km_path_node *to) {
  const km_path_point *here = &w->path->points[sample], *point = here + 1;
  double side = 0.0, values[KM_OBJECTIVES], moved[SEVEN];
  for (int i = 0; i < SEVEN; ++i) {
    moved[i] = lanes->moved[i][l];
    to->q[i] = lanes->q[i][l];
    to->path[i] = lanes->path[i][l];
    side += from->self[i] * lanes->null[i][l];
  }
  for (int i = 0; i < SEVEN; ++i)
    to->self[i] = (side < 0.0 ? -1.0 : 1.0) * lanes->null[i][l];
  for (int r = 0; r < 6 && lanes->want_sigma; ++r)
    s->arm.sigma[r] = lanes->sigma[r][l];
  s->arm.sigma_valid = lanes->want_sigma;
  s->arm.evaluations += (unsigned long)lanes->jacobians[l];
  to->z = to->path[SEVEN] = lanes->path[SEVEN][l];
  km_path_node_store_correction(w->arm, from, choice, point->s - here->s, moved, to);
  if (!w->objective)
    return;
  km_objective_values(w->arm, &s->arm, to->q, to->path, point->speed, w->objective, values);
  to->value = km_objective_sum(w->objective, values);
  km_path_node_add_effort(w, sample, point, from, to);
}

/* Copies the data that km_path_node_predict reads of a node into lane l. */
static void write_lane(const km_tracker *w, int sample, int l, const km_path_node *from, const km_step_choice *choice,
                       km_batch_start *start) {
  const km_path_point *here = &w->path->points[sample], *point = here + 1;
  const double ds = point->s - here->s, *last = from->corrections, *before = from->corrections + SEVEN;
  const int known = km_path_node_valid_corrections(w->arm, from, choice, ds);
  for (int i = 0; i < SEVEN; ++i) {
    start->q[i][l] = from->q[i];
    start->path[i][l] = from->path[i];
    start->null[i][l] = from->self[i];
    start->last[i][l] = known > 0 ? last[i] : 0.0;
    start->before[i][l] = known > 1 ? before[i] : start->last[i][l];
  }
  start->z[l] = from->z;
  start->tan_phi[l] = choice->tan_phi[0];
  start->ds[l] = ds;
  start->per_second[l] = 1.0 / (point->t - here->t);
  start->speed[l] = point->speed;
}

/* Fills the lanes with the steps whose path entry is large enough. Returns their bits; the other lanes get a copy of
 * one of them, so that they compute with finite numbers. */
static unsigned fill_lanes(const km_tracker *w, const int *samples, int count, const km_path_node *const *from,
                           const km_step_choice *choices, km_lanes *lanes) {
  unsigned used = 0;
  int aimed = -1; /* start sample of the interval whose end is the current target */
  for (int l = 0; l < count; ++l) {
    double xi[6];
    if (!(from[l]->z >= KM_PATH_ENTRY_LEAST))
      continue;
    write_lane(w, samples[l], l, from[l], &choices[l], &lanes->start);
    if (samples[l] != aimed) {
      const km_path_point *point = &w->path->points[samples[l] + 1];
      km_arm_task_rows(w->arm, &point->pose.R, point->twist, xi);
      km_lanes_set_target(lanes, used ? l : 0, &point->pose, xi);
      aimed = samples[l];
    }
    used |= 1u << l;
  }
  km_batch_number *numbers = (km_batch_number *)&lanes->start;
  for (unsigned rest = used ? (1u << KM_LANES) - 1 - used : 0; rest; rest &= rest - 1)
    for (size_t i = 0; i < sizeof lanes->start / sizeof *numbers; ++i)
      numbers[i][__builtin_ctz(rest)] = numbers[i][__builtin_ctz(used)];
  return used;
}

/* Advances several nodes as a batch; steps that fail in the batch are repeated one by one. */
void km_tracker_steps(const km_tracker *w, km_tracker_space *s, const int *samples, int count,
                      const km_path_node *const *from, const km_step_choice *choices, km_path_node *const *to,
                      km_step_end *ends) {
  km_lanes lanes; /* large, so unused parts stay uninitialised */
  unsigned done = 0;
  if (count > 1 && s->arm.seven) {
    done = fill_lanes(w, samples, count, from, choices, &lanes);
    lanes.used = done;
    lanes.want_sigma = w->objective && (w->objective->weight[KM_SINGULAR_VALUE] != 0.0 ||
                                        w->objective->weight[KM_MANIPULABILITY] != 0.0);
    if (done)
      done &= km_lanes_step(w->arm, &lanes);
  }
  for (int l = 0; l < count; ++l) {
    unsigned long before = s->arm.evaluations;
    if (done & 1u << l) {
      read_lane(w, s, samples[l], &lanes, l, from[l], &choices[l], to[l]);
      bool within = lanes.within & 1u << l && samples[l] > 0;
      ends[l] =
          within ? complete : check_limits_and_rates(w, samples[l], &w->path->points[samples[l] + 1], from[l], to[l]);
    } else {
      ends[l] = km_tracker_step(w, s, samples[l], 1.0, from[l], &choices[l], to[l]);
    }
    ends[l].evaluations = s->arm.evaluations - before;
  }
}

/* First coordinate beyond its limit, without a tolerance; -1: none. */
static int joint_over_limit(const km_arm *a, const double *q) {
  for (int k = 0; k < a->n; ++k)
    if (q[k] > a->high[k] || q[k] < a->low[k])
      return k;
  return -1;
}

/* Bisection between a step that satisfies limits and rates and one that doesn't. No smoothness is assumed: another
 * limit can come first, and long steps are curved. */
km_step_end km_tracker_find_end(const km_tracker *w, km_tracker_space *s, int sample, const km_path_node *from,
                                const km_step_choice *choice, km_step_end end, double outside, km_path_node *to) {
  double inside = 0.0;
  while (outside - inside > 1e-13) {
    double x = 0.5 * (inside + outside);
    km_step_end there = km_tracker_step(w, s, sample, x, from, choice, to);
    int beyond = there.stop ? -1 : joint_over_limit(w->arm, to->q);
    if (beyond >= 0)
      there = (km_step_end){.stop = KM_TRACK_LIMIT, .column = beyond};
    if (there.stop) {
      outside = x;
      end = there;
    } else {
      inside = x;
    }
  }
  end.fraction = inside;
  if (inside > 0.0)
    km_tracker_step(w, s, sample, inside, from, choice, to);
  else
    km_path_node_copy(w->arm, to, from);
  return end;
}
