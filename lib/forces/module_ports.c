/* Inputs and outputs of force modules (docs/theory.md 11.8).
 *
 *   r = p_B − p_A,  v, a of the points, ω, α of the parent A; axis e of A; d distance, u = r/d
 *   euclid: d,       ḋ = u · (v_B − v_A),            d̈ = u · (a_B − a_A) + (|v_B − v_A|² − ḋ²)/d
 *   T     : e · r,   e · ṡ,  ṡ = v_B − v_A − ω × r,   e · (a_B − a_A − α × r − ω × ṙ) + (ω × e) · ṡ
 *   R     : θ = atan2(b_y, b_x),  b an axis of B in A,  θ̇ = g · ω_rel,  g = b × (b_x e_y − b_y e_x)/(b_x² + b_y²)
 *
 * A force F acts along the gradient of the displacement, so that its power is F times the rate. */
#include "forces/forces.h"

/* Rounding of positions, relative to the lengths that they result from. */
static const double rounding = 1e-11;

/* Motion of a point of a body: p, v and a in inertial axes about the forces' origin. */
typedef struct point_motion {
  km_vec3 p, v, a;
} point_motion;

static km_twist body_acceleration(const km_forces *f, int body) {
  return f->acceleration ? f->acceleration[body] : (km_twist){{0, 0, 0}, {0, 0, 0}};
}

static point_motion move_with_body(const km_forces *f, int body, km_vec3 p) {
  km_twist V = f->twist[body];
  return (point_motion){p, km_point_velocity(V, p), km_point_acceleration(V, body_acceleration(f, body), p)};
}

/* Distance of two points and its derivatives; the direction is 0 for coincident points. */
static void measure_distance(const km_mechanism *m, const point_motion *A, const point_motion *B, km_line *l) {
  km_vec3 r = km_vec3_sub(B->p, A->p), v = km_vec3_sub(B->v, A->v), a = km_vec3_sub(B->a, A->a);
  l->displacement = km_vec3_norm(r);
  if (!(l->displacement > rounding * (m->length + km_vec3_norm(A->p))))
    return;
  l->along = km_vec3_scale(1.0 / l->displacement, r);
  l->rate = km_vec3_dot(l->along, v);
  l->acceleration = km_vec3_dot(l->along, a) + (km_vec3_dot(v, v) - l->rate * l->rate) / l->displacement;
}

/* Component along an axis of the parent and its derivatives. */
static void measure_component(const point_motion *A, const point_motion *B, km_vec3 axis, km_vec3 w, km_vec3 alpha,
                              km_line *l) {
  km_vec3 r = km_vec3_sub(B->p, A->p), v = km_vec3_sub(B->v, A->v), a = km_vec3_sub(B->a, A->a);
  km_vec3 s = km_vec3_sub(v, km_vec3_cross(w, r));
  km_vec3 change = km_vec3_sub(a, km_vec3_add(km_vec3_cross(alpha, r), km_vec3_cross(w, v)));
  l->along = axis;
  l->displacement = km_vec3_dot(axis, r);
  l->rate = km_vec3_dot(axis, s);
  l->acceleration = km_vec3_dot(axis, change) + km_vec3_dot(km_vec3_cross(w, axis), s);
}

/* Angle of the child about axis k of the parent and its derivatives. */
static void measure_angle(const km_rotation *A, const km_rotation *B, int k, km_vec3 w, km_vec3 alpha, km_vec3 wA,
                          km_line *l) {
  km_vec3 ex = A->axis[(k + 1) % 3], ey = A->axis[(k + 2) % 3], b = B->axis[(k + 1) % 3];
  double x = km_vec3_dot(b, ex), y = km_vec3_dot(b, ey), square = x * x + y * y;
  l->is_angle = true;
  l->displacement = atan2(y, x);
  if (!(square > rounding))
    return;
  km_vec3 change = km_vec3_cross(w, b); /* relative to the parent */
  /* α is of the inertial axes: relative to the parent ω changes by α − ω_A × ω */
  km_vec3 relative = km_vec3_sub(alpha, km_vec3_cross(wA, w));
  km_vec3 second = km_vec3_add(km_vec3_cross(relative, b), km_vec3_cross(w, change));
  double dx = km_vec3_dot(change, ex), dy = km_vec3_dot(change, ey);
  double ddx = km_vec3_dot(second, ex), ddy = km_vec3_dot(second, ey);
  l->along = km_vec3_scale(1.0 / square, km_vec3_cross(b, km_vec3_axpy(-y, ex, km_vec3_scale(x, ey))));
  l->rate = (x * dy - y * dx) / square;
  l->acceleration = (x * ddy - y * ddx) / square - l->rate * 2.0 * (x * dx + y * dy) / square;
}

km_line km_line_of(const km_mechanism *m, const km_forces *f, const km_module_port *port, km_distance distance) {
  const km_model_frame *a = &m->model->frames[port->frame[0]], *b = &m->model->frames[port->frame[1]];
  km_pose XA = km_pose_product(&f->pose[a->body], &a->pose), XB = km_pose_product(&f->pose[b->body], &b->pose);
  point_motion A = move_with_body(f, a->body, XA.p), B = move_with_body(f, b->body, XB.p);
  km_twist VA = f->twist[a->body], VB = f->twist[b->body];
  km_twist AA = body_acceleration(f, a->body), AB = body_acceleration(f, b->body);
  km_line l = {.from = A.p, .to = B.p};
  if (distance == KM_DISTANCE_EUCLID)
    measure_distance(m, &A, &B, &l);
  else if (distance <= KM_DISTANCE_Z)
    measure_component(&A, &B, XA.R.axis[distance - KM_DISTANCE_X], VA.w, AA.w, &l);
  else
    measure_angle(&XA.R, &XB.R, (int)distance - KM_DISTANCE_RX, km_vec3_sub(VB.w, VA.w), km_vec3_sub(AB.w, AA.w), VA.w,
                  &l);
  return l;
}

double km_length_sense(const km_mechanism *m, const km_state *s, int c) {
  return m->model->coordinates[c].is_strut && s->q[c] < 0.0 ? -1.0 : 1.0;
}

/* A component of the motion of one frame. Angular motion has no displacement. */
static km_measured measure_frame(const km_mechanism *m, const km_forces *f, const km_module_input *in) {
  const km_model_frame *def = &m->model->frames[in->port.frame[0]];
  km_pose X = km_pose_product(&f->pose[def->body], &def->pose);
  point_motion o = move_with_body(f, def->body, X.p);
  km_vec3 inertial[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  km_vec3 axis = in->body_axes ? X.R.axis[in->component % 3] : inertial[in->component % 3];
  if (in->component >= 3)
    return (km_measured){nan(""), km_vec3_dot(axis, f->twist[def->body].w),
                         km_vec3_dot(axis, body_acceleration(f, def->body).w)};
  return (km_measured){km_vec3_dot(axis, km_vec3_add(X.p, f->origin)), km_vec3_dot(axis, o.v), km_vec3_dot(axis, o.a)};
}

static km_measured measure_input(const km_mechanism *m, const km_state *s, const km_forces *f,
                                 const km_module_input *in) {
  int c = in->port.coordinate;
  if (c == KM_MODULE_PORT_FRAME)
    return measure_frame(m, f, in);
  if (c == KM_MODULE_PORT_FRAMES) {
    km_line l = km_line_of(m, f, &in->port, in->distance);
    return (km_measured){l.displacement, l.rate, l.acceleration};
  }
  double sense = km_length_sense(m, s, c);
  return (km_measured){sense * s->q[c], sense * s->rate[c], sense * s->acceleration[c]};
}

km_measured km_module_measure(const km_mechanism *m, const km_state *s, const km_forces *f,
                              const km_model_module *module) {
  km_measured sum = {0.0, 0.0, 0.0};
  for (int i = 0; i < module->input_count; ++i) {
    const km_module_input *in = &module->inputs[i];
    km_measured x = measure_input(m, s, f, in);
    sum.displacement += in->weight * x.displacement;
    sum.velocity += in->weight * x.velocity;
    sum.acceleration += in->weight * x.acceleration;
  }
  return sum;
}

/* Between frames both forces act at the child's point, so that their power is force · rate of the displacement also
 * for a displacement along a parent's axis. */
double km_module_apply(const km_mechanism *m, const km_state *s, km_forces *f, const km_model_module *module,
                       double force) {
  const km_vec3 none = {0, 0, 0};
  int c = module->output.coordinate;
  if (c >= 0) {
    double sense = km_length_sense(m, s, c);
    km_forces_add_joint(m->model, f, c, sense * force);
    return sense * s->rate[c];
  }
  km_line l = km_line_of(m, f, &module->output, module->distance);
  for (int side = 0; side < 2; ++side) {
    km_vec3 part = km_vec3_scale(side ? force : -force, l.along);
    km_forces_add(f, m->model->frames[module->output.frame[side]].body, l.is_angle ? none : part,
                  l.is_angle ? part : none, l.to);
  }
  return l.rate;
}
