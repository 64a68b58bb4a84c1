/* Numbers that calls have changed, put into the tree of the file that the model was read from. */
#include "exchange/json/write/write_edits.h"

#include "exchange/json/read/reader.h"

#include <string.h>

static const double no_limit = 1e30; /* JSON has no infinity */

typedef struct writer {
  const km_model *model;
  const km_units *units;
  bool drawn;
  km_arena *arena;
  km_value *root;
} writer;

km_model km_edits_undone(const km_model *model) {
  km_model out = *model;
  out.bodies = model->unedited->bodies;
  out.frames = model->unedited->frames;
  out.coordinates = model->unedited->coordinates;
  out.loads = model->unedited->loads;
  out.unedited = NULL;
  return out;
}

static bool frame_differs(const km_model *m, int frame) {
  return memcmp(&m->frames[frame].pose, &m->unedited->frames[frame].pose, sizeof(km_pose)) != 0;
}

static bool is_drawn(const km_model *m, int joint) {
  const km_value *source = m->origin->joints[joint];
  return source && km_joint_is_drawn(source);
}

/* The joint of a drawing that made a frame; -1: none did. */
static int drawn_joint(const km_model *m, int frame) {
  for (int j = 0; j < m->joint_count; ++j)
    if ((m->joints[j].frame[0] == frame || m->joints[j].frame[1] == frame) && is_drawn(m, j))
      return j;
  return -1;
}

bool km_edits_break_drawing(const km_model *m) {
  for (int f = 0; f < m->frame_count; ++f) {
    int joint = frame_differs(m, f) ? drawn_joint(m, f) : -1;
    if (joint < 0)
      continue;
    const km_pose *old[2], *new[2];
    for (int end = 0; end < 2; ++end) {
      old[end] = &m->unedited->frames[m->joints[joint].frame[end]].pose;
      new[end] = &m->frames[m->joints[joint].frame[end]].pose;
      if (memcmp(&old[end]->R, &new[end]->R, sizeof old[end]->R) != 0)
        return true;
    }
    km_vec3 one = km_vec3_sub(new[0]->p, old[0]->p), other = km_vec3_sub(new[1]->p, old[1]->p);
    double size = km_vec3_norm(new[0]->p) + km_vec3_norm(old[0]->p) + km_vec3_norm(one);
    if (km_vec3_norm(km_vec3_sub(one, other)) > 1e-12 * size) /* both go the same way in the drawing, to rounding */
      return true;
  }
  return false;
}

static double factor(const writer *w, km_dimension dimension) {
  return km_units_factor(&w->model->units, dimension) / km_units_factor(w->units, dimension);
}

/* The member of a list of objects with a name. */
static km_value *named(const km_value *list, const char *name) {
  for (km_value *v = list ? list->first : NULL; v; v = v->next) {
    const km_value *own = km_value_get(v, "name");
    if (own && own->string && strcmp(own->string, name) == 0)
      return v;
  }
  return NULL;
}

static km_value *assembly_object(const writer *w, int assembly) {
  if (assembly == KM_NO_ASSEMBLY)
    return w->root;
  const km_model_assembly *a = &w->model->assemblies[assembly];
  const km_value *around = assembly_object(w, a->parent);
  return around ? named(km_value_get(around, "assemblies"), a->name) : NULL;
}

static km_value *body_object(const writer *w, int body) {
  if (body == 0)
    return (km_value *)km_value_get(w->root, "fixed");
  const km_value *around = assembly_object(w, w->model->bodies[body].assembly);
  return around ? named(km_value_get(around, "bodies"), w->model->bodies[body].name) : NULL;
}

/* A strut bears its slide's name. */
static km_value *joint_object(const writer *w, int joint) {
  const char *name = w->model->joints[joint].name;
  const km_value *around = assembly_object(w, w->model->joints[joint].assembly);
  km_value *object = around ? named(km_value_get(around, "joints"), name) : NULL;
  return object || !around ? object : named(km_value_get(around, "struts"), name);
}

/* The member of that key as an empty list. */
static km_value *emptied(const writer *w, km_value *object, const char *key) {
  km_value *member = (km_value *)km_value_get(object, key);
  if (!member)
    return km_value_add(w->arena, object, key, KM_LIST);
  const km_value fresh = {.kind = KM_LIST, .key = member->key, .next = member->next};
  *member = fresh;
  return member;
}

static void write_numbers(const writer *w, km_value *object, const char *key, const double *values, int count,
                          double scale) {
  km_value *list = emptied(w, object, key);
  for (int k = 0; list && k < count; ++k)
    km_value_number(w->arena, list, NULL, scale * values[k]);
}

static void write_vector(const writer *w, km_value *object, const char *key, km_vec3 v, double scale) {
  write_numbers(w, object, key, (const double[3]){v.x, v.y, v.z}, 3, scale);
}

static void write_number(const writer *w, km_value *object, const char *key, double value) {
  km_value *member = (km_value *)km_value_get(object, key);
  if (!member)
    km_value_number(w->arena, object, key, value);
  else
    *member = (km_value){.kind = KM_NUMBER, .key = member->key, .number = value, .next = member->next};
}

static km_status cannot(const char *what, const char *name, km_error *error) {
  return km_fail(error, KM_USAGE, "%s of \"%.80s\" was changed, which a file can't say", what, name);
}

/* Removes keys of an orientation other than R. */
static void drop_orientations(km_value *object) {
  km_value *before = NULL;
  for (km_value *v = object->first; v; v = v->next) {
    if (!km_is_orientation(v->key) || strcmp(v->key, "R") == 0) {
      before = v;
      continue;
    }
    if (before)
      before->next = v->next;
    else
      object->first = v->next;
    object->count--;
  }
  object->last = before;
}

static km_status write_frame(const writer *w, int frame, km_error *error) {
  const km_model *m = w->model;
  const km_model_frame *f = &m->frames[frame];
  const char *body = m->bodies[f->body].name;
  const km_dimension length = {.length = 1};
  int joint = w->drawn ? drawn_joint(m, frame) : -1;
  if (strcmp(f->name, "origin") == 0)
    return cannot("the body's own frame", body, error);
  if (joint >= 0) { /* both of its frames are defined by one point */
    km_value *object = joint_object(w, joint);
    if (object && m->joints[joint].frame[0] == frame)
      write_vector(w, object, "at", f->pose.p, factor(w, length));
    return KM_OK;
  }
  const km_value *owner = body_object(w, f->body);
  km_value *object = owner ? named(km_value_get(owner, "frames"), f->name) : NULL;
  if (!object)
    return km_fail(error, KM_USAGE, "frame \"%.60s\" of \"%.60s\" was changed, which is a strut's: a file can't say it",
                   f->name, body);
  write_vector(w, object, "T", f->pose.p, factor(w, length));
  double rows[9];
  km_rotation_rows(&f->pose.R, rows);
  if (memcmp(&f->pose.R, &m->unedited->frames[frame].pose.R, sizeof f->pose.R) == 0)
    return KM_OK;
  drop_orientations(object);
  km_value *R = emptied(w, object, "R");
  for (int i = 0; i < 3; ++i)
    km_value_numbers(w->arena, R, NULL, &rows[3 * i], 3);
  return KM_OK;
}

static bool is_weighed(const km_model *m, int body) {
  bool weighed = m->bodies[body].density > 0.0;
  for (int s = 0; s < m->shape_count; ++s)
    weighed = weighed || (m->shapes[s].body == body && m->shapes[s].density > 0.0);
  return weighed;
}

static km_status write_mass(const writer *w, int body, km_error *error) {
  static const char *const keys[6] = {"Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Izx"};
  const km_model_body *b = &w->model->bodies[body], *old = &w->model->unedited->bodies[body];
  km_value *object = body_object(w, body);
  if (!object || is_weighed(w->model, body))
    return cannot("the mass", b->name, error);
  write_number(w, object, "mass", factor(w, (km_dimension){.mass = 1}) * b->mass);
  if (memcmp(&b->center_of_mass, &old->center_of_mass, sizeof b->center_of_mass) != 0)
    write_vector(w, object, "center_of_mass", b->center_of_mass, factor(w, (km_dimension){.length = 1}));
  if (memcmp(b->inertia, old->inertia, sizeof b->inertia) == 0)
    return KM_OK;
  km_value *inertia = (km_value *)km_value_get(object, "moment_of_inertia");
  inertia = inertia ? inertia : km_value_add(w->arena, object, "moment_of_inertia", KM_OBJECT);
  for (int k = 0; k < 6 && inertia; ++k)
    write_number(w, inertia, keys[k], factor(w, (km_dimension){.mass = 1, .length = 2}) * b->inertia[k]);
  return KM_OK;
}

/* The limits of all coordinates of a joint. */
static km_status write_limits(const writer *w, int joint, km_error *error) {
  const km_model_joint *def = &w->model->joints[joint];
  const km_model_coordinate *c = &w->model->coordinates[def->first_coordinate];
  int count = km_model_freedom(w->model, joint);
  km_value *object = joint_object(w, joint), *list = object ? emptied(w, object, "limits") : NULL;
  if (!list)
    return w->arena->failed ? KM_OK : cannot("a limit", def->label, error);
  for (int k = 0; k < count; ++k) {
    double scale = factor(w, km_joint_dimension(def->type, k));
    const double range[2] = {fmax(scale * c[k].low, -no_limit), fmin(scale * c[k].high, no_limit)};
    km_value *to = count > 1 ? km_value_add(w->arena, list, NULL, KM_LIST) : list;
    for (int i = 0; i < 2; ++i)
      km_value_number(w->arena, to, NULL, range[i]);
  }
  return KM_OK;
}

static bool limits_differ(const km_model *m, int joint) {
  bool differ = false;
  for (int k = 0; k < km_model_freedom(m, joint); ++k) {
    const km_model_coordinate *c = &m->coordinates[m->joints[joint].first_coordinate + k];
    const km_model_coordinate *old = &m->unedited->coordinates[m->joints[joint].first_coordinate + k];
    differ = differ || c->low != old->low || c->high != old->high;
  }
  return differ;
}

static void write_load(const writer *w, int load) {
  const km_applied_load *l = &w->model->loads[load];
  const km_value *list = km_value_get(km_value_get(w->root, "analysis"), "loads");
  km_value *object = l->name && l->name[0] ? named(list, l->name) : NULL;
  km_value *nth = list ? list->first : NULL;
  for (int i = 0; i < load && nth; ++i)
    nth = nth->next;
  object = object ? object : nth;
  if (!object)
    return;
  write_vector(w, object, "force", l->force, factor(w, (km_dimension){.force = 1}));
  write_vector(w, object, "torque", l->torque, factor(w, (km_dimension){.force = 1, .length = 1}));
}

km_status km_edits_write(const km_model *m, const km_units *units, bool drawn, km_arena *arena, km_value *root,
                         km_error *error) {
  const writer w = {m, units, drawn, arena, root};
  km_status status = KM_OK;
  for (int f = 0; f < m->frame_count && !status; ++f)
    if (frame_differs(m, f))
      status = write_frame(&w, f, error);
  for (int b = 1; b < m->body_count && !status; ++b) {
    const km_model_body *one = &m->bodies[b], *old = &m->unedited->bodies[b];
    if (one->mass != old->mass || memcmp(&one->center_of_mass, &old->center_of_mass, sizeof one->center_of_mass) != 0 ||
        memcmp(one->inertia, old->inertia, sizeof one->inertia) != 0)
      status = write_mass(&w, b, error);
  }
  for (int j = 0; j < m->joint_count && !status; ++j)
    if (limits_differ(m, j))
      status = write_limits(&w, j, error);
  for (int l = 0; l < m->load_count; ++l)
    if (memcmp(&m->loads[l], &m->unedited->loads[l], sizeof m->loads[l]) != 0)
      write_load(&w, l);
  if (!status && arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory while converting the model");
  return status;
}
