/* Models by calls: joints and couplings. */
#include "model/builder.h"

#include <stdio.h>

/* Copies drive and friction of coordinate k. */
static km_status check_drive(const km_joint_def *def, const char *name, size_t k, km_error *error) {
  if (!(def->max_rate[k] > 0.0) || !(def->max_force[k] > 0.0))
    return km_fail(error, KM_MODEL,
                   "joint \"%.80s\": found a largest rate of %g and force of %g; expected both above 0", name,
                   def->max_rate[k], def->max_force[k]);
  if (!km_builder_sane(&def->armature[k], 1) || !km_builder_sane(&def->constant_friction[k], 1) ||
      def->armature[k] < 0.0 || def->constant_friction[k] < 0.0)
    return km_fail(error, KM_MODEL,
                   "joint \"%.80s\": found an armature of %g and a constant friction of %g; expected at least 0", name,
                   def->armature[k], def->constant_friction[k]);
  return KM_OK;
}

static km_status check_joint(const km_joint_def *def, const char *name, int freedom, km_error *error) {
  size_t n = (size_t)freedom;
  const double scalars[6] = {def->pitch,          def->friction,    def->friction_radius, def->stiction_velocity,
                             def->stop_stiffness, def->stop_damping};
  if (!km_builder_sane(def->position, n) || !km_builder_sane(def->velocity, n) || !km_builder_sane(def->damping, n) ||
      !km_builder_sane(scalars, 6))
    return km_fail(error, KM_MODEL,
                   "joint \"%.80s\": found a number that is not finite; expected magnitudes up to 1e60", name);
  for (int k = 1; k < 6; ++k)
    if (scalars[k] < 0.0)
      return km_fail(error, KM_MODEL, "joint \"%.80s\": found a friction or stop of %g; expected at least 0", name,
                     scalars[k]);
  for (size_t k = 0; k < n; ++k)
    if (!(def->low[k] <= def->high[k]))
      return km_fail(error, KM_MODEL, "joint \"%.80s\": found limits [%g, %g]; expected low ≤ high", name, def->low[k],
                     def->high[k]);
  if (!(def->most_turn >= 0.0 && def->most_turn <= 1e60) || (def->type != KM_SPHERICAL && def->most_turn != 0.0))
    return km_fail(error, KM_MODEL,
                   "joint \"%.80s\": found %g as the largest turn; expected an angle, and it only on a spherical joint",
                   name, def->most_turn);
  for (size_t k = 0; k < n; ++k)
    if (check_drive(def, name, k, error))
      return KM_MODEL;
  if (def->type != KM_SCREW && def->pitch != 0.0)
    return km_fail(error, KM_MODEL, "joint \"%.80s\": found a pitch; expected it only on a screw", name);
  bool law = def->law > KM_MOTION_FREE && def->law <= KM_MOTION_SINE;
  if ((law && (!def->law_values || def->law_count < (def->law == KM_MOTION_TABLE ? 2 : 1))) ||
      (!law && def->law != KM_MOTION_FREE))
    return km_fail(error, KM_MODEL, "joint \"%.80s\": the prescribed motion is not complete", name);
  if (law && freedom != 1)
    return km_fail(error, KM_MODEL, "joint \"%.80s\": a prescribed motion of %d coordinates; expected a joint with one",
                   name, freedom);
  for (int i = 1; def->law == KM_MOTION_TABLE && i < def->law_count; ++i)
    if (!(def->law_values[2 * i] > def->law_values[2 * i - 2]))
      return km_fail(error, KM_MODEL, "joint \"%.80s\": time %g doesn't come after the last one", name,
                     def->law_values[2 * i]);
  return KM_OK;
}

static size_t law_size(const km_joint_def *def) {
  switch (def->law) {
  case KM_MOTION_TABLE:
    return 2 * (size_t)def->law_count;
  case KM_MOTION_POLYNOMIAL:
    return (size_t)def->law_count;
  case KM_MOTION_SINE:
    return 4;
  default:
    return 0;
  }
}

static bool grow_coordinates(km_builder *b, int freedom) {
  km_model *m = b->model;
  return km_arena_grow(&m->arena, (void **)&m->coordinates, &b->coordinate_room,
                       (size_t)m->coordinate_count + (size_t)freedom, sizeof *m->coordinates);
}

static void add_coordinates(km_model *m, const km_joint_def *def, int joint) {
  bool stated = false;
  for (int k = 0; k < km_model_freedom(m, joint); ++k)
    stated = stated || def->velocity[k] != 0.0;
  for (int k = 0; k < km_model_freedom(m, joint); ++k)
    m->coordinates[m->coordinate_count++] = (km_model_coordinate){.joint = joint,
                                                                  .index = k,
                                                                  .position = def->position[k],
                                                                  .rate = def->velocity[k],
                                                                  .rate_stated = stated,
                                                                  .low = def->low[k],
                                                                  .high = def->high[k],
                                                                  .damping = def->damping[k],
                                                                  .max_rate = def->max_rate[k],
                                                                  .max_force = def->max_force[k],
                                                                  .armature = def->armature[k],
                                                                  .friction = def->constant_friction[k]};
}

static km_status find_ends(const km_builder *b, const km_joint_def *def, const char *name, int frame[2],
                           km_error *error) {
  char who[120];
  snprintf(who, sizeof who, "joint \"%.80s\"", name);
  if (!km_builder_frame(b, def->parent, who, &frame[0], error) ||
      !km_builder_frame(b, def->child, who, &frame[1], error))
    return KM_MODEL;
  int body = b->model->frames[frame[0]].body;
  if (body == b->model->frames[frame[1]].body)
    return km_fail(error, KM_MODEL, "%s: both ends are on \"%.80s\"; expected two different bodies", who,
                   b->model->bodies[body].name);
  return KM_OK;
}

km_status km_model_add_joint(km_builder *b, const km_joint_def *def, km_joint_id *out, km_error *error) {
  const char *name;
  int assembly, frame[2];
  if (!b || !b->model || !def || def->type < 0 || def->type >= KM_JOINT_TYPES)
    return km_fail(error, KM_MODEL, "joint \"%.80s\": found no builder, or a type that isn't one",
                   def && def->name ? def->name : "");
  km_status status = km_builder_assembly(b, def->assembly, &assembly, error);
  if (!status)
    status = km_builder_name(b, "joint", def->name, &b->joints, assembly, NULL, &name, error);
  if (!status)
    status = find_ends(b, def, name, frame, error);
  int freedom = km_joint_kind_of(def->type)->freedom;
  if (!status)
    status = check_joint(def, name, freedom, error);
  if (status)
    return status;
  km_model *m = b->model;
  double *values = km_builder_numbers(b, def->law_values, law_size(def));
  if (!KM_BUILDER_GROW(b, joints, joint_room, joint_count) || !grow_coordinates(b, freedom) ||
      !km_names_set(&b->joints, assembly, name, m->joint_count) || m->arena.failed)
    return km_builder_memory(error);
  m->joints[m->joint_count] =
      (km_model_joint){.name = name,
                       .type = def->type,
                       .assembly = assembly,
                       .frame = {frame[0], frame[1]},
                       .first_coordinate = m->coordinate_count,
                       .pitch = def->pitch,
                       .most_turn = def->most_turn,
                       .friction = {def->friction, def->friction_radius, def->stiction_velocity},
                       .stop = {def->stop_stiffness, def->stop_damping},
                       .prescribed = {.law = def->law, .count = def->law_count, .values = values},
                       .where = name};
  add_coordinates(m, def, m->joint_count);
  m->joint_count++;
  if (out)
    out->value = m->joint_count;
  return KM_OK;
}

/* Collects the coordinates of a coupling in `list`. */
static km_status find_coupled(const km_builder *b, const km_coupling_def *def, const char *who, int *list,
                              km_error *error) {
  bool some = def->polynomial_count > 0;
  for (int k = 0; k < def->count; ++k) {
    if (!km_builder_coordinate(b, def->coordinates[k], who, &list[k], error))
      return KM_MODEL;
    if (km_model_turns(b->model, list[k]))
      return km_fail(error, KM_MODEL, "%s: found a component of a rotation vector; expected a coordinate of its own",
                     who);
    for (int i = 0; i < k; ++i)
      if (list[i] == list[k])
        return km_fail(error, KM_MODEL, "%s: names a coordinate twice; expected each once", who);
    some = some || (def->ratios && def->ratios[k] != 0.0);
  }
  return some ? KM_OK : km_fail(error, KM_MODEL, "%s: every ratio is 0; expected at least one that isn't", who);
}

/* Checks that a coupling has either ratios, or two coordinates and a polynomial. */
static bool is_law(const km_coupling_def *def) {
  if (def->polynomial_count > 0)
    return def->count == 2 && !def->ratios && !def->constant_given && def->polynomial &&
           km_builder_sane(def->polynomial, (size_t)def->polynomial_count);
  return def->polynomial_count == 0 && def->ratios && km_builder_sane(def->ratios, (size_t)def->count) &&
         km_builder_sane(&def->constant, 1);
}

km_status km_model_add_coupling(km_builder *b, const km_coupling_def *def, km_error *error) {
  const char *name;
  char who[120];
  if (!b || !b->model || !def || def->count < 1 || !def->coordinates || !is_law(def))
    return km_fail(error, KM_MODEL,
                   "coupling \"%.80s\": expected one or more coordinates, each with a finite ratio, or two and a "
                   "polynomial",
                   def && def->name ? def->name : "");
  km_status status = km_builder_name(b, "coupling", def->name, NULL, 0, NULL, &name, error);
  if (status)
    return status;
  snprintf(who, sizeof who, "coupling \"%.80s\"", name);
  km_model *m = b->model;
  int *list = KM_ARENA_NEW(&m->arena, int, (size_t)def->count);
  double *ratios = km_builder_numbers(b, def->ratios, def->ratios ? (size_t)def->count : 0);
  double *polynomial = km_builder_numbers(b, def->polynomial, (size_t)def->polynomial_count);
  if (!list || m->arena.failed || !KM_BUILDER_GROW(b, couplings, coupling_room, coupling_count))
    return km_builder_memory(error);
  status = find_coupled(b, def, who, list, error);
  if (!status)
    m->couplings[m->coupling_count++] = (km_model_coupling){.name = name,
                                                            .where = name,
                                                            .count = def->count,
                                                            .coordinates = list,
                                                            .ratios = ratios,
                                                            .constant_given = def->constant_given,
                                                            .constant = def->constant,
                                                            .polynomial_count = def->polynomial_count,
                                                            .polynomial = polynomial};
  return status;
}
