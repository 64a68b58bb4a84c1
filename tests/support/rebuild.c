#include "support/rebuild.h"

#include "model/model.h"
#include "support/support.h"

#include <string.h>

/* The ids of the copy's elements, by the original's index. */
typedef struct ids {
  km_assembly_id *assembly;
  km_body_id *body;
  km_frame_id *frame;
  km_joint_id *joint;
} ids;

static km_error error;

static void check(km_status status) {
  if (status)
    fail_msg("%s", error.text);
}

static void copy3(double out[3], km_vec3 v) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

static void add_settings(const km_model *m, km_builder *b) {
  km_settings_def d = km_settings_default();
  const km_units *u = &m->units;
  d.angle = u->angle->word;
  d.length = u->length->word;
  d.mass = u->mass->word;
  d.time = u->time->word;
  d.force = u->force->word;
  copy3(d.gravity, m->gravity);
  d.characteristic_length = m->characteristic_length;
  d.closure_tolerance = m->closure_tolerance_given ? m->closure_tolerance : 0.0;
  d.source = m->source;
  check(km_model_set(b, &d, &error));
}

static void add_bodies(const km_model *m, km_builder *b, ids *to) {
  for (int a = 0; a < m->assembly_count; ++a) {
    int parent = m->assemblies[a].parent;
    check(km_model_add_assembly(b, m->assemblies[a].name, parent < 0 ? (km_assembly_id){0} : to->assembly[parent],
                                &to->assembly[a], &error));
  }
  to->body[0] = km_builder_fixed(b);
  for (int i = 1; i < m->body_count; ++i) {
    const km_model_body *from = &m->bodies[i];
    km_body_def d = km_body_default();
    d.name = from->name;
    d.assembly = to->assembly[from->assembly];
    d.mass = from->mass;
    copy3(d.center_of_mass, from->center_of_mass);
    memcpy(d.inertia, from->inertia, sizeof d.inertia);
    d.mesh = from->mesh;
    check(km_model_add_body(b, &d, &to->body[i], &error));
  }
  for (int f = 0; f < m->frame_count; ++f) {
    const km_model_frame *from = &m->frames[f];
    if (strcmp(from->name, "origin") == 0) {
      to->frame[f] = km_builder_origin(b, to->body[from->body]);
      continue;
    }
    km_frame_def d = km_frame_default();
    d.name = from->name;
    copy3(d.T, from->pose.p);
    for (int k = 0; k < 3; ++k) {
      double column[3];
      copy3(column, from->pose.R.axis[k]);
      for (int r = 0; r < 3; ++r)
        d.R[3 * r + k] = column[r];
    }
    check(km_model_add_frame(b, to->body[from->body], &d, &to->frame[f], &error));
  }
}

static void add_shapes(const km_model *m, km_builder *b, const ids *to) {
  for (int s = 0; s < m->shape_count; ++s) {
    const km_model_shape *from = &m->shapes[s];
    km_shape_def d = km_shape_default();
    d.kind = from->kind;
    d.mesh = from->mesh;
    d.density = from->density;
    copy3(d.T, from->pose.p);
    km_rotation_rows(&from->pose.R, d.R);
    for (int k = 0; k < 4; ++k)
      d.color[k] = from->color[k];
    for (int k = 0; k < 3; ++k) {
      d.size[k] = from->size[k];
      d.scale[k] = from->scale[k];
    }
    check(km_model_add_shape(b, to->body[from->body], &d, &error));
  }
}

static void add_joints(const km_model *m, km_builder *b, ids *to) {
  for (int j = 0; j < m->joint_count; ++j) {
    const km_model_joint *from = &m->joints[j];
    km_joint_def d = km_joint_default();
    d.name = from->name;
    d.assembly = to->assembly[from->assembly];
    d.type = from->type;
    d.parent = to->frame[from->frame[0]];
    d.child = to->frame[from->frame[1]];
    d.pitch = from->pitch;
    d.friction = from->friction.coefficient;
    d.friction_radius = from->friction.radius;
    d.stiction_velocity = from->friction.stiction_velocity;
    d.stop_stiffness = from->stop.stiffness;
    d.stop_damping = from->stop.damping;
    d.law = from->prescribed.law;
    d.law_count = from->prescribed.count;
    d.law_values = from->prescribed.values;
    for (int k = 0; k < km_model_freedom(m, j); ++k) {
      const km_model_coordinate *c = &m->coordinates[from->first_coordinate + k];
      d.position[k] = c->position;
      d.velocity[k] = c->rate;
      d.damping[k] = c->damping;
      d.low[k] = c->low;
      d.high[k] = c->high;
      d.max_rate[k] = c->max_rate;
      d.max_force[k] = c->max_force;
      d.armature[k] = c->armature;
      d.constant_friction[k] = c->friction;
    }
    check(km_model_add_joint(b, &d, &to->joint[j], &error));
  }
}

static km_coordinate_ref ref(const km_model *m, const ids *to, int coordinate) {
  if (coordinate < 0)
    return (km_coordinate_ref){{0}, 0};
  return (km_coordinate_ref){to->joint[m->coordinates[coordinate].joint], m->coordinates[coordinate].index};
}

static void add_couplings(const km_model *m, km_builder *b, const ids *to) {
  for (int i = 0; i < m->coupling_count; ++i) {
    const km_model_coupling *from = &m->couplings[i];
    km_coordinate_ref *refs = KM_NEW(km_coordinate_ref, (size_t)from->count);
    for (int k = 0; k < from->count; ++k)
      refs[k] = ref(m, to, from->coordinates[k]);
    km_coupling_def d = {.name = from->name,
                         .count = from->count,
                         .coordinates = refs,
                         .ratios = from->ratios,
                         .constant_given = from->constant_given,
                         .constant = from->constant,
                         .polynomial_count = from->polynomial_count,
                         .polynomial = from->polynomial};
    check(km_model_add_coupling(b, &d, &error));
    km_free(refs);
  }
}

static void add_forces(const km_model *m, km_builder *b, const ids *to) {
  for (int i = 0; i < m->module_count; ++i) {
    const km_model_module *from = &m->modules[i];
    int sizes[64];
    for (int k = 0; k <= from->law.knot_count; ++k)
      sizes[k] = from->law.start[k + 1] - from->law.start[k];
    km_force_def d = km_force_default();
    d.name = from->name;
    d.type = from->type;
    d.coordinate = ref(m, to, from->input.coordinate);
    if (from->input.coordinate < 0) {
      d.from = to->frame[from->input.frame[0]];
      d.to = to->frame[from->input.frame[1]];
    }
    d.distance = from->distance;
    d.knot_count = from->law.knot_count;
    d.knots = from->law.knots;
    d.piece_sizes = sizes;
    d.coefficients = from->law.coefficients;
    check(km_model_add_force(b, &d, &error));
  }
}

static km_end_def end_of(const km_model *m, const ids *to, const km_model_port *from) {
  km_end_def d = {.coordinate = ref(m, to, from->coordinate)};
  if (from->frame >= 0)
    d.frame = to->frame[from->frame];
  copy3(d.direction, from->direction);
  return d;
}

static void add_analysis(const km_model *m, km_builder *b, const ids *to) {
  for (int i = 0; i < m->load_count; ++i) {
    const km_applied_load *from = &m->loads[i];
    km_load_def d = {.name = from->name, .frame = to->frame[from->frame], .turning = from->turning};
    copy3(d.force, from->force);
    copy3(d.torque, from->torque);
    check(km_model_add_load(b, &d, &error));
  }
  for (int h = 0; h < m->hold_count; ++h)
    check(km_model_add_hold(b, ref(m, to, m->holds[h].coordinate), m->holds[h].value, &error));
  for (int a = 0; a < m->actuator_count; ++a)
    check(km_model_add_actuator(b, ref(m, to, m->actuators[a]), &error));
  km_sweep_def sweep = km_sweep_default();
  sweep.driver = ref(m, to, m->sweep.coordinate);
  sweep.from = m->sweep.range[0];
  sweep.to = m->sweep.range[1];
  sweep.arclength = m->sweep.arclength;
  sweep.direction = ref(m, to, m->sweep.direction);
  sweep.sign = m->sweep.sign;
  sweep.steps = m->sweep.steps;
  if (m->sweep.coordinate >= 0 || m->sweep.arclength > 0.0)
    check(km_model_set_sweep(b, &sweep, &error));
  const km_model_port *in = &m->advantage_input, *out = &m->advantage_output;
  if ((in->coordinate >= 0 || in->frame >= 0) && (out->coordinate >= 0 || out->frame >= 0)) {
    km_end_def input = end_of(m, to, in), output = end_of(m, to, out);
    check(km_model_set_advantage(b, &input, &output, &error));
  }
}

km_model *rebuild(const km_model *m) {
  km_builder *b;
  km_model *copy;
  ids to = {KM_NEW(km_assembly_id, (size_t)m->assembly_count + 1), KM_NEW(km_body_id, (size_t)m->body_count),
            KM_NEW(km_frame_id, (size_t)m->frame_count), KM_NEW(km_joint_id, (size_t)m->joint_count + 1)};
  check(km_builder_create(&b, &error));
  add_settings(m, b);
  add_bodies(m, b, &to);
  add_shapes(m, b, &to);
  add_joints(m, b, &to);
  add_couplings(m, b, &to);
  add_forces(m, b, &to);
  add_analysis(m, b, &to);
  check(km_builder_finish(b, &copy, &error));
  km_builder_free(b);
  km_free(to.assembly);
  km_free(to.body);
  km_free(to.frame);
  km_free(to.joint);
  return copy;
}
