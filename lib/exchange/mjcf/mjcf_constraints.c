/* Equality constraints: loop closures and couplings. */
#include "exchange/mjcf/mjcf.h"

#include "base/similar_names.h"

#include <string.h>

static bool is_active(const km_xml *e) {
  const char *active = km_xml_attribute_of(e, "active");
  return !active || strcmp(active, "false") != 0;
}

static bool read_polynomial(km_robot *robot, const km_xml *e, double c[5]) {
  const char *text = km_xml_attribute_of(e, "polycoef");
  memset(c, 0, 5 * sizeof *c);
  c[1] = 1.0;
  return !text || km_robot_parse_some(robot, e, "polycoef", text, c, 1, 5) > 0;
}

double km_mjcf_start_offset(const km_mjcf *m, const char *joint) {
  double c[5];
  for (const km_xml *list = km_xml_child(m->root, "equality"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "joint"); e; e = km_xml_next(e)) {
      const char *one = km_xml_attribute_of(e, "joint1");
      if (one && strcmp(km_mjcf_full(m, one), joint) == 0 && is_active(e) && read_polynomial(m->robot, e, c))
        return c[0];
    }
  return 0.0;
}

int km_mjcf_find(km_mjcf *m, const km_xml *e, const char *key, const km_names *names, const char *kind) {
  const char *name = km_xml_attribute_of(e, key);
  int index = name ? km_names_get(names, 0, km_mjcf_full(m, name)) : -1;
  if (index >= 0)
    return index;
  km_nearest nearest = {.wanted = name ? name : ""};
  char text[KM_NEAREST_TEXT];
  for (size_t i = 0; i < names->capacity; ++i)
    if (names->entries[i].name)
      km_nearest_add(&nearest, names->entries[i].name);
  km_robot_error(m->robot, e, "%s: found the %s \"%.80s\", which isn't there; expected one of the file; nearest: %s",
                 key, kind, name ? name : "", km_nearest_text(&nearest, text));
  return -1;
}

static const char *constraint_name(km_mjcf *m, const km_xml *e) {
  const char *name = km_xml_attribute_of(e, "name");
  return km_robot_free_name(m->robot, &m->robot->joints, m->assembly.value,
                            km_mjcf_full(m, name && name[0] ? name : e->name), "loop");
}

/* Both ends of a constraint as bodies and the frames on them that coincide; false: reported. */
typedef struct loop_ends {
  int body[2];
  km_pose pose[2];
} loop_ends;

static bool find_sites(km_mjcf *m, const km_xml *e, loop_ends *out) {
  static const char *const keys[2] = {"site1", "site2"};
  for (int k = 0; k < 2; ++k) {
    int site = km_mjcf_find(m, e, keys[k], &m->site_names, "site");
    if (site < 0)
      return false;
    out->body[k] = m->sites[site].body;
    out->pose[k] = m->sites[site].pose;
  }
  return true;
}

static bool find_bodies(km_mjcf *m, const km_xml *e, loop_ends *out) {
  out->body[0] = km_mjcf_find(m, e, "body1", &m->body_names, "body");
  out->body[1] = km_xml_attribute_of(e, "body2") ? km_mjcf_find(m, e, "body2", &m->body_names, "body") : 0;
  if (out->body[0] < 0 || out->body[1] < 0)
    return false;
  out->pose[0] = out->pose[1] = km_pose_identity();
  return true;
}

/* Where a frame of the first body is in the second one, as the file has them. */
static km_pose across(const km_mjcf *m, const loop_ends *ends) {
  km_pose back = km_pose_inverse(&m->bodies[ends->body[1]].world);
  km_pose X = km_pose_product(&m->bodies[ends->body[0]].world, &ends->pose[0]);
  return km_pose_product(&back, &X);
}

/* A ball joint: of sites the points meet, of bodies the anchor stays where it is on both. */
static void place_connect(km_mjcf *m, const km_xml *e, bool sites, loop_ends *ends) {
  double anchor[3] = {0};
  if (!sites) {
    if (!km_robot_numbers(m->robot, e, "anchor", anchor, 3) && !km_xml_attribute_of(e, "anchor"))
      km_robot_error(m->robot, e, "a connection without anchor; expected anchor=\"x y z\"");
    ends->pose[0].p = km_vec3_from_array(anchor);
  }
  if (!sites)
    ends->pose[1].p = across(m, ends).p;
}

/* Pose of a constraint. Sites coincide. For bodies the point `anchor` of the second is at the position of `relpose`
 * in the first, with the rotation of its quaternion; without a quaternion both follow from the configuration of the
 * file. */
static void place_weld(km_mjcf *m, const km_xml *e, bool sites, loop_ends *ends) {
  double r[7] = {0}, anchor[3] = {0};
  const char *text = km_xml_attribute_of(e, "relpose");
  if (sites)
    return;
  km_robot_numbers(m->robot, e, "anchor", anchor, 3);
  ends->pose[1].p = km_vec3_from_array(anchor);
  bool told = text && km_robot_parse(m->robot, e, "relpose", text, r, 7);
  if (told && (r[3] != 0.0 || r[4] != 0.0 || r[5] != 0.0 || r[6] != 0.0)) {
    ends->pose[0] = (km_pose){km_quaternion_rotation(km_quaternion_normalised((km_quaternion){r[3], r[4], r[5], r[6]})),
                              km_vec3_from_array(r)};
  } else {
    loop_ends other = {{ends->body[1], ends->body[0]}, {ends->pose[1], ends->pose[0]}};
    ends->pose[0] = across(m, &other);
  }
}

/* A weld whose torques count nothing is a connection. */
static bool is_rigid(km_mjcf *m, const km_xml *e) {
  return strcmp(e->name, "weld") == 0 && km_robot_number(m->robot, e, "torquescale", 1.0) != 0.0;
}

/* Sites and stated poses that almost meet are rounded; far ones meet when the loops are assembled. */
static void judge_gap(km_mjcf *m, const loop_ends *ends, bool weld) {
  km_pose stands = across(m, ends), back = km_pose_inverse(&ends->pose[1]), gap = km_pose_product(&back, &stands);
  double far = km_vec3_norm(gap.p), angle = km_vec3_norm(km_quaternion_log(km_rotation_quaternion(&gap.R)));
  if (far < 1e-3 * m->robot->reach)
    m->robot->lengths.several = fmax(m->robot->lengths.several, far);
  if (weld && angle < 1e-3)
    m->robot->angles.several = fmax(m->robot->angles.several, angle);
}

static void read_loop(km_mjcf *m, const km_xml *e) {
  bool sites = km_xml_attribute_of(e, "site1") != NULL, rigid = is_rigid(m, e);
  loop_ends ends;
  if (!(sites ? find_sites(m, e, &ends) : find_bodies(m, e, &ends)))
    return;
  if (strcmp(e->name, "weld") == 0)
    place_weld(m, e, sites, &ends);
  else
    place_connect(m, e, sites, &ends);
  if (!rigid) /* the ball joint is at 0 */
    ends.pose[1].R = across(m, &ends).R;
  judge_gap(m, &ends, rigid);
  if (ends.body[0] == ends.body[1]) {
    km_robot_error(m->robot, e, "both ends are on the body \"%.80s\"; expected two bodies",
                   m->bodies[ends.body[0]].name);
    return;
  }
  km_robot_joint joint = km_robot_joint_default();
  joint.at = e;
  joint.name = constraint_name(m, e);
  joint.assembly = m->assembly;
  joint.type = rigid ? KM_RIGID : KM_SPHERICAL;
  joint.parent = m->bodies[ends.body[0]].id;
  joint.child = m->bodies[ends.body[1]].id;
  joint.in_parent = ends.pose[0];
  joint.in_child = ends.pose[1];
  m->robot->closes = true;
  km_robot_add_joint(m->robot, &joint);
}

/* A polynomial in y - b, plus a, as one in y: by Horner's rule, (…) · (y - b) + c_k. */
static void shift(double c[5], double a, double b) {
  double out[5] = {0};
  for (int k = 4; k >= 0; --k) {
    for (int i = 4; i > 0; --i)
      out[i] = out[i - 1] - b * out[i];
    out[0] = c[k] - b * out[0];
  }
  out[0] += a;
  memcpy(c, out, sizeof out);
}

static void read_coupling(km_mjcf *m, const km_xml *e) {
  double c[5];
  int one = km_mjcf_find(m, e, "joint1", &m->joint_names, "joint");
  bool second = km_xml_attribute_of(e, "joint2") != NULL;
  int two = second ? km_mjcf_find(m, e, "joint2", &m->joint_names, "joint") : -1;
  if (one < 0 || (second && two < 0) || !read_polynomial(m->robot, e, c))
    return;
  shift(c, m->joints[one].reference, second ? m->joints[two].reference : 0.0);
  const char *name = km_xml_attribute_of(e, "name");
  km_robot_couple(m->robot, e, name && name[0] ? km_mjcf_full(m, name) : m->joints[one].name, m->assembly,
                  (km_coordinate_ref){m->joints[one].id, 0},
                  (km_coordinate_ref){second ? m->joints[two].id : (km_joint_id){0}, 0}, c, 5);
}

static void read_tendons(km_mjcf *m, const km_xml *e) {
  double c[5];
  if (read_polynomial(m->robot, e, c))
    km_mjcf_couple_tendons(m, e, c);
}

static void read_equality(km_mjcf *m, const km_xml *e) {
  if (!km_mjcf_is_here(m, e))
    return;
  if (!is_active(e))
    km_robot_omit(m->robot, "constraints that aren't active left out", km_xml_attribute_of(e, "name"));
  else if (strcmp(e->name, "connect") == 0 || strcmp(e->name, "weld") == 0)
    read_loop(m, e);
  else if (strcmp(e->name, "joint") == 0)
    read_coupling(m, e);
  else if (strcmp(e->name, "tendon") == 0)
    read_tendons(m, e);
  else
    km_robot_warn(m->robot, e, "a constraint of the kind \"%.40s\" is left out; the model moves more freely without it",
                  e->name);
}

void km_mjcf_read_constraints(km_mjcf *m) {
  for (const km_xml *list = km_xml_child(m->root, "equality"); list; list = km_xml_next(list))
    for (const km_xml *e = list->first; e; e = e->next)
      read_equality(m, e);
}
