/* Joints that close loops, from elements of other programs. */
#include "exchange/sdf/sdf_closures.h"

#include "exchange/sdf/sdf.h"

#include <string.h>

/* Value of an element: an attribute in Drake's URDF, a text in its SDF. */
static const char *said(const km_xml *e, const char *child, const char *attribute) {
  const km_xml *found = km_xml_child(e, child);
  const char *value = km_xml_attribute_of(found, attribute);
  return value ? value : found ? found->text : "";
}

static bool find_end(const km_closures *c, const char *name, km_closure_end *out) {
  *out = (km_closure_end){.world = km_pose_identity(), .in_link = km_pose_identity()};
  return name[0] && c->find(c->context, name, out);
}

static km_pose in_world(const km_closure_end *end) {
  return km_pose_product(&end->world, &end->in_link);
}

/* A joint between the frames `in_link` of its ends; `def` has its type, name, axis and limits. */
static void add(const km_closures *c, const km_xml *at, const km_closure_end ends[2], km_robot_joint *def) {
  km_pose one = in_world(&ends[0]);
  if (ends[0].body.value == ends[1].body.value) {
    km_robot_error(c->robot, at, "joint \"%.80s\": both ends are on one link; expected two links", def->name);
    return;
  }
  def->at = at;
  def->assembly = c->assembly;
  def->name = km_robot_free_name(c->robot, &c->robot->joints, c->assembly.value, def->name, "loop");
  def->parent = ends[0].body;
  def->child = ends[1].body;
  def->in_parent = ends[0].in_link;
  def->in_child = ends[1].in_link;
  if (def->type == KM_SPHERICAL) { /* the ball joint is at 0 if the file's joints are */
    km_rotation back_to_link = km_rotation_inverse(&ends[1].world.R);
    def->in_child.R = km_rotation_product(&back_to_link, &one.R);
  }
  c->robot->closes = true;
  if (km_robot_add_joint(c->robot, def).value)
    c->tie(c->context, ends[0].link, ends[1].link);
}

static km_robot_joint new_joint(const char *name, km_joint_type type) {
  km_robot_joint joint = km_robot_joint_default();
  joint.name = name && name[0] ? name : "loop";
  joint.type = type;
  return joint;
}

static void warn(const km_closures *c, const km_xml *e, const char *why) {
  const char *name = km_xml_attribute_of(e, "name");
  km_robot_warn(c->robot, e, "<%.40s>%s%.80s%s ties links and is left out, so that the model moves more freely: %s",
                e->name, name ? " \"" : "", name ? name : "", name ? "\"" : "", why);
}

static void read_ball(const km_closures *c, const km_xml *e) {
  static const char *const bodies[2] = {"drake:ball_constraint_body_A", "drake:ball_constraint_body_B"};
  static const char *const points[2] = {"drake:ball_constraint_p_AP", "drake:ball_constraint_p_BQ"};
  km_closure_end ends[2];
  for (int k = 0; k < 2; ++k) {
    double p[3] = {0};
    const char *point = said(e, points[k], "value");
    if (!find_end(c, said(e, bodies[k], "name"), &ends[k])) {
      warn(c, e, "a link that it names isn't there");
      return;
    }
    km_robot_parse(c->robot, e, points[k], point, p, 3);
    ends[k].in_link.p = km_pose_point(&ends[k].in_link, km_vec3_from_array(p));
  }
  const char *name = km_robot_text(c->robot, "ball_%s_%s", said(e, bodies[0], "name"), said(e, bodies[1], "name"));
  km_robot_joint joint = new_joint(name, KM_SPHERICAL);
  add(c, e, ends, &joint);
}

static const struct {
  const char *word;
  km_joint_type type;
} types[] = {{"revolute", KM_RZ},         {"continuous", KM_RZ},  {"prismatic", KM_TZ},
             {"fixed", KM_RIGID},         {"ball", KM_SPHERICAL}, {"spherical", KM_SPHERICAL},
             {"universal", KM_UNIVERSAL}, {"planar", KM_PLANAR},  {"screw", KM_SCREW}};

static bool find_type(const km_xml *e, km_joint_type *out) {
  const char *word = km_xml_attribute_of(e, "type");
  for (size_t i = 0; word && i < sizeof types / sizeof *types; ++i)
    if (strcmp(types[i].word, word) == 0) {
      *out = types[i].type;
      return true;
    }
  return false;
}

/* <link1 link="" xyz="" rpy=""/> and <link2 …/>; some writers call both link1. */
static void read_loop_joint(const km_closures *c, const km_xml *e) {
  km_closure_end ends[2];
  km_joint_type type;
  int count = 0;
  for (const km_xml *l = e->first; l && count < 2; l = l->next) {
    const char *name = km_xml_attribute_of(l, "link");
    double xyz[3] = {0}, rpy[3] = {0};
    if (strcmp(l->name, "link1") != 0 && strcmp(l->name, "link2") != 0)
      continue;
    if (!name || !find_end(c, name, &ends[count]))
      break;
    km_robot_numbers(c->robot, l, "xyz", xyz, 3);
    km_robot_numbers(c->robot, l, "rpy", rpy, 3);
    km_robot_judge_origin(c->robot, l);
    km_pose own = {km_rotation_rpy(rpy), km_vec3_from_array(xyz)};
    ends[count].in_link = km_pose_product(&ends[count].in_link, &own);
    count++;
  }
  if (count < 2) {
    warn(c, e, "expected link1 and link2 with links of the file");
    return;
  }
  if (!find_type(e, &type) || type == KM_SCREW || type == KM_UNIVERSAL) {
    warn(c, e, "expected the type spherical, revolute, continuous, prismatic, planar or fixed");
    return;
  }
  km_robot_joint joint = new_joint(km_xml_attribute_of(e, "name"), type);
  double u[3] = {1, 0, 0};
  km_robot_numbers(c->robot, km_xml_child(e, "axis"), "xyz", u, 3);
  double length = km_vec3_norm(km_vec3_from_array(u));
  if (!(length > 0.0)) {
    km_robot_error(c->robot, e, "joint \"%.80s\": its axis is 0 0 0; expected a direction", joint.name);
    return;
  }
  joint.axis = km_vec3_scale(1.0 / length, km_vec3_from_array(u));
  add(c, e, ends, &joint);
}

/* A frame by the name that an attribute gives it, in the world; false: none is named, or it isn't there. */
static bool named_frame(const km_closures *c, const km_xml *e, const char *attribute, km_pose *out) {
  const char *name = km_xml_attribute_of(e, attribute);
  km_closure_end end;
  if (!name || !find_end(c, name, &end))
    return false;
  *out = in_world(&end);
  return true;
}

/* The joint's axis in its own frame, whose pose in the world is `at`. */
static km_vec3 axis_of(const km_closures *c, const km_xml *axis, const km_pose *at) {
  const km_xml *xyz = km_xml_child(axis, "xyz");
  double u[3] = {0, 0, 1};
  if (xyz && km_robot_parse(c->robot, xyz, "xyz", xyz->text, u, 3))
    km_robot_judge_digits(xyz->text, 0.0, &c->robot->angles);
  double length = km_vec3_norm(km_vec3_from_array(u));
  km_vec3 unit = length > 0.0 ? km_vec3_scale(1.0 / length, km_vec3_from_array(u)) : (km_vec3){0, 0, 1};
  if (!(length > 0.0))
    km_robot_error(c->robot, xyz, "the axis is 0 0 0; expected a direction");
  km_pose other = km_pose_identity();
  if (!named_frame(c, xyz, "expressed_in", &other) && !km_sdf_is_true(km_sdf_text(axis, "use_parent_model_frame")))
    return unit;
  return km_rotate_back(&at->R, km_rotate(&other.R, unit));
}

/* Reads a joint of SDF. Its pose in the child defines its frame, which coincides with the frame in the parent when
 * all joints are at 0. */
static void read_sdf_joint(const km_closures *c, const km_xml *e) {
  const char *names[2] = {km_sdf_text(e, "parent"), km_sdf_text(e, "child")};
  km_closure_end ends[2];
  km_joint_type type;
  for (int k = 0; k < 2; ++k)
    if (!find_end(c, names[k], &ends[k])) {
      warn(c, e, "expected a parent and a child that are links of the file");
      return;
    }
  if (!find_type(e, &type) || type == KM_UNIVERSAL || type == KM_PLANAR) {
    warn(c, e, "expected the type revolute, continuous, prismatic, fixed, ball or screw");
    return;
  }
  km_pose own = km_sdf_pose(c->robot, e), base = in_world(&ends[1]);
  named_frame(c, km_xml_child(e, "pose"), "relative_to", &base);
  km_pose at = km_pose_product(&base, &own);
  for (int k = 0; k < 2; ++k) {
    km_pose back = km_pose_inverse(&ends[k].world);
    ends[k].in_link = km_pose_product(&back, &at);
  }
  km_robot_joint joint = new_joint(km_xml_attribute_of(e, "name"), type);
  const km_xml *axis = km_xml_child(e, "axis");
  if (type != KM_RIGID && type != KM_SPHERICAL) {
    joint.axis = axis_of(c, axis, &at);
    km_sdf_read_axis(c->robot, axis, strcmp(km_xml_attribute_of(e, "type"), "continuous") == 0, 0, &joint);
  }
  if (type == KM_SCREW)
    joint.pitch = km_sdf_pitch(c->robot, e);
  add(c, e, ends, &joint);
}

/* Gazebo's plugin connects the child's link to the parent's in the current configuration, until it is detached. */
static void read_detachable(const km_closures *c, const km_xml *e) {
  const char *model = km_sdf_text(e, "child_model"), *link = km_sdf_text(e, "child_link");
  km_closure_end ends[2];
  bool there = find_end(c, km_sdf_text(e, "parent_link"), &ends[0]) &&
               (find_end(c, km_robot_text(c->robot, "%s::%s", model, link), &ends[1]) || find_end(c, link, &ends[1]));
  if (!there) {
    warn(c, e, "one of its links isn't in the file");
    return;
  }
  km_pose back = km_pose_inverse(&ends[0].world);
  ends[0].in_link = km_pose_product(&back, &ends[1].world);
  ends[1].in_link = km_pose_identity();
  km_robot_joint joint = new_joint(km_robot_text(c->robot, "%s_%s", km_sdf_text(e, "parent_link"), link), KM_RIGID);
  add(c, e, ends, &joint);
}

static bool is_detachable(const km_xml *e) {
  const char *name = km_xml_attribute_of(e, "name"), *file = km_xml_attribute_of(e, "filename");
  return (name && strstr(name, "DetachableJoint")) || (file && strstr(file, "detachable-joint"));
}

enum { MOST_NAMED = 2 };

/* Counts different links that attributes and texts inside of an element name, up to MOST_NAMED. */
static void count_links(const km_closures *c, const km_xml *e, int *links, int *count) {
  for (int i = -1; i < e->attribute_count && *count < MOST_NAMED; ++i) {
    km_closure_end end;
    const char *name = i < 0 ? e->text : e->attributes[i].value;
    if (find_end(c, name, &end) && (*count == 0 || links[0] != end.link))
      links[(*count)++] = end.link;
  }
  for (const km_xml *m = e->first; m && *count < MOST_NAMED; m = m->next)
    if (!strstr(m->name, "joint") && !strstr(m->name, "Joint")) /* a joint may be called as a link */
      count_links(c, m, links, count);
}

/* True if the name of an element or plugin suggests a connection. */
static bool speaks_of_ties(const km_xml *e) {
  static const char *const words[] = {"constraint", "joint", "loop", "weld", "connect", "attach", "clos", "equality"};
  const char *texts[3] = {e->name, NULL, NULL};
  if (strcmp(e->name, "plugin") == 0) {
    texts[1] = km_xml_attribute_of(e, "name");
    texts[2] = km_xml_attribute_of(e, "filename");
  }
  for (int t = 0; t < 3; ++t)
    for (size_t w = 0; texts[t] && w < sizeof words / sizeof *words; ++w)
      if (strstr(texts[t], words[w]))
        return true;
  return false;
}

bool km_closures_read(const km_closures *c, const km_xml *e) {
  int links[MOST_NAMED], count = 0;
  if (strcmp(e->name, "drake:ball_constraint") == 0) {
    read_ball(c, e);
  } else if (strcmp(e->name, "loop_joint") == 0) {
    read_loop_joint(c, e);
  } else if (strcmp(e->name, "joint") == 0) {
    read_sdf_joint(c, e);
  } else if (strcmp(e->name, "plugin") == 0 && is_detachable(e)) {
    read_detachable(c, e);
  } else {
    if (speaks_of_ties(e))
      count_links(c, e, links, &count);
    if (count < MOST_NAMED)
      return false;
    warn(c, e, "elements of this kind aren't read");
  }
  return true;
}

void km_closures_pair(const km_closures *c, const km_xml *at, const char *name) {
  static const char begin[] = "closing_";
  size_t length = strlen(name);
  bool one = length > sizeof begin + 1 && strncmp(name, begin, sizeof begin - 1) == 0 && name[length - 2] == '_';
  if (!one || (name[length - 1] != '1' && name[length - 1] != '2'))
    return;
  const char *stem = km_robot_text(c->robot, "%.*s", (int)length - 2, name);
  km_closure_end ends[2];
  bool there = find_end(c, km_robot_text(c->robot, "%s_1", stem), &ends[0]) &&
               find_end(c, km_robot_text(c->robot, "%s_2", stem), &ends[1]);
  if (!there) {
    km_robot_warn(c->robot, at,
                  "the frame \"%.80s\" is one of a pair that closes a loop, whose other one isn't there; "
                  "the model moves more freely without it",
                  name);
    return;
  }
  if (name[length - 1] == '2') /* the other one adds the joint */
    return;
  km_robot_joint joint = new_joint(stem, KM_SPHERICAL);
  km_robot_omit(c->robot, "pairs of frames closing_…_1 and closing_…_2 read as ball joints", stem);
  add(c, at, ends, &joint);
}
