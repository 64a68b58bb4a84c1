/* Arms: a chain of joints cut out of a mechanism, with its length scale, limits and rates (docs/theory.md 12.1). */
#include "arm/arm.h"
#include "arm/arm_dynamics.h"
#include "base/arguments.h"
#include "topology/chain.h"

#include <string.h>

static void set_length(km_arm *a) {
  a->length = a->mechanism->length;
}

/* Collects the tree arcs from the inertial frame to the effector's body; returns their number. */
static int gather_arcs(const km_mechanism *m, int body, const km_arc **arcs) {
  int count = 0;
  for (int b = body; b != 0; b = m->arcs[m->arc_of[b]].parent)
    arcs[count++] = &m->arcs[m->arc_of[b]];
  for (int i = 0; i < count / 2; ++i) {
    const km_arc *swap = arcs[i];
    arcs[i] = arcs[count - 1 - i];
    arcs[count - 1 - i] = swap;
  }
  return count;
}

/* Checks that a joint of the chain lies in no loop or coupling and has single axes. */
static km_status check_coordinate(const km_mechanism *m, int joint, int coordinate, km_error *error) {
  const km_model_joint *def = &m->model->joints[joint];
  if (m->substructure_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE,
                   "joint \"%s\" on the way to the effector lies in a loop or a coupling; expected an open chain",
                   def->label);
  if (m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" is a ball (%s); expected joints with axes of their own, as Rx, Ty",
                   def->label, km_joint_kind_of(def->type)->word);
  return KM_OK;
}

/* Extends the chain by one primitive motion of a joint: a column, or a constant displacement if the joint is held. X
 * is the displacement from the previous motion to this one's frame, in model units. */
static km_status add_motion(km_arm *a, const km_state *s, int joint, const km_joint_traversal *p, int i, km_pose *X,
                            km_error *error) {
  const km_mechanism *m = a->mechanism;
  int c = p->coordinate[i];
  double pitch = km_pitch_per_radian(m->model, joint, 1.0);
  if (m->held[c]) {
    double held[3];
    for (int k = 0; k < km_primitive_freedom(p->motion[i].primitive); ++k)
      held[k] = s->q[c + k];
    km_pose motion = km_motion_traversed(p->motion[i], pitch, held, p->sign);
    *X = km_pose_product(X, &motion);
    return KM_OK;
  }
  km_status status = check_coordinate(m, joint, c, error);
  if (status)
    return status;
  if (a->n == KM_ARM_MAX_JOINTS)
    return km_fail(error, KM_USAGE, "more than %d coordinates on the way to the effector", KM_ARM_MAX_JOINTS);
  if (a->n == 0) {
    a->origin = X->p;
    X->p = (km_vec3){0, 0, 0};
  }
  bool slides = p->motion[i].primitive == KM_PRISMATIC;
  km_rotation none = km_rotation_identity();
  X->p = km_vec3_scale(1.0 / a->length, X->p);
  a->motions[a->n] = (km_arm_motion){.primitive = p->motion[i].primitive,
                                     .axis = p->motion[i].axis,
                                     .column = a->n,
                                     .sign = p->sign,
                                     .pitch = pitch / a->length,
                                     .has_rotation = memcmp(&X->R, &none, sizeof none) != 0,
                                     .before = *X};
  a->coordinate[a->n] = c;
  a->unit[a->n] = slides ? a->length : 1.0;
  a->low[a->n] = m->low[c] / a->unit[a->n];
  a->high[a->n] = m->high[c] / a->unit[a->n];
  a->rate[a->n] = (double)INFINITY;
  a->n++;
  *X = km_pose_identity();
  return KM_OK;
}

/* Sets the numbers that depend on the arm's size over L. */
static void set_sizes(km_arm *a) {
  double reach = km_vec3_norm(a->tool.p), slides = 0.0;
  for (int k = 0; k < a->n; ++k) {
    reach += km_vec3_norm(a->motions[k].before.p);
    double most = fmax(fabs(a->low[k]), fabs(a->high[k]));
    if (a->motions[k].primitive == KM_PRISMATIC && most < (double)INFINITY)
      slides += most;
  }
  double size = fmax(1.0, reach / 100.0);
  a->position_weight = 1.0 / (size * size);
  a->max_travel = 3.0 * (1.0 + reach + slides);
}

/* Builds the chain from the inertial frame to the effector, its sizes and its task rows. */
static km_status build_chain(km_arm *a, const km_state *s, const km_arc **arcs, km_error *error) {
  const km_model *model = a->mechanism->model;
  const km_model_frame *effector = &model->frames[a->frame];
  int count = gather_arcs(a->mechanism, effector->body, arcs);
  km_pose X = km_pose_identity();
  for (int k = 0; k < count; ++k) {
    km_joint_traversal p;
    km_joint_traverse(model, arcs[k]->joint, arcs[k]->is_reversed, &p);
    X = km_pose_product(&X, &arcs[k]->before);
    for (int i = 0; i < p.count; ++i) {
      km_status status = add_motion(a, s, arcs[k]->joint, &p, i, &X, error);
      if (status)
        return status;
    }
    X = km_pose_product(&X, &arcs[k]->after);
  }
  X = km_pose_product(&X, &effector->pose);
  X.p = km_vec3_scale(1.0 / a->length, X.p);
  a->tool = X;
  set_sizes(a);
  if (!km_arm_find_rows(a) || !km_arm_set_masses(a, s, arcs, count))
    return km_fail(error, KM_MEMORY, "out of memory for an arm");
  a->freedom = a->n - a->rows;
  if (a->rows == 0)
    return km_fail(
        error, KM_USAGE,
        "no joint on the way to frame \"%s\" of body \"%s\" moves it as the task counts; expected one at least",
        effector->name, model->bodies[effector->body].name);
  if (a->freedom < 0)
    return km_fail(error, KM_USAGE,
                   "the way to frame \"%s\" of body \"%s\" has %d free coordinates; expected at least %d",
                   effector->name, model->bodies[effector->body].name, a->n, a->rows);
  return KM_OK;
}

km_status km_arm_create(const km_mechanism *m, const km_state *s, int effector, km_task task, km_arm **out,
                        km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = km_check_index(effector, m->model->frame_count, "frame", error);
  if (!fits)
    fits = task == KM_TASK_POSE || task == KM_TASK_POSITION || task == KM_TASK_AXIS
               ? KM_OK
               : km_fail(error, KM_USAGE, "%d names no task", (int)task);
  if (fits)
    return fits;
  km_arm *a = KM_NEW(km_arm, 1);
  if (!a)
    return km_fail(error, KM_MEMORY, "out of memory for an arm");
  a->mechanism = m;
  a->frame = effector;
  a->task = task;
  a->task_rows = km_task_rows(task);
  set_length(a);
  a->motions = KM_ARENA_NEW(&a->arena, km_arm_motion, KM_ARM_MAX_JOINTS);
  a->coordinate = KM_ARENA_NEW(&a->arena, int, KM_ARM_MAX_JOINTS);
  a->unit = KM_ARENA_NEW(&a->arena, double, KM_ARM_MAX_JOINTS);
  a->low = KM_ARENA_NEW(&a->arena, double, KM_ARM_MAX_JOINTS);
  a->high = KM_ARENA_NEW(&a->arena, double, KM_ARM_MAX_JOINTS);
  a->rate = KM_ARENA_NEW(&a->arena, double, KM_ARM_MAX_JOINTS);
  const km_arc **arcs = KM_NEW(const km_arc *, (size_t)m->topology.body_count);
  km_status status =
      a->arena.failed || !arcs ? km_fail(error, KM_MEMORY, "out of memory for an arm") : build_chain(a, s, arcs, error);
  km_free((void *)arcs);
  if (status) {
    km_arm_free(a);
    return status;
  }
  *out = a;
  return KM_OK;
}

void km_arm_free(km_arm *a) {
  if (!a)
    return;
  km_arena_free(&a->arena);
  km_free(a);
}

int km_arm_coordinates(const km_arm *a) {
  if (!a)
    return 0;
  return a->n;
}

int km_arm_coordinate(const km_arm *a, int column) {
  if (!a || column < 0 || column >= a->n)
    return -1;
  return a->coordinate[column];
}

int km_arm_rows(const km_arm *a) {
  return a ? a->task_rows : 0;
}

int km_arm_freedom(const km_arm *a) {
  return a ? a->freedom : 0;
}

double km_arm_length(const km_arm *a) {
  if (!a)
    return nan("");
  return a->length;
}

const char *km_arm_label(const km_arm *a, int column) {
  return km_model_coordinate_label(a->mechanism->model, a->coordinate[column]);
}

double km_arm_to_units(const km_arm *a, int column, double q) {
  return q * a->unit[column] / km_model_coordinate_factor(a->mechanism->model, a->coordinate[column]);
}

double km_arm_from_units(const km_arm *a, int column, double value) {
  return value * km_model_coordinate_factor(a->mechanism->model, a->coordinate[column]) / a->unit[column];
}

km_status km_arm_set_rates(km_arm *a, const double *values, int count, km_error *error) {
  km_status fits = km_check_given(a != NULL, "arm", error);
  if (fits)
    return fits;
  for (int k = 0; k < a->n; ++k)
    a->rate[k] = (double)INFINITY;
  if (!values)
    return KM_OK;
  if (count != a->n)
    return km_fail(error, KM_USAGE, "found %d values; expected %d, one a joint from %s to %s", count, a->n,
                   km_arm_label(a, 0), km_arm_label(a, a->n - 1));
  double second = a->mechanism->model->units.time->si;
  for (int k = 0; k < a->n; ++k) {
    if (!(values[k] > 0.0))
      return km_fail(error, KM_USAGE, "found %g for %s; expected a speed greater than 0", values[k],
                     km_arm_label(a, k));
    a->rate[k] = km_arm_from_units(a, k, values[k]) / second;
  }
  return KM_OK;
}

km_pose km_arm_from_model(const km_arm *a, const km_pose *pose) {
  return (km_pose){pose->R, km_vec3_scale(1.0 / a->length, km_vec3_sub(pose->p, a->origin))};
}

km_pose km_arm_pose_of(const km_arm *a, const km_frame_pose *given) {
  const double *R = given->R;
  km_pose pose = {{{{R[0], R[3], R[6]}, {R[1], R[4], R[7]}, {R[2], R[5], R[8]}}}, km_vec3_from_array(given->p)};
  return km_arm_from_model(a, &pose);
}

km_pose km_arm_to_model(const km_arm *a, const km_pose *pose) {
  return (km_pose){pose->R, km_vec3_axpy(a->length, pose->p, a->origin)};
}

/* A value at its limit, up to rounding, is inside. */
int km_arm_limit_passed(const km_arm *a, const double *q) {
  for (int k = 0; k < a->n; ++k) {
    double slack = 1e-12 * (1.0 + fabs(q[k]));
    if (!(q[k] <= a->high[k] + slack && q[k] >= a->low[k] - slack))
      return k;
  }
  return -1;
}

/* Least (distance to the nearer limit)/(half range) over the limited joints. */
double km_arm_limit_distance(const km_arm *a, const double *q) {
  double least = 1.0;
  for (int k = 0; k < a->n; ++k) {
    double half = 0.5 * (a->high[k] - a->low[k]);
    if (half < (double)INFINITY)
      least = fmin(least, fmin(q[k] - a->low[k], a->high[k] - q[k]) / half);
  }
  return least;
}
