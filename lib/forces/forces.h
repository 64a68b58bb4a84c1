/* Applied forces at a configuration, about a point near the mechanism. Each kind of force adds its part to the same
 * sums. */
#ifndef KM_FORCES_FORCES_H
#define KM_FORCES_FORCES_H

#include "base/text.h"
#include "kinematics/state.h"
#include "kmech/dynamics.h"
#include "spatial/wrench.h"

/* Values of a force module at the last update. */
typedef struct km_module_report {
  double variable, force, power; /* variable and force of a law or controller; power of any module */
  /* Tyres: force on the wheel at the contact point along its heading, across it and along the road's normal; moment
   * about these axes; longitudinal slip and slip angle. */
  km_vec3 tire_force, tire_moment;
  double slip, slip_angle; /* `slip` of a contact is its slip speed */
  double depth, friction;  /* contacts: penetration, magnitude of the friction; `force` is the normal force */
} km_module_report;

struct km_forces {
  km_arena arena;
  const km_mechanism *mechanism;
  km_vec3 stated_gravity; /* g as stated, length/time² */
  km_vec3 gravity;        /* g as force per unit of mass, model's units */
  int load_count, spring_count;
  double *extra;       /* [coordinate] additional joint forces along +q, set by an analysis or a program; initially 0 */
  double *reference;   /* [module of the model] reference set by a program; NaN: the controller's law */
  km_user_forces user; /* forces of a program; compute NULL: none */
  km_load *loads;
  const km_model_module **springs; /* force modules of type stiffness */
  int contact_count, stop_count;
  const km_model_module **contacts; /* force modules of type contact */
  int *stops;                       /* coordinates with limits and a stop */
  km_joint_stop limit_stop;         /* stop at limits of joints without one; 0: none */
  km_module_report *report;         /* [module of the model] */
  struct km_moving_forces *moving;  /* forces that act during a motion; NULL in statics */
  /* Results of km_forces_compute. Wrenches are along the inertial axes, moments about `origin`. */
  km_vec3 origin;         /* point near the mechanism, because moments about a distant point lose digits */
  km_pose *pose;          /* [body] in the inertial frame moved to `origin` */
  km_twist *twist;        /* [body] about `origin`; 0 in statics */
  km_twist *acceleration; /* [body] rate of the twist; NULL: not known */
  km_wrench *body;        /* [body] applied wrenches */
  double *joint;          /* [coordinate] forces in joints along +q */
  double force_size;      /* sum of the magnitudes of all forces */
  double couple_size;     /* sum of the magnitudes of all couples; both scale rounding errors */
};

/* Appends the unit of a coordinate's generalised force, for example "N" or "N*mm"; km_torque_unit that of a torque. */
void km_force_unit(const km_model *model, int coordinate, km_text *out);
void km_torque_unit(const km_model *model, km_text *out);

double km_law_force(const km_law *law, double displacement);
/* Value of a module's law, piecewise polynomial or curve, at its variable. */
double km_module_law_value(const km_model_module *module, double variable);
/* Force of a law in a rate. Jumps at its knots are spread over rates up to `width` on both sides (at most half the
 * distance to the next knot), like friction near rest, so that a load at rest stays at rest. */
double km_law_resistance(const km_law *law, double rate, double width);
/* Work: integral of the force from 0 to the displacement. */
double km_law_work(const km_law *law, double displacement);

/* Measure between two frames: origins of parent and child, displacement and its derivatives, and its gradient by the
 * child's position (a unit vector; 0 for coincident points) or, of an angle, by its rotation. */
typedef struct km_line {
  km_vec3 from, to, along;
  bool is_angle;
  double displacement, rate, acceleration;
} km_line;
km_line km_line_of(const km_mechanism *mechanism, const km_forces *forces, const km_module_port *port,
                   km_distance distance);
/* d|q|/dq of a strut's coordinate, whose length is |q|: 1, or −1 if its ends have passed each other; 1 for other
 * coordinates. */
double km_length_sense(const km_mechanism *mechanism, const km_state *state, int coordinate);
/* Sum of the weighted inputs of a force module; of a strut its length counts. The acceleration belongs to the last
 * solution of the equations of motion. */
typedef struct km_measured {
  double displacement, velocity, acceleration;
} km_measured;
km_measured km_module_measure(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                              const km_model_module *module);
/* Report of a module. */
static inline km_module_report *km_module_report_of(const km_mechanism *mechanism, const km_forces *forces,
                                                    const km_model_module *module) {
  return &forces->report[module - mechanism->model->modules];
}
/* The force within the module's bounds. */
double km_module_saturate(const km_model_module *module, double force);
/* Adds a module's force at its output; returns the rate of the output along the force. */
double km_module_apply(const km_mechanism *mechanism, const km_state *state, km_forces *forces,
                       const km_model_module *module, double force);

/* Collects the model's modules of type stiffness in forces->springs. */
void km_springs_collect(const km_model *model, km_forces *forces);
/* Adds the spring forces. Returns the power of springs that are not conservative: those that act where they do not
 * measure, or on a ball's coordinate. */
double km_springs_add(const km_mechanism *mechanism, const km_state *state, km_forces *forces);
/* Energy stored in the conservative springs, 0 at displacement 0. */
double km_springs_energy(const km_mechanism *mechanism, const km_state *state, const km_forces *forces);

/* Where the bodies of a contact module are closest, about the forces' origin (contact.c). */
typedef struct km_touch {
  km_vec3 normal, point, slip; /* normal from parent to child; contact point; velocity of the child along the surface */
  double depth, depth_rate;    /* penetration δ, negative where the bodies are apart, and its rate */
} km_touch;
km_touch km_contact_touch(const km_mechanism *mechanism, const km_forces *forces, const km_model_module *module);
/* KM_MODEL: a contact that doesn't act between frames, or whose numbers can't be used. */
km_status km_contacts_check(const km_model *model, km_error *error);
/* Collects the model's contacts in forces->contacts. */
void km_contacts_collect(const km_model *model, km_forces *forces);
/* Adds the forces of all contacts and their reports; returns the dissipated power. Requires poses and twists; in
 * statics twists are 0, so that the elastic parts of the normal forces remain. */
double km_contacts_add(const km_mechanism *mechanism, km_forces *forces, bool has_friction);
/* Energy stored in all contacts. Requires the poses of the last update. */
double km_contacts_energy(const km_mechanism *mechanism, const km_forces *forces);

/* KM_MODEL: a stop of one component of a ball. */
km_status km_stops_check(const km_mechanism *mechanism, km_error *error);
/* Lists the coordinates with limits and a stop in forces->stops. */
void km_stops_list(const km_mechanism *mechanism, km_forces *forces);
/* Adds the forces of all stops; returns the dissipated power. `moves`: rates count; false in statics. */
double km_stops_add(const km_mechanism *mechanism, const km_state *state, bool moves, km_forces *forces);
/* Excess of a coordinate over its limits (of a ball's angle: at least 0), and the force of its stop at rest. */
double km_stop_excess(const km_mechanism *mechanism, const km_state *state, int coordinate);
double km_stop_force(const km_mechanism *mechanism, const km_state *state, const km_forces *forces, int coordinate);
/* Energy stored in stops. */
double km_stops_energy(const km_mechanism *mechanism, const km_state *state, const km_forces *forces);

/* As km_forces_create with gravity 0 and without force modules and stops. */
km_status km_forces_create_loads_only(const km_mechanism *mechanism, const km_load *loads, int load_count,
                                      km_forces **out, km_error *error);
/* Adds the loads; returns their power. */
double km_loads_add(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* Adds a force in a joint along +q of a coordinate. */
void km_forces_add_joint(const km_model *model, km_forces *forces, int coordinate, double force);

/* Adds a force on a body at a point (about `origin`), and a couple. */
static inline void km_forces_add(km_forces *f, int body, km_vec3 force, km_vec3 couple, km_vec3 point) {
  f->body[body] = km_wrench_axpy(1.0, km_wrench_at(force, couple, point), f->body[body]);
  f->force_size += km_vec3_norm(force);
  f->couple_size += km_vec3_norm(couple);
}

#endif
