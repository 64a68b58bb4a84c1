/* One step of an arm along its path. */
#include "arm/tracking/tracker.h"
#include "arm/tracking/seven_joint_arm.h"

#include <string.h>

bool km_tracker_space_create(const km_arm *a, km_tracker_space *s) {
  *s = (km_tracker_space){0};
  if (km_arm_space_create(a, &s->arm) && km_node_create(a, &s->arm.arena, &s->here))
    return true;
  km_tracker_space_free(s);
  return false;
}

void km_tracker_space_free(km_tracker_space *s) {
  km_arm_space_free(&s->arm);
}

/* Columns and value of a node at whose q the space's Jacobian stands. */
static void look_around(const km_tracker *w, km_tracker_space *s, const km_path_point *point, const km_step_choice *way,
                        const double *guide, km_node *node) {
  double xi[KM_ARM_ROWS], values[KM_OBJECTIVES];
  km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
  km_control_factor(w->arm, &s->arm, xi, way->held);
  node->z = km_control_columns(w->arm, &s->arm, guide, node->path, node->self);
  if (!w->objective)
    return;
  km_objective_values(w->arm, &s->arm, node->q, node->path, point->speed, w->objective, values);
  node->value = km_objective_sum(w->objective, values);
}

/* The first pose-control columns have no node to follow: their largest entry is positive. */
static void set_senses(const km_arm *a, double *self) {
  for (int k = 0; k < a->freedom; ++k) {
    double *c = self + k * a->n, largest = 0.0;
    for (int i = 0; i < a->n; ++i)
      if (fabs(c[i]) > 1.000001 * fabs(largest))
        largest = c[i];
    for (int i = 0; i < a->n && largest < 0.0; ++i)
      c[i] = -c[i];
  }
}

void km_tracker_begin(const km_tracker *w, km_tracker_space *s, int sample, const double *q, const km_step_choice *way,
                      km_node *out) {
  memmove(out->q, q, (size_t)w->arm->n * sizeof *q);
  km_arm_update(w->arm, &s->arm, q);
  look_around(w, s, &w->path->points[sample], way, NULL, out);
  set_senses(w->arm, out->self);
  out->bends = 0;
}

/* δ = Jᵀ(JJᵀ + λ²)⁻¹ξ, by Cholesky's factors of the small matrix. The Jacobian is that of the last update. */
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

/* Damped rates where the pose is near a singular one; false where it isn't. */
static bool damp(const km_tracker *w, km_tracker_space *s, const km_path_point *point, const km_step_choice *way,
                 const km_node *here, double *rates) {
  double sigma[KM_ARM_ROWS], xi[KM_ARM_ROWS];
  km_arm_update(w->arm, &s->arm, here->q);
  km_arm_singular_values(w->arm, &s->arm, sigma);
  double part = sigma[w->arm->rows - 1] / way->below;
  if (part >= 1.0)
    return false;
  km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
  damped_rates(w->arm, &s->arm, xi, way->damping * sqrt(1.0 - part * part), rates);
  return true;
}

/* Newton steps to the point of the path's fibre that is nearest to the predictor, at most `most` away from it: q is
 * `moved` away from the predictor, as it is given and as it is returned. Leaves the Jacobian of the pose. */
static bool correct(const km_tracker *w, km_tracker_space *s, const km_path_point *point, const km_step_choice *way,
                    double most, double *q, double *moved) {
  double e[KM_ARM_ROWS], x[KM_ARM_MOST], xi[KM_ARM_ROWS];
  const int n = w->arm->n;
  const bool guessed = km_joint_length(moved, n) > 0.0;
  for (int step = 0; step <= KM_NEWTON_MOST; ++step) {
    km_arm_update(w->arm, &s->arm, q);
    double left = km_arm_error(w->arm, &s->arm, &point->pose, e, NULL, NULL);
    if (left <= KM_NEWTON_DONE && !(guessed && step == 0)) /* a step takes a guess's part in the null space out */
      return true;
    if (!(left < KM_NEWTON_FAR))
      return false;
    km_arm_task_rows(w->arm, &s->arm.pose.R, point->twist, xi);
    km_control_factor(w->arm, &s->arm, xi, way->held);
    km_control_solve(w->arm, &s->arm, e, moved, way->held, x);
    for (int k = 0; k < n; ++k) {
      moved[k] += x[k];
      q[k] += x[k];
    }
    if (!(km_joint_length(moved, n) <= most))
      return false;
  }
  return false;
}

/* One step from space->here by dσ to a point; false if it is refused. */
static bool try_step(const km_tracker *w, km_tracker_space *s, const km_path_point *from, const km_path_point *point,
                     const km_step_choice *way, km_node *to) {
  const km_arm *a = w->arm;
  const km_node *here = &s->here;
  double ds = point->s - from->s, step[KM_ARM_MOST], moved[KM_ARM_MOST] = {0}, most = 1.0;
  if (way->damping > 0.0 && damp(w, s, from, way, here, step)) {
    for (int k = 0; k < a->n; ++k)
      step[k] *= ds; /* what damping leaves undone is the corrector's: it may be as long as a step */
  } else {
    most = km_node_predict(a, here, way, ds, step, moved);
  }
  for (int k = 0; k < a->n; ++k)
    to->q[k] = here->q[k] + step[k] + moved[k];
  if (!correct(w, s, point, way, most, to->q, moved))
    return false;
  km_node_remember(a, here, way, ds, moved, to);
  return true;
}

/* A joint that is faster than it may; -1: none. */
static int too_fast(const km_arm *a, const double *rates) {
  for (int k = 0; k < a->n; ++k)
    if (fabs(rates[k]) > a->rate[k] * (1.0 + 1e-9))
      return k;
  return -1;
}

static const km_step_end complete = {.stop = KM_TRACK_COMPLETE, .column = -1, .fraction = 1.0};

static km_step_end check(const km_tracker *w, int sample, const km_path_point *point, const km_node *from,
                         const km_node *to) {
  const km_arm *a = w->arm;
  km_step_end end = complete;
  end.column = km_arm_limit_passed(a, to->q);
  if (end.column >= 0) {
    end.stop = KM_TRACK_LIMIT;
    return end;
  }
  double per_second = 1.0 / (point->t - w->path->points[sample].t), mean[KM_ARM_MOST] = {0}, rates[KM_ARM_MOST];
  for (int k = 0; k < a->n; ++k)
    mean[k] = (to->q[k] - from->q[k]) * per_second;
  end.column = too_fast(a, mean);
  if (end.column < 0) {
    km_node_rates(a, to->path, to->self, point->speed, mean, rates);
    end.column = too_fast(a, rates);
  }
  if (end.column < 0 && sample == 0) { /* every other sample has been an end */
    km_node_rates(a, from->path, from->self, w->path->points[0].speed, mean, rates);
    end.column = too_fast(a, rates);
  }
  end.stop = end.column >= 0 ? KM_TRACK_RATE : KM_TRACK_COMPLETE;
  return end;
}

km_step_end km_tracker_step(const km_tracker *w, km_tracker_space *s, int sample, double fraction, const km_node *from,
                            const km_step_choice *way, km_node *to) {
  enum { MOST_TRIES = 5000 };
  static const double least = 1e-10; /* of the interval: what is less can't be told from where it stands */
  km_path_point here = w->path->points[sample];
  double done = 0.0, h = fraction;
  km_node_copy(w->arm, &s->here, from);
  for (int tries = 0; done < fraction; ++tries) {
    if (tries == (way->tries ? way->tries : MOST_TRIES) || h < least * fraction || s->here.z < KM_PATH_ENTRY_LEAST)
      return (km_step_end){.stop = KM_TRACK_SINGULAR, .column = -1, .fraction = done};
    double next = fraction - done <= h * (1.0 + 1e-9) ? fraction : done + h;
    km_path_point point = next < 1.0 ? km_path_at(w->path, sample, next) : w->path->points[sample + 1];
    if (!try_step(w, s, &here, &point, way, to)) {
      h *= 0.5;
      continue;
    }
    look_around(w, s, &point, way, s->here.self, to);
    km_node_copy(w->arm, &s->here, to);
    here = point;
    done = next;
    h *= 2.0;
  }
  return check(w, sample, &here, from, to);
}

/* Puts a lane's pose and its columns into a node. What lanes take that don't arrive doesn't count: they go on alone, and whether
 * a node went side by side with others is not to be told from its numbers. */
static void take_lane(const km_tracker *w, km_tracker_space *s, int sample, const km_lanes *lanes, int l,
                      const km_node *from, const km_step_choice *way, km_node *to) {
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
  s->arm.sigma_stands = lanes->want_sigma;
  s->arm.evaluations += (unsigned long)lanes->tries[l];
  to->z = to->path[SEVEN] = lanes->path[SEVEN][l];
  km_node_remember(w->arm, from, way, point->s - here->s, moved, to);
  if (!w->objective)
    return;
  km_objective_values(w->arm, &s->arm, to->q, to->path, point->speed, w->objective, values);
  to->value = km_objective_sum(w->objective, values);
}

/* What km_node_predict reads of a node goes into lane l. */
static void fill_lane(const km_tracker *w, int sample, int l, const km_node *from, const km_step_choice *way,
                      km_batch_start *start) {
  const km_path_point *here = &w->path->points[sample], *point = here + 1;
  const double ds = point->s - here->s, *last = from->bend, *before = from->bend + SEVEN;
  const int known = km_node_known_bends(w->arm, from, way, ds);
  for (int i = 0; i < SEVEN; ++i) {
    start->q[i][l] = from->q[i];
    start->path[i][l] = from->path[i];
    start->null[i][l] = from->self[i];
    start->last[i][l] = known > 0 ? last[i] : 0.0;
    start->before[i][l] = known > 1 ? before[i] : start->last[i][l];
  }
  start->z[l] = from->z;
  start->tilt[l] = way->tilt[0];
  start->ds[l] = ds;
  start->per_second[l] = 1.0 / (point->t - here->t);
  start->speed[l] = point->speed;
}

/* Returns the lanes that take part; the others have the numbers of one that does. */
static unsigned fill_lanes(const km_tracker *w, const int *samples, int count, const km_node *const *from,
                           const km_step_choice *ways, km_lanes *lanes) {
  unsigned used = 0;
  int aimed = -1; /* the sample that lanes are aimed behind */
  for (int l = 0; l < count; ++l) {
    double xi[6];
    if (!(from[l]->z >= KM_PATH_ENTRY_LEAST))
      continue;
    fill_lane(w, samples[l], l, from[l], &ways[l], &lanes->start);
    if (samples[l] != aimed) {
      const km_path_point *point = &w->path->points[samples[l] + 1];
      km_arm_task_rows(w->arm, &point->pose.R, point->twist, xi);
      km_lanes_aim(lanes, used ? l : 0, &point->pose, xi);
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

void km_tracker_steps(const km_tracker *w, km_tracker_space *s, const int *samples, int count,
                      const km_node *const *from, const km_step_choice *ways, km_node *const *to, km_step_end *ends) {
  km_lanes lanes; /* large: what isn't used isn't set */
  unsigned done = 0;
  if (count > 1 && s->arm.seven) {
    done = fill_lanes(w, samples, count, from, ways, &lanes);
    lanes.used = done;
    lanes.want_sigma = w->objective && (w->objective->weight[KM_SINGULAR_VALUE] != 0.0 ||
                                        w->objective->weight[KM_MANIPULABILITY] != 0.0);
    if (done)
      done &= km_lanes_reach(w->arm, &lanes);
  }
  for (int l = 0; l < count; ++l) {
    unsigned long before = s->arm.evaluations;
    if (done & 1u << l) {
      take_lane(w, s, samples[l], &lanes, l, from[l], &ways[l], to[l]);
      bool keeps = lanes.keeps & 1u << l && samples[l] > 0;
      ends[l] = keeps ? complete : check(w, samples[l], &w->path->points[samples[l] + 1], from[l], to[l]);
    } else {
      ends[l] = km_tracker_step(w, s, samples[l], 1.0, from[l], &ways[l], to[l]);
    }
    ends[l].evaluations = s->arm.evaluations - before;
  }
}

/* A coordinate beyond its limit, be it by rounding; -1: none. */
static int just_beyond(const km_arm *a, const double *q) {
  for (int k = 0; k < a->n; ++k)
    if (q[k] > a->high[k] || q[k] < a->low[k])
      return k;
  return -1;
}

/* By halving what is left between a way that keeps everything and one that doesn't: other limits may come first, and a
 * long step may bend, so nothing is taken for smooth. */
km_step_end km_tracker_find_end(const km_tracker *w, km_tracker_space *s, int sample, const km_node *from,
                                const km_step_choice *way, km_step_end end, double outside, km_node *to) {
  double inside = 0.0;
  while (outside - inside > 1e-13) {
    double x = 0.5 * (inside + outside);
    km_step_end there = km_tracker_step(w, s, sample, x, from, way, to);
    int beyond = there.stop ? -1 : just_beyond(w->arm, to->q);
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
    km_tracker_step(w, s, sample, inside, from, way, to);
  else
    km_node_copy(w->arm, to, from);
  return end;
}
