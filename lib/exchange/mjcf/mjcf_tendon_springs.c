/* Springs and dampers of tendons.
 *
 *   L = c + f x              length of the tendon; x: a joint's coordinate, or the distance of two sites
 *   F = k (a - L), L < a     force along L (MuJoCo: springlength a b, a dead band between a and b)
 *     = k (b - L), L > b
 *   F = - d dL/dt            damper
 *
 * The force along x is f F. A fixed tendon over several joints is the slide of a massless body, coupled to them. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

/* An attribute of a tendon, whose kinds share their defaults. */
static const char *get(km_mjcf *m, const km_xml *tendon, const char *key) {
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  km_xml e = *tendon;
  e.name = "tendon";
  return km_mjcf_get(m, &e, &place, key);
}

static double number(km_mjcf *m, const km_xml *tendon, const char *key) {
  double value = 0.0;
  km_robot_parse(m->robot, tendon, key, get(m, tendon, key), &value, 1);
  return value;
}

bool km_mjcf_is_spring(km_mjcf *m, const km_xml *tendon) {
  return number(m, tendon, "stiffness") != 0.0 || number(m, tendon, "damping") != 0.0;
}

/* Terms of a tendon's length. */
typedef struct length {
  double constant, factor, at_rest; /* c, f; L in the configuration of the file */
  km_coordinate_ref coordinate;     /* x, or the distance of */
  km_frame_id ends[2];
} length;

static const char *name_of(km_mjcf *m, const km_xml *tendon) {
  const char *name = km_xml_attribute_of(tendon, "name");
  return km_mjcf_full(m, name && name[0] ? name : "tendon");
}

static void add_force(km_mjcf *m, const km_xml *tendon, const km_force_def *def) {
  km_error error;
  km_status status = km_model_add_force(m->robot->builder, def, &error);
  if (status)
    km_robot_builder_failed(m->robot, tendon, status, &error);
}

/* The ends a and b of the dead band. */
static void find_rest(km_mjcf *m, const km_xml *tendon, const length *l, double rest[2]) {
  rest[0] = rest[1] = -1.0;
  const char *text = get(m, tendon, "springlength");
  if (text && km_robot_parse_some(m->robot, tendon, "springlength", text, rest, 1, 2) == 1)
    rest[1] = rest[0];
  if (rest[0] == -1.0)
    rest[0] = rest[1] = l->at_rest;
  if (rest[0] > rest[1])
    km_robot_error(m->robot, tendon, "springlength: found %g %g; expected a range", rest[0], rest[1]);
}

static void add_spring(km_mjcf *m, const km_xml *tendon, const length *l) {
  double k = number(m, tendon, "stiffness"), d = number(m, tendon, "damping"), f = l->factor, rest[2];
  km_force_def def = km_force_default();
  find_rest(m, tendon, l, rest);
  def.coordinate = l->coordinate;
  def.from = l->ends[0];
  def.to = l->ends[1];
  if (k != 0.0 && f != 0.0) {
    double a = rest[0] - l->constant, b = rest[1] - l->constant;
    int near = f > 0.0 ? 0 : 1; /* a negative factor maps small x to large lengths */
    const double ends[2] = {near ? b : a, near ? a : b};
    const double knots[2] = {ends[0] / f, ends[1] / f};
    const double band[5] = {f * k * ends[0], -f * f * k, 0.0, f * k * ends[1], -f * f * k};
    const int sizes[3] = {2, 1, 2};
    bool dead = rest[0] < rest[1];
    def.name = name_of(m, tendon);
    def.type = KM_MODULE_STIFFNESS;
    def.knot_count = dead ? 2 : 0;
    def.knots = knots;
    def.piece_sizes = sizes;
    def.coefficients = band;
    add_force(m, tendon, &def);
  }
  if (d != 0.0 && f != 0.0) {
    const double piece[2] = {0.0, -f * f * d};
    const int size = 2;
    def.name = km_robot_text(m->robot, "%s:damping", name_of(m, tendon));
    def.type = KM_MODULE_DAMPING;
    def.knot_count = 0;
    def.piece_sizes = &size;
    def.coefficients = piece;
    add_force(m, tendon, &def);
  }
}

/* A slide whose coordinate is the length of a tendon over several joints. */
static km_coordinate_ref add_slide(km_mjcf *m, const km_xml *tendon, const km_mjcf_sum *s) {
  km_robot *robot = m->robot;
  km_coordinate_ref *refs = KM_ARENA_NEW(&robot->arena, km_coordinate_ref, (size_t)s->count + 1);
  double *ratios = KM_ARENA_NEW(&robot->arena, double, (size_t)s->count + 1);
  km_robot_joint joint = km_robot_joint_default();
  km_error error;
  if (!refs || !ratios)
    return (km_coordinate_ref){0};
  joint.at = tendon;
  joint.assembly = m->assembly;
  joint.name = km_robot_free_name(robot, &robot->joints, m->assembly.value, name_of(m, tendon), "tendon");
  joint.type = KM_TZ;
  joint.parent = km_builder_fixed(robot->builder);
  joint.child = km_robot_body(
      robot, tendon, m->assembly,
      km_robot_free_name(robot, &robot->bodies, m->assembly.value, name_of(m, tendon), "tendon"), NULL, NULL);
  for (int k = 0; k < s->count; ++k) {
    refs[k] = (km_coordinate_ref){m->joints[s->joints[k]].id, 0};
    ratios[k] = s->ratios[k];
    joint.position[0] += s->ratios[k] * m->joints[s->joints[k]].reference;
  }
  refs[s->count] = (km_coordinate_ref){km_robot_add_joint(robot, &joint), 0};
  ratios[s->count] = -1.0;
  km_coupling_def def = {.name = joint.name,
                         .assembly = m->assembly,
                         .count = s->count + 1,
                         .coordinates = refs,
                         .ratios = ratios,
                         .constant_given = true};
  km_status status = robot->failed ? KM_OK : km_model_add_coupling(robot->builder, &def, &error);
  if (status)
    km_robot_builder_failed(robot, tendon, status, &error);
  return refs[s->count];
}

static void read_fixed(km_mjcf *m, const km_xml *tendon) {
  km_mjcf_sum *s = KM_ARENA_NEW(&m->robot->arena, km_mjcf_sum, 1);
  length l = {.factor = 1.0};
  if (!s || !km_mjcf_add_length(m, tendon, 1.0, s) || s->count == 0)
    return;
  for (int k = 0; k < s->count; ++k)
    l.at_rest += s->ratios[k] * m->joints[s->joints[k]].reference;
  if (s->count == 1) {
    l.factor = s->ratios[0];
    l.coordinate = (km_coordinate_ref){m->joints[s->joints[0]].id, 0};
  } else {
    l.coordinate = add_slide(m, tendon, s);
  }
  if (!m->robot->failed)
    add_spring(m, tendon, &l);
}

/* A piece of a spatial tendon between two sites, whose length counts by one over the divisor of its pulley. */
static bool add_piece(km_mjcf *m, int one, int two, double divisor, length *l) {
  const km_mjcf_site *a = &m->sites[one], *b = &m->sites[two];
  km_vec3 p = km_pose_point(&m->bodies[a->body].world, a->pose.p),
          q = km_pose_point(&m->bodies[b->body].world, b->pose.p);
  double now = km_vec3_norm(km_vec3_sub(q, p)) / divisor;
  bool same = l->ends[0].value == a->frame.value && l->ends[1].value == b->frame.value;
  same = same || (l->ends[0].value == b->frame.value && l->ends[1].value == a->frame.value);
  l->at_rest += now;
  if (a->body == b->body) {
    l->constant += now;
    return true;
  }
  if (l->ends[0].value && !same)
    return false;
  l->ends[0] = a->frame;
  l->ends[1] = b->frame;
  l->factor += 1.0 / divisor;
  return true;
}

static bool read_path(km_mjcf *m, const km_xml *tendon, length *l) {
  double divisor = 1.0;
  int last = -1;
  for (const km_xml *e = tendon->first; e; e = e->next) {
    if (strcmp(e->name, "pulley") == 0) {
      divisor = km_robot_number(m->robot, e, "divisor", 1.0);
      last = -1;
    } else if (strcmp(e->name, "site") == 0) {
      int site = km_mjcf_find(m, e, "site", &m->site_names, "site");
      if (site < 0 || (last >= 0 && !add_piece(m, last, site, divisor, l)))
        return false;
      last = site;
    } else {
      return false;
    }
  }
  return l->ends[0].value != 0;
}

static void read_spatial(km_mjcf *m, const km_xml *tendon) {
  length l = {0};
  if (read_path(m, tendon, &l))
    add_spring(m, tendon, &l);
  else if (!m->robot->failed)
    km_robot_warn(
        m->robot, tendon,
        "the spring of the tendon \"%.80s\" is left out, and no force stands for it: it runs around geoms, or "
        "along several pieces that change their length; expected one such piece, between two sites",
        name_of(m, tendon));
}

/* True if all elements on the path of an attached model's tendon are present. */
static bool is_here(const km_mjcf *m, const km_xml *tendon) {
  for (const km_xml *e = tendon->first; e && m->depth > 0; e = e->next)
    if (!km_mjcf_is_here(m, e))
      return false;
  return true;
}

void km_mjcf_read_tendon_springs(km_mjcf *m) {
  static const char *const others[] = {"range", "frictionloss", "armature"};
  for (const km_xml *list = km_xml_child(m->root, "tendon"); list; list = km_xml_next(list))
    for (const km_xml *e = list->first; e && !m->robot->failed; e = e->next) {
      if (!is_here(m, e) || !km_mjcf_is_spring(m, e))
        continue;
      for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
        if (get(m, e, others[i]))
          km_robot_omit(m->robot, "limits, friction and rotors of tendons with springs left out", name_of(m, e));
      if (strcmp(e->name, "fixed") == 0)
        read_fixed(m, e);
      else if (strcmp(e->name, "spatial") == 0)
        read_spatial(m, e);
    }
}
