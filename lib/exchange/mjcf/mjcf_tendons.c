/* Fixed tendons, whose length is a sum over joints, and constraints between them. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static void add_term(km_mjcf_sum *s, int joint, double ratio) {
  int k = 0;
  while (k < s->count && s->joints[k] != joint)
    k++;
  if (k == KM_MJCF_MOST_TERMS)
    return;
  if (k == s->count) {
    s->joints[s->count] = joint;
    s->ratios[s->count++] = 0.0;
  }
  s->ratios[k] += ratio;
}

static const km_xml *find_fixed(const km_mjcf *m, const char *name) {
  for (const km_xml *list = km_xml_child(m->root, "tendon"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "fixed"); e; e = km_xml_next(e)) {
      const char *own = km_xml_attribute_of(e, "name");
      if (own && strcmp(own, name) == 0)
        return e;
    }
  return NULL;
}

bool km_mjcf_tendon_is_here(const km_mjcf *m, const char *name) {
  const km_xml *tendon = name ? find_fixed(m, name) : NULL;
  for (const km_xml *e = km_xml_child(tendon, "joint"); e; e = km_xml_next(e))
    if (!km_mjcf_is_here(m, e))
      return false;
  return true;
}

static bool is_single(const km_mjcf *m, int joint) {
  return m->joints[joint].type == KM_RZ || m->joints[joint].type == KM_TZ;
}

bool km_mjcf_add_length(km_mjcf *m, const km_xml *tendon, double factor, km_mjcf_sum *out) {
  int terms = 0;
  for (const km_xml *e = km_xml_child(tendon, "joint"); e; e = km_xml_next(e)) {
    int joint = km_mjcf_find(m, e, "joint", &m->joint_names, "joint");
    if (joint < 0)
      return false;
    if (!is_single(m, joint) || ++terms > KM_MJCF_MOST_TERMS) {
      km_robot_error(m->robot, e, "found the joint \"%.80s\"; expected at most %d hinges and slides",
                     m->joints[joint].name, KM_MJCF_MOST_TERMS);
      return false;
    }
    add_term(out, joint, factor * km_robot_number(m->robot, e, "coef", 1.0));
  }
  return true;
}

/* The length of the tendon that a constraint names; false: reported, or not a sum over joints of one coordinate. */
static bool add_length(km_mjcf *m, const km_xml *constraint, const char *key, double factor, km_mjcf_sum *out) {
  const char *name = km_xml_attribute_of(constraint, key);
  const km_xml *tendon = name ? find_fixed(m, name) : NULL;
  if (tendon)
    return km_mjcf_add_length(m, tendon, factor, out);
  km_robot_warn(m->robot, constraint,
                "%s: found \"%.80s\", which is no fixed tendon; the constraint is left out, and the model moves more "
                "freely without it",
                key, name ? name : "");
  return false;
}

/* length1 - its value at the reference values = c0 + c1 (length2 - its value there). */
void km_mjcf_couple_tendons(km_mjcf *m, const km_xml *e, const double c[5]) {
  km_mjcf_sum *s = KM_ARENA_NEW(&m->robot->arena, km_mjcf_sum, 1);
  km_coordinate_ref *refs = KM_ARENA_NEW(&m->robot->arena, km_coordinate_ref, KM_MJCF_MOST_TERMS);
  bool second = km_xml_attribute_of(e, "tendon2") != NULL;
  km_error error;
  if (!s || !refs || !add_length(m, e, "tendon1", 1.0, s) || (second && !add_length(m, e, "tendon2", -c[1], s)))
    return;
  if (second && (c[2] != 0.0 || c[3] != 0.0 || c[4] != 0.0)) {
    km_robot_warn(m->robot, e,
                  "polycoef: found a curve between two tendons; expected a line; the constraint is left out, and the "
                  "model moves more freely without it");
    return;
  }
  const char *name = km_xml_attribute_of(e, "name");
  km_coupling_def def = {.name = km_mjcf_full(m, name && name[0] ? name : km_xml_attribute_of(e, "tendon1")),
                         .assembly = m->assembly,
                         .count = s->count,
                         .coordinates = refs,
                         .ratios = s->ratios,
                         .constant_given = true,
                         .constant = c[0]};
  for (int k = 0; k < s->count; ++k) {
    refs[k] = (km_coordinate_ref){m->joints[s->joints[k]].id, 0};
    def.constant += s->ratios[k] * m->joints[s->joints[k]].reference;
  }
  km_status status = s->count ? km_model_add_coupling(m->robot->builder, &def, &error) : KM_OK;
  if (status)
    km_robot_builder_failed(m->robot, e, status, &error);
}

static bool is_coupled(const km_mjcf *m, const char *tendon) {
  for (const km_xml *list = km_xml_child(m->root, "equality"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "tendon"); e; e = km_xml_next(e)) {
      const char *one = km_xml_attribute_of(e, "tendon1"), *two = km_xml_attribute_of(e, "tendon2");
      if ((one && strcmp(one, tendon) == 0) || (two && strcmp(two, tendon) == 0))
        return true;
    }
  return false;
}

void km_mjcf_count_tendons(km_mjcf *m) {
  for (const km_xml *list = km_xml_child(m->root, "tendon"); list; list = km_xml_next(list))
    for (const km_xml *e = list->first; e; e = e->next) {
      const char *name = km_xml_attribute_of(e, "name");
      bool coupled = strcmp(e->name, "fixed") == 0 && name && is_coupled(m, name);
      if (!coupled && !km_mjcf_is_spring(m, e))
        km_robot_omit(m->robot, "tendons left out", name);
    }
}
