/* Attributes with their defaults by classes, the compiler's settings, and poses. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static bool is_true(const char *text) {
  return text && strcmp(text, "true") == 0;
}

static void read_settings(km_mjcf *m, const km_xml *e) {
  km_mjcf_compiler *c = &m->compiler;
  const char *angle = km_xml_attribute_of(e, "angle"), *order = km_xml_attribute_of(e, "eulerseq");
  const char *limits = km_xml_attribute_of(e, "autolimits"), *from = km_xml_attribute_of(e, "inertiafromgeom");
  const char *coordinate = km_xml_attribute_of(e, "coordinate");
  static const char *const folders[] = {"meshdir", "assetdir"};
  for (int k = 1; k >= 0; --k)
    if (km_xml_attribute_of(e, folders[k]) && km_xml_attribute_of(e, folders[k])[0])
      c->meshes = km_xml_attribute_of(e, folders[k]);
  if (angle)
    c->angle = strcmp(angle, "radian") == 0 ? 1.0 : M_PI / 180.0;
  if (order && (strlen(order) != 3 || strspn(order, "xyzXYZ") != 3))
    km_robot_error(m->robot, e, "eulerseq: found \"%.20s\"; expected three of x y z X Y Z", order);
  else if (order)
    memcpy(c->order, order, 3);
  if (limits)
    c->autolimits = is_true(limits);
  if (km_xml_attribute_of(e, "exactmeshinertia"))
    c->exact_meshes = is_true(km_xml_attribute_of(e, "exactmeshinertia"));
  if (from)
    c->from_geoms = is_true(from) ? KM_MJCF_YES : strcmp(from, "false") == 0 ? KM_MJCF_NO : KM_MJCF_AUTO;
  if (coordinate && strcmp(coordinate, "global") == 0)
    km_robot_error(
        m->robot, e,
        "coordinate: found \"global\"; expected coordinates in the frame around each element, as MuJoCo 2.3.3 saves such a model");
  km_robot_numbers(m->robot, e, "inertiagrouprange", c->groups, 2);
  c->least_mass = km_robot_number(m->robot, e, "boundmass", c->least_mass);
  c->least_inertia = km_robot_number(m->robot, e, "boundinertia", c->least_inertia);
  if (km_xml_attribute_of(e, "balanceinertia"))
    c->balances = is_true(km_xml_attribute_of(e, "balanceinertia"));
  m->robot->total_mass = km_robot_number(m->robot, e, "settotalmass", m->robot->total_mass);
}

void km_mjcf_read_compiler(km_mjcf *m) {
  m->compiler = (km_mjcf_compiler){.angle = M_PI / 180.0,
                                   .order = {'x', 'y', 'z'},
                                   .autolimits = true,
                                   .from_geoms = KM_MJCF_AUTO,
                                   .groups = {0, 5}};
  for (const km_xml *e = km_xml_child(m->root, "compiler"); e; e = km_xml_next(e))
    read_settings(m, e);
}

static void read_class(km_mjcf *m, const km_xml *e, int parent) {
  km_robot *robot = m->robot;
  const char *own = km_xml_attribute_of(e, "class"), *name = parent < 0 ? "main" : own ? own : "";
  if (!name[0])
    km_robot_error(robot, e, "a nested class of defaults without a name; expected class=\"…\"");
  if (!km_arena_grow(&robot->arena, (void **)&m->classes, &m->class_room, (size_t)m->class_count + 1,
                     sizeof *m->classes))
    return;
  int first = km_names_get(&m->class_names, 0, name), index = m->class_count++;
  m->classes[index] = (km_mjcf_class){e, -1, parent};
  if (first >= 0) {
    while (m->classes[first].next >= 0)
      first = m->classes[first].next;
    m->classes[first].next = index;
  } else if (!km_names_set(&m->class_names, 0, name, index)) {
    robot->arena.failed = true;
  }
  if (parent < 0 && own && strcmp(own, "main") != 0 && !km_names_set(&m->class_names, 0, own, index))
    robot->arena.failed = true;
  for (const km_xml *d = km_xml_child(e, "default"); d; d = km_xml_next(d))
    read_class(m, d, km_names_get(&m->class_names, 0, name));
}

void km_mjcf_read_classes(km_mjcf *m) {
  for (const km_xml *e = km_xml_child(m->root, "default"); e; e = km_xml_next(e))
    read_class(m, e, -1);
}

/* Defaults of a class for elements of a name; NULL: none. */
static const char *class_says(const km_mjcf *m, int index, const char *element, const char *key) {
  const char *found = NULL;
  for (int i = index; i >= 0; i = m->classes[i].next) {
    const char *value = km_xml_attribute_of(km_xml_child(m->classes[i].element, element), key);
    found = value ? value : found;
  }
  return found;
}

/* An unknown class is reported once, at the first element that names it. */
static int find_class(km_mjcf *m, const km_xml *element, const char *class) {
  int index = km_names_get(&m->class_names, 0, class ? class : "main");
  if (index >= 0 || !class || km_names_get(&m->missing_classes, 0, class) >= 0)
    return index;
  km_robot_error(m->robot, element, "the class \"%.80s\" isn't there; expected one of the defaults", class);
  if (!km_names_set(&m->missing_classes, 0, class, 0))
    m->robot->arena.failed = true;
  return index;
}

const char *km_mjcf_class_inside(km_mjcf *m, const km_xml *element, const char *around) {
  const char *class = km_xml_attribute_of(element, "childclass");
  if (!class)
    return around;
  find_class(m, element, class);
  return class;
}

const char *km_mjcf_get(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key) {
  const char *own = km_xml_attribute_of(element, key), *class = km_xml_attribute_of(element, "class");
  if (own)
    return own;
  for (int index = find_class(m, element, class ? class : place->class); index >= 0; index = m->classes[index].parent) {
    own = class_says(m, index, element->name, key);
    if (own)
      return own;
  }
  return NULL;
}

int km_mjcf_numbers(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key, double *out,
                    int most) {
  int count = km_robot_parse_some(m->robot, element, key, km_mjcf_get(m, element, place, key), out, 1, most);
  return count < 0 ? 0 : count;
}

double km_mjcf_number(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key,
                      double otherwise) {
  double value = otherwise;
  km_mjcf_numbers(m, element, place, key, &value, 1);
  return value;
}

km_vec3 km_mjcf_unit(km_robot *robot, const km_xml *at, const char *what, const double u[3]) {
  double length = km_vec3_norm(km_vec3_from_array(u));
  if (length > 0.0)
    return km_vec3_scale(1.0 / length, km_vec3_from_array(u));
  km_robot_error(robot, at, "%s: found 0 0 0; expected a direction", what);
  return (km_vec3){0, 0, 1};
}

static km_rotation euler(const km_mjcf_compiler *c, const double angles[3]) {
  km_quaternion q = {1, 0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    char letter = c->order[k];
    bool intrinsic = letter >= 'x';
    double turn[3] = {0};
    turn[letter - (intrinsic ? 'x' : 'X')] = angles[k] * c->angle;
    km_quaternion step = km_quaternion_exp(km_vec3_from_array(turn));
    q = intrinsic ? km_quaternion_product(q, step) : km_quaternion_product(step, q);
  }
  return km_quaternion_rotation(q);
}

static km_rotation from_axes(km_mjcf *m, const km_xml *e, const double v[6]) {
  km_vec3 x = km_mjcf_unit(m->robot, e, "xyaxes", v), y = km_vec3_from_array(v + 3);
  y = km_vec3_axpy(-km_vec3_dot(x, y), x, y);
  const double across[3] = {y.x, y.y, y.z};
  y = km_mjcf_unit(m->robot, e, "xyaxes", across);
  return (km_rotation){{x, y, km_vec3_cross(x, y)}};
}

/* The text of an attribute that turns axes counts for how the file is rounded. */
static bool given(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, const char *key, double *v, int count,
                  double period, km_robot_digits *rounding) {
  const char *text = km_mjcf_get(m, e, place, key);
  if (!text || !km_robot_parse(m->robot, e, key, text, v, count))
    return false;
  if (rounding)
    km_robot_judge_digits(text, period, rounding);
  return true;
}

static km_rotation read_rotation(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  bool of_joints = strcmp(e->name, "inertial") != 0 && strcmp(e->name, "geom") != 0;
  km_robot_digits *worst = of_joints ? &m->robot->angles : NULL;
  double v[6], step = M_PI / 12.0 / m->compiler.angle;
  if (given(m, e, place, "quat", v, 4, 0.0, worst)) {
    if (v[0] != 0.0 || v[1] != 0.0 || v[2] != 0.0 || v[3] != 0.0)
      return km_quaternion_rotation(km_quaternion_normalised((km_quaternion){v[0], v[1], v[2], v[3]}));
    km_robot_error(m->robot, e, "quat: found 0 0 0 0; expected a quaternion");
  }
  if (given(m, e, place, "axisangle", v, 4, step, worst))
    return km_quaternion_rotation(
        km_quaternion_exp(km_vec3_scale(v[3] * m->compiler.angle, km_mjcf_unit(m->robot, e, "axisangle", v))));
  if (given(m, e, place, "xyaxes", v, 6, 0.0, worst))
    return from_axes(m, e, v);
  if (given(m, e, place, "zaxis", v, 3, 0.0, worst))
    return km_rotation_onto(2, km_mjcf_unit(m->robot, e, "zaxis", v));
  if (given(m, e, place, "euler", v, 3, step, worst))
    return euler(&m->compiler, v);
  return km_rotation_identity();
}

km_pose km_mjcf_pose(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  double p[3] = {0};
  given(m, e, place, "pos", p, 3, 0.0, NULL);
  return (km_pose){read_rotation(m, e, place), km_vec3_from_array(p)};
}
