/* Forward kinematics, Jacobian, pose error and singular values of an arm (docs/theory.md 12.1).
 *
 *   column k of J = (a_k × (p − p_k) + pitch a_k, a_k) of a turning joint, (a_k, 0) of a slide; a_k axis, p_k its point
 *   e = (p_target − p, log(R_target R^T));   an axis task uses the rotation that moves z to its target */
#include "arm/arm.h"
#include "arm/tracking/seven_joint_arm.h"

#include <string.h>

bool km_arm_space_create(const km_arm *a, km_arm_space *s) {
  *s = (km_arm_space){0};
  size_t n = (size_t)a->n, rows = (size_t)a->rows;
  s->jacobian = KM_ARENA_NEW(&s->arena, double, rows *(n + 1));
  s->axis = KM_ARENA_NEW(&s->arena, km_vec3, n);
  s->point = KM_ARENA_NEW(&s->arena, km_vec3, n);
  s->forced = KM_ARENA_NEW(&s->arena, bool, n + 1);
  s->null = KM_ARENA_NEW(&s->arena, double, n *(n + 1));
  s->rotated = KM_ARENA_NEW(&s->arena, double, rows *n);
  if (km_seven_fits(a))
    s->seven = KM_ARENA_NEW(&s->arena, km_one_seven, 1);
  s->factor = km_factor_create(a->rows, a->n + 1, NULL, &s->arena);
  if (!s->factor || !km_arm_clearance_create(a, s)) {
    km_arm_space_free(s);
    return false;
  }
  s->forced[n] = true;
  return true;
}

void km_arm_space_free(km_arm_space *s) {
  km_state_free(s->state);
  s->state = NULL;
  km_arena_free(&s->arena);
}

/* Forward pass over the chain: axis and point of each motion, pose of the effector. */
static void compute_poses(const km_arm *a, km_arm_space *s, const double *q) {
  km_pose X = a->motions[0].before;
  for (int k = 0; k < a->n; ++k) {
    const km_arm_motion *m = &a->motions[k];
    if (k > 0) {
      X.p = km_pose_point(&X, m->before.p);
      if (m->has_rotation)
        X.R = km_rotation_product(&X.R, &m->before.R);
    }
    double value = m->sign * q[k];
    s->axis[k] = km_vec3_scale(m->sign, X.R.axis[m->axis]);
    s->point[k] = X.p;
    if (m->primitive == KM_PRISMATIC) {
      X.p = km_vec3_axpy(value, X.R.axis[m->axis], X.p);
      continue;
    }
    if (m->primitive == KM_HELICAL)
      X.p = km_vec3_axpy(m->pitch * value, X.R.axis[m->axis], X.p);
    double sine, cosine;
    sincos(value, &sine, &cosine);
    X.R = km_rotation_about_axis(&X.R, m->axis, cosine, sine);
  }
  s->pose = km_pose_product(&X, &a->tool);
}

/* Twist of the effector's origin per unit of motion k; requires compute_poses. */
static km_twist column_twist(const km_arm *a, const km_arm_space *s, int k) {
  const km_arm_motion *m = &a->motions[k];
  km_twist t = {s->axis[k], {0, 0, 0}};
  if (m->primitive != KM_PRISMATIC)
    t = (km_twist){km_vec3_cross(s->axis[k], km_vec3_sub(s->pose.p, s->point[k])), s->axis[k]};
  if (m->primitive == KM_HELICAL)
    t.v = km_vec3_axpy(m->pitch, s->axis[k], t.v);
  return t;
}

/* Update by the kernel of seven joints; false if an angle exceeds the range of its sines. */
static bool update_seven(const km_arm *a, km_arm_space *s, const double *q) {
  for (int k = 0; k < SEVEN; ++k)
    if (!(fabs(q[k]) <= KM_SINCOS_MAX_ANGLE))
      return false;
  km_one_forward(a, q, s->seven);
  memcpy(&s->pose.R, s->seven->R, sizeof s->pose.R);
  memcpy(&s->pose.p, &s->seven->p, sizeof s->pose.p);
  for (int k = 0; k < SEVEN; ++k) /* column copies are faster than one block copy */
    memcpy(s->jacobian + 6 * k, s->seven->jacobian[k], sizeof s->seven->jacobian[k]);
  return true;
}

/* Forward kinematics and Jacobian at q[n]. */
void km_arm_update(const km_arm *a, km_arm_space *s, const double *q) {
  s->evaluations++;
  s->seven_factored = s->sigma_valid = false;
  s->seven_valid = s->seven && update_seven(a, s, q);
  if (s->seven_valid)
    return;
  compute_poses(a, s, q);
  for (int k = 0; k < a->n; ++k)
    km_arm_task_rows(a, &s->pose.R, column_twist(a, s, k), s->jacobian + k * a->rows);
}

void km_arm_all_columns(const km_arm *a, km_arm_space *s, const double *q, double *columns) {
  compute_poses(a, s, q);
  for (int k = 0; k < a->n; ++k)
    km_arm_all_task_rows(a, &s->pose.R, column_twist(a, s, k), columns + k * a->task_rows);
}

/* Rotation vector from the present to the target orientation, in inertial axes; axis task: the rotation that moves
 * the z axis to its target. */
static km_vec3 rotation_error(const km_arm *a, const km_rotation *R, const km_rotation *target) {
  if (a->task == KM_TASK_AXIS) {
    km_vec3 across = km_vec3_cross(R->axis[2], target->axis[2]);
    double sine = km_vec3_norm(across), cosine = km_vec3_dot(R->axis[2], target->axis[2]);
    if (sine > 1e-12)
      return km_vec3_scale(atan2(sine, cosine) / sine, across);
    return cosine > 0.0 ? across : km_vec3_scale(M_PI, R->axis[0]);
  }
  km_one_vec3 axes[3], wanted[3];
  double sine2, trace;
  memcpy(axes, R, sizeof axes);
  memcpy(wanted, target, sizeof wanted);
  km_one_vec3 small = km_one_rotation_error(axes, wanted, &sine2, &trace);
  if (sine2 < KM_SMALL_ROTATION && trace > 1.0)
    return (km_vec3){small.x, small.y, small.z};
  km_rotation back = km_rotation_inverse(R), difference = km_rotation_product(target, &back);
  return km_quaternion_log(km_rotation_quaternion(&difference));
}

/* Pose error: position difference and rotation vector to the target, as rows of the task. */
double km_arm_error(const km_arm *a, const km_arm_space *s, const km_pose *target, double *error, double *position,
                    double *rotation) {
  km_twist e = {km_vec3_sub(target->p, s->pose.p), {0, 0, 0}};
  if (a->task != KM_TASK_POSITION)
    e.w = rotation_error(a, &s->pose.R, &target->R);
  if (error)
    km_arm_task_rows(a, &s->pose.R, e, error);
  if (position)
    *position = km_vec3_norm(e.v);
  if (rotation)
    *rotation = km_vec3_norm(e.w);
  return sqrt(a->position_weight * km_vec3_dot(e.v, e.v) + km_vec3_dot(e.w, e.w));
}

/* Singular values by one-sided Jacobi rotations of the rows of J, for any number of rows and columns. */
static void jacobi_singular_values(const km_arm *a, km_arm_space *s, double *sigma) {
  enum { MAX_SWEEPS = 30 };
  const int n = a->n, rows = a->rows;
  double *G = s->rotated;
  for (int r = 0; r < rows; ++r)
    for (int k = 0; k < n; ++k)
      G[r * n + k] = s->jacobian[k * rows + r];
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < MAX_SWEEPS; ++sweep) {
    rotated = false;
    for (int i = 0; i < rows - 1; ++i) {
      for (int j = i + 1; j < rows; ++j) {
        double *x = G + i * n, *y = G + j * n, xx = 0.0, yy = 0.0, xy = 0.0;
        for (int k = 0; k < n; ++k) {
          xx += x[k] * x[k];
          yy += y[k] * y[k];
          xy += x[k] * y[k];
        }
        if (!(fabs(xy) > 1e-15 * sqrt(xx * yy)))
          continue;
        rotated = true;
        double zeta = (yy - xx) / (2.0 * xy);
        double t = (zeta < 0.0 ? -1.0 : 1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
        double c = 1.0 / sqrt(1.0 + t * t), d = c * t;
        for (int k = 0; k < n; ++k) {
          double old = x[k];
          x[k] = c * old - d * y[k];
          y[k] = d * old + c * y[k];
        }
      }
    }
  }
  for (int r = 0; r < rows; ++r) {
    double sum = 0.0;
    for (int k = 0; k < n; ++k)
      sum += G[r * n + k] * G[r * n + k];
    sigma[r] = sqrt(sum);
  }
}

/* Singular values of the Jacobian, computed once per configuration and sorted. */
void km_arm_singular_values(const km_arm *a, km_arm_space *s, double *sigma) {
  if (!s->sigma_valid && s->seven_valid)
    km_one_singular_values(s->seven, s->sigma);
  else if (!s->sigma_valid)
    jacobi_singular_values(a, s, s->sigma);
  s->sigma_valid = true;
  for (int r = 0; r < a->rows; ++r) { /* insertion sort, largest first */
    sigma[r] = s->sigma[r];
    for (int i = r; i > 0 && sigma[i] > sigma[i - 1]; --i) {
      double swap = sigma[i];
      sigma[i] = sigma[i - 1];
      sigma[i - 1] = swap;
    }
  }
}
