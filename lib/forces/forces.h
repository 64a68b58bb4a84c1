/* Forces at a pose, about a point near the mechanism. Kinds of force add their own parts to the same sums. */
#ifndef KM_FORCES_FORCES_H
#define KM_FORCES_FORCES_H

#include "base/text.h"
#include "kinematics/state.h"
#include "kmech/statics.h"
#include "spatial/wrench.h"

struct km_forces {
  km_arena arena;
  const km_mechanism *mechanism;
  km_vec3 stated_gravity; /* length / time² */
  km_vec3 gravity;        /* force a unit of mass, model's units */
  int load_count, spring_count;
  double *extra; /* [coordinate] forces in joints along +q that an analysis sets; 0 at first */
  km_load *loads;
  const km_model_module **springs; /* force modules of type stiffness */
  struct km_moving_forces *moving; /* what acts beside them while the mechanism moves; NULL in statics */
  /* At the last pose, by km_forces_compute. Wrenches along the inertial axes, moments about `origin`. */
  km_vec3 origin;     /* near the mechanism: far from the inertial origin digits would be lost */
  km_pose *pose;      /* [body] in the inertial frame moved to `origin` */
  km_twist *twist;    /* [body] about `origin`; 0 in statics */
  km_wrench *body;    /* [body] applied wrenches */
  double *joint;      /* [coordinate] forces in joints along +q */
  double force_size;  /* Σ of the forces' lengths, … */
  double couple_size; /* … and of the couples': what rounding is measured by */
};

/* "N", "N*mm": the unit of a coordinate's generalised force, and of a torque. Appended. */
void km_force_unit(const km_model *model, int coordinate, km_text *out);
void km_torque_unit(const km_model *model, km_text *out);

double km_law_force(const km_law *law, double displacement);
/* The same of a law in a rate: jumps at its knots are spread over rates of up to `width` to either side (of knots that lie nearer
 * to each other, up to half the way), as friction is near rest, so that what it brings to rest stays there. */
double km_law_resistance(const km_law *law, double rate, double width);
/* The integral of the force from 0. */
double km_law_work(const km_law *law, double displacement);

/* A port between frames as it stands: from the parent's origin to the child's, and the line of its displacement. Two
 * points in one place have no line between them: a force there has no direction, and counts as 0. */
typedef struct km_line {
  km_vec3 from, to, along; /* unit vector */
  double displacement, rate;
} km_line;
km_line km_line_of(const km_mechanism *mechanism, const km_forces *forces, const km_module_port *port,
                   km_distance distance);
/* d|q|/dq of a strut's coordinate, whose length is |q|: 1, or -1 where its ends have passed each other; 1 for other coordinates. */
double km_length_sense(const km_mechanism *mechanism, const km_state *state, int coordinate);
/* What a module measures: a coordinate (of a strut its length), or a displacement between frames; and its rate. */
double km_module_input(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                       const km_model_module *module, double *rate);
/* Adds the module's force at its output; returns the rate at which the output moves along it. */
double km_module_push(const km_mechanism *mechanism, const km_state *state, km_forces *forces,
                      const km_model_module *module, double force);

/* Gathers the model's modules of type stiffness into forces->springs. */
km_status km_springs_gather(const km_model *model, km_forces *forces, km_error *error);
/* Adds their forces at the poses. Returns the power of those that act elsewhere than where they measure, or on a ball's
 * coordinate: they store nothing of it. */
double km_springs_add(const km_mechanism *mechanism, const km_state *state, km_forces *forces);
/* What the others store at the poses, from displacement 0 on. */
double km_springs_energy(const km_mechanism *mechanism, const km_state *state, const km_forces *forces);
/* Adds the loads at the poses. */
void km_loads_add(const km_mechanism *mechanism, km_forces *forces);

/* Adds a force in a joint along +q of a coordinate. */
void km_forces_add_joint(const km_model *model, km_forces *forces, int coordinate, double force);

/* Adds a force on a body at a point (about `origin`), and a couple. */
static inline void km_forces_add(km_forces *f, int body, km_vec3 force, km_vec3 couple, km_vec3 point) {
  f->body[body] = km_wrench_axpy(1.0, km_wrench_at(force, couple, point), f->body[body]);
  f->force_size += km_vec3_norm(force);
  f->couple_size += km_vec3_norm(couple);
}

#endif
