/* The kinematic model of a mechanism with changed joint types (theory 7.5).
 *
 *   X_child = X_parent · motion(q);   the frames of a changed joint are turned by B, so that its type's axes fit:
 *   cylindrical B = (a b k),  universal B = (n k ·) with the second axis n fixed in the parent,
 *   planar B = (k · n);       series: slides along the parent frame's axes, then a hinge or a ball joint
 *
 * New coordinates are 0 and the others have their values: the changed model starts at the given configuration. */
#include "mobility/remedies/changed_model.h"

#include "kinematics/state.h"
#include "kmech/build.h"
#include "mobility/remedies/joint_options.h"

#include <stdio.h>
#include <string.h>

/* A copy in progress. */
typedef struct model_copy {
  const km_mechanism *m;
  const double *values; /* [coordinate count] configuration, in the file's units */
  const km_remedy_set *set;
  km_builder *builder;
  km_frame_id *frame; /* [frame of the model] */
  km_joint_id *joint; /* [joint of the model] the copy; {0} of a series of joints */
  int added;          /* number of frames and bodies that were added, for their names */
  km_error *error;
} model_copy;

static const km_joint_change *find_change(const model_copy *c, int joint) {
  for (int i = 0; i < c->set->change_count; ++i)
    if (c->set->changes[i].joint == joint)
      return &c->set->changes[i];
  return NULL;
}

static km_assembly_id assembly_of(int assembly) {
  return (km_assembly_id){assembly == KM_NO_ASSEMBLY ? 0 : assembly + 1};
}

static km_status copy_settings(const model_copy *c) {
  const km_model *model = c->m->model;
  km_settings_def def = km_settings_default();
  def.angle = model->units.angle->word;
  def.length = model->units.length->word;
  def.mass = model->units.mass->word;
  def.time = model->units.time->word;
  def.force = model->units.force->word;
  def.characteristic_length = model->characteristic_length;
  def.closure_tolerance = model->closure_tolerance_given ? model->closure_tolerance : 0.0;
  km_status status = km_model_set(c->builder, &def, c->error);
  for (int i = 0; i < model->assembly_count && !status; ++i)
    status = km_model_add_assembly(c->builder, model->assemblies[i].name, assembly_of(model->assemblies[i].parent),
                                   NULL, c->error);
  return status;
}

/* Adds a frame to a body of the copy, under a name of its own. */
static km_status add_frame(model_copy *c, km_body_id body, const km_pose *pose, km_frame_id *out) {
  char name[40];
  km_frame_def def = km_frame_default();
  snprintf(name, sizeof name, "changed joint %d", ++c->added);
  def.name = name;
  km_vec3_write(pose->p, def.T);
  km_rotation_rows(&pose->R, def.R);
  return km_model_add_frame(c->builder, body, &def, out, c->error);
}

static km_status copy_bodies(const model_copy *c) {
  const km_model *model = c->m->model;
  km_status status = KM_OK;
  for (int i = 1; i < model->body_count && !status; ++i) {
    km_body_def def = km_body_default();
    def.name = model->bodies[i].name;
    def.assembly = assembly_of(model->bodies[i].assembly);
    status = km_model_add_body(c->builder, &def, NULL, c->error);
  }
  return status;
}

static km_status copy_frames(model_copy *c) {
  const km_model *model = c->m->model;
  km_status status = KM_OK;
  for (int i = 0; i < model->frame_count && !status; ++i) {
    const km_model_frame *frame = &model->frames[i];
    km_body_id body = {frame->body + 1};
    if (strcmp(frame->name, "origin") == 0) {
      c->frame[i] = km_builder_origin(c->builder, body);
      continue;
    }
    km_frame_def def = km_frame_default();
    def.name = frame->name;
    km_vec3_write(frame->pose.p, def.T);
    km_rotation_rows(&frame->pose.R, def.R);
    status = km_model_add_frame(c->builder, body, &def, &c->frame[i], c->error);
  }
  return status;
}

/* Index of the only axis of three bits, -1 if there is none. */
static int axis_of(int bits) {
  for (int k = 0; k < 3; ++k)
    if (bits >> k & 1)
      return k;
  return -1;
}

static km_vec3 unit_vector(int axis, double sign) {
  return (km_vec3){axis == 0 ? sign : 0.0, axis == 1 ? sign : 0.0, axis == 2 ? sign : 0.0};
}

/* The rotation with these two axes as its columns i and i + 1. */
static km_rotation turned_axes(int i, int first, int second) {
  km_rotation B;
  B.axis[i] = unit_vector(first, 1.0);
  B.axis[(i + 1) % 3] = unit_vector(second, 1.0);
  B.axis[(i + 2) % 3] = km_vec3_cross(B.axis[i], B.axis[(i + 1) % 3]);
  return B;
}

/* The turn B of the frames for a type of the format, and the place of the own coordinate in the new type. */
static km_rotation type_axes(km_joint_type type, const km_joint_option *option, int *place) {
  int slide = axis_of(option->own), turn = axis_of(option->own >> 3);
  int k = turn >= 0 ? turn : slide;
  switch (type) {
  case KM_CYLINDRICAL:
    *place = turn >= 0;
    return turned_axes(2, k, (k + 1) % 3);
  case KM_UNIVERSAL:
    *place = 1;
    return turned_axes(0, axis_of(option->added >> 3), k);
  default: /* planar: the slide is its x axis, the added rotation its z axis */
    *place = 0;
    return turned_axes(2, axis_of(option->added >> 3), k);
  }
}

static km_status add_joint(model_copy *c, const km_model_joint *joint, km_joint_def *def, km_joint_id *out) {
  def->name = def->name ? def->name : joint->name;
  def->assembly = assembly_of(joint->assembly);
  return km_model_add_joint(c->builder, def, out, c->error);
}

/* A copy with its own type, or a spherical joint in its place: the frames stay. */
static km_status copy_joint(model_copy *c, int j, bool becomes_spherical) {
  const km_model_joint *joint = &c->m->model->joints[j];
  km_joint_def def = km_joint_default();
  def.type = becomes_spherical ? KM_SPHERICAL : joint->type;
  def.parent = c->frame[joint->frame[0]];
  def.child = c->frame[joint->frame[1]];
  def.pitch = joint->pitch;
  int axis = becomes_spherical ? km_joint_kind_of(joint->type)->motions[0].axis : 0;
  for (int k = 0; k < km_model_freedom(c->m->model, j); ++k)
    def.position[axis + k] = c->values[joint->first_coordinate + k];
  return add_joint(c, joint, &def, &c->joint[j]);
}

/* A joint with another type of the format between turned frames. */
static km_status copy_as_type(model_copy *c, int j, km_joint_type type, const km_joint_option *option) {
  const km_model *model = c->m->model;
  const km_model_joint *joint = &model->joints[j];
  int place;
  km_rotation B = type_axes(type, option, &place);
  km_frame_id ends[2];
  km_status status = KM_OK;
  for (int end = 0; end < 2 && !status; ++end) {
    const km_model_frame *frame = &model->frames[joint->frame[end]];
    km_pose pose = {km_rotation_product(&frame->pose.R, &B), frame->pose.p};
    status = add_frame(c, (km_body_id){frame->body + 1}, &pose, &ends[end]);
  }
  km_joint_def def = km_joint_default();
  def.type = type;
  def.parent = ends[0];
  def.child = ends[1];
  def.position[place] = c->values[joint->first_coordinate];
  return status ? status : add_joint(c, joint, &def, &c->joint[j]);
}

/* A slide of a series from `*from` to a body of its own, whose origin becomes `*from`. */
static km_status add_series_slide(model_copy *c, const km_model_joint *joint, int axis, double length,
                                  km_frame_id *from) {
  char name[200];
  snprintf(name, sizeof name, "%.150s, slide %d", joint->name, ++c->added);
  km_body_def body = km_body_default();
  km_body_id id;
  body.name = name;
  body.assembly = assembly_of(joint->assembly);
  km_status status = km_model_add_body(c->builder, &body, &id, c->error);
  if (status)
    return status;
  km_joint_def def = km_joint_default();
  def.name = name;
  def.type = (km_joint_type)(KM_TX + axis);
  def.parent = *from;
  def.child = *from = km_builder_origin(c->builder, id);
  def.position[0] = length;
  return add_joint(c, joint, &def, NULL);
}

/* A series of slides and a hinge or ball joint. */
static km_status copy_as_series(model_copy *c, int j, const km_joint_option *option) {
  const km_model_joint *joint = &c->m->model->joints[j];
  const double *value = c->values + joint->first_coordinate;
  km_frame_id from = c->frame[joint->frame[0]];
  km_status status = KM_OK;
  for (int k = 0; k < 3 && !status; ++k)
    if ((option->own | option->added) >> k & 1)
      status = add_series_slide(c, joint, k, option->own >> k & 1 ? *value++ : 0.0, &from);
  int turns = (option->own | option->added) >> 3;
  bool is_ball = km_motion_count(turns) > 1;
  km_joint_def def = km_joint_default();
  def.type = is_ball ? KM_SPHERICAL : (km_joint_type)(KM_RX + axis_of(turns));
  def.parent = from;
  def.child = c->frame[joint->frame[1]];
  if (option->own >> 3)
    def.position[is_ball ? axis_of(option->own >> 3) : 0] = *value;
  return status ? status : add_joint(c, joint, &def, NULL);
}

static km_status copy_changed(model_copy *c, int j, const km_joint_change *change) {
  km_joint_option option;
  if (!km_joint_option_find(&c->m->model->joints[j], change, &option))
    return km_fail(c->error, KM_USAGE, "joint %s can't become %.40s with these motions", c->m->model->joints[j].label,
                   change->to ? change->to : "nothing");
  km_joint_type type = option.is_type ? (km_joint_type)km_joint_type_find(option.to) : KM_RIGID;
  return type == KM_SPHERICAL ? copy_joint(c, j, true)
         : option.is_type     ? copy_as_type(c, j, type, &option)
                              : copy_as_series(c, j, &option);
}

static km_status copy_joints(model_copy *c) {
  km_status status = KM_OK;
  for (int j = 0; j < c->m->model->joint_count && !status; ++j) {
    const km_joint_change *change = find_change(c, j);
    status = change ? copy_changed(c, j, change) : copy_joint(c, j, false);
  }
  return status;
}

static km_coordinate_ref coordinate_of(const model_copy *c, int coordinate) {
  const km_model_coordinate *own = &c->m->model->coordinates[coordinate];
  return (km_coordinate_ref){c->joint[own->joint], own->index};
}

static km_status copy_couplings(const model_copy *c, km_arena *arena) {
  const km_model *model = c->m->model;
  km_status status = KM_OK;
  for (int i = 0; i < model->coupling_count && !status; ++i) {
    const km_model_coupling *own = &model->couplings[i];
    km_coordinate_ref *refs = KM_ARENA_NEW(arena, km_coordinate_ref, (size_t)own->count);
    if (!refs)
      return km_fail(c->error, KM_MEMORY, "out of memory for the changed model");
    for (int k = 0; k < own->count; ++k)
      refs[k] = coordinate_of(c, own->coordinates[k]);
    km_coupling_def def = {.name = own->name,
                           .count = own->count,
                           .coordinates = refs,
                           .ratios = own->ratios,
                           .constant_given = own->constant_given,
                           .constant = own->constant,
                           .polynomial_count = own->polynomial_count,
                           .polynomial = own->polynomial};
    status = km_model_add_coupling(c->builder, &def, c->error);
  }
  for (int i = 0; i < c->m->coordinate_count && !status; ++i)
    if (c->m->held[i])
      status = km_model_add_hold(c->builder, coordinate_of(c, i), c->values[i], c->error);
  return status;
}

static km_status copy_all(model_copy *c, km_arena *arena) {
  const km_model *model = c->m->model;
  c->frame = KM_ARENA_NEW(arena, km_frame_id, (size_t)model->frame_count);
  c->joint = KM_ARENA_NEW(arena, km_joint_id, (size_t)model->joint_count);
  if (arena->failed)
    return km_fail(c->error, KM_MEMORY, "out of memory for the changed model");
  km_status status = copy_settings(c);
  if (!status)
    status = copy_bodies(c);
  if (!status)
    status = copy_frames(c);
  if (!status)
    status = copy_joints(c);
  return status ? status : copy_couplings(c, arena);
}

km_status km_changed_model(const km_mechanism *m, const double *values, const km_remedy_set *set, km_model **out,
                           km_error *error) {
  km_arena arena = {0};
  model_copy c = {.m = m, .values = values, .set = set, .error = error};
  km_status status = km_builder_create(&c.builder, error);
  if (!status)
    status = copy_all(&c, &arena);
  if (!status)
    status = km_builder_finish(c.builder, out, error);
  km_builder_free(c.builder);
  km_arena_free(&arena);
  return status;
}
