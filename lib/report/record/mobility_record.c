/* Mobility, at a pose and over a sweep, as a record. */
#include "report/record/mobility_record.h"

#include "kinematics/state.h"

#include "kmech/mechanism.h"
#include "report/record/diagnosis_record.h"
#include "report/record/singular_value_record.h"
#include "topology/mechanism.h"

/* `four_bar`: type, links {body, length}, by how much the longest one is too long. */
static void add_four_bar(const km_mechanism *m, const km_state *s, int index, km_value *loop, km_arena *arena) {
  km_four_bar f;
  if (!km_four_bar_find(m, s, index, &f))
    return;
  km_value *four_bar = km_value_add(arena, loop, "four_bar", KM_OBJECT);
  km_value_string(arena, four_bar, "type", km_four_bar_name(f.kind));
  km_value *links = km_value_add(arena, four_bar, "links", KM_LIST);
  for (int i = 0; i < 4 && !arena->failed; ++i) {
    km_value *link = km_value_add(arena, links, NULL, KM_OBJECT);
    km_value_string(arena, link, "body", m->model->bodies[f.bodies[i]].name);
    km_value_number(arena, link, "length", f.lengths[i]);
  }
  km_value_string(arena, four_bar, "longest", m->model->bodies[f.bodies[f.longest]].name);
  km_value_number(arena, four_bar, "excess", f.excess);
}

static void add_loops(const km_mechanism *m, const km_state *s, km_value *record, km_arena *arena) {
  const km_topology *t = &m->topology;
  km_value *loops = km_value_add(arena, record, "loops", KM_LIST);
  for (int l = 0; l < t->loop_count && !arena->failed; ++l) {
    km_value *loop = km_value_add(arena, loops, NULL, KM_OBJECT);
    km_value_number(arena, loop, "id", l + 1);
    km_value_string(arena, loop, "chord", m->model->joints[t->chord[l]].label);
    km_value *joints = km_value_add(arena, loop, "joints", KM_LIST);
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i)
      km_value_string(arena, joints, NULL, m->model->joints[t->member[i].joint].label);
    km_value_number(arena, loop, "lambda", m->loops[l].lambda);
    add_four_bar(m, s, l, loop, arena);
  }
}

static void add_substructures(const km_mechanism *m, const km_state *s, km_value *record, km_arena *arena) {
  const km_topology *t = &m->topology;
  km_value *list = km_value_add(arena, record, "substructures", KM_LIST);
  for (int i = 0; i < t->substructure_count && !arena->failed; ++i) {
    km_substructure_mobility e;
    km_substructure_evidence(m, s, i, &e);
    km_value *sub = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_number(arena, sub, "id", i + 1);
    km_value *joints = km_value_add(arena, sub, "joints", KM_LIST);
    for (int k = t->joint_start[i]; k < t->joint_start[i + 1]; ++k)
      km_value_string(arena, joints, NULL, m->model->joints[t->joint[k]].label);
    km_value *loops = km_value_add(arena, sub, "loops", KM_LIST);
    for (int k = t->loop_start[i]; k < t->loop_start[i + 1]; ++k)
      km_value_number(arena, loops, NULL, t->loop[k] + 1);
    km_value_number(arena, sub, "coordinates", e.coordinates);
    km_value_number(arena, sub, "rank", e.rank);
    km_value_number(arena, sub, "mobility", e.mobility);
    km_value_number(arena, sub, "last_pivot", e.last_pivot);
    if (e.first_dropped > 0.0)
      km_value_number(arena, sub, "first_dropped", e.first_dropped);
    else
      km_value_add(arena, sub, "first_dropped", KM_NULL);
    km_value_number(arena, sub, "rank_tolerance", e.tolerance);
  }
}

static void add_coordinates(const km_mechanism *m, const km_state *s, km_value *record, km_arena *arena) {
  const km_model *model = m->model;
  km_configuration_record(m, s, record, arena);
  km_value *numbers = km_value_add(arena, record, "mobility_numbers", KM_OBJECT);
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    int freedom = km_model_freedom(model, j);
    if (freedom == 0)
      km_value_number(arena, numbers, joint->label, 0.0);
    for (int k = 0; k < freedom; ++k)
      km_value_number(arena, numbers, model->coordinates[joint->first_coordinate + k].label,
                      km_mobility_number(s, joint->first_coordinate + k));
  }
}

/* `plane`: the direction that everything moves across, and the planar count; null where there is none. */
static void add_plane(const km_mechanism *m, const km_state *s, const km_mobility *mobility, km_value *record,
                      km_arena *arena) {
  double normal[3];
  bool planar = km_mechanism_plane(m, s, normal);
  km_value *plane = km_value_add(arena, record, "plane", planar ? KM_LIST : KM_NULL);
  for (int k = 0; k < 3 && planar; ++k)
    km_value_number(arena, plane, NULL, normal[k]);
  if (planar)
    km_value_number(arena, record, "kutzbach_planar", mobility->kutzbach_planar);
  else
    km_value_add(arena, record, "kutzbach_planar", KM_NULL);
}

km_value *km_mobility_record(const km_mechanism *m, const km_state *s, const km_mobility *mobility, const char *name,
                             km_arena *arena) {
  if (km_check_state(m, s, NULL) || !mobility || !name || !arena)
    return NULL;
  const km_model *model = m->model;
  km_value *record = km_record_head(m, "kmob", name, arena);
  km_value_number(arena, record, "bodies", model->body_count - 1);
  km_value_number(arena, record, "joints", model->joint_count);
  km_value_number(arena, record, "coordinates", model->coordinate_count);
  add_loops(m, s, record, arena);
  add_substructures(m, s, record, arena);
  km_value_number(arena, record, "kutzbach", mobility->kutzbach);
  km_value_number(arena, record, "kutzbach_extended", mobility->kutzbach_extended);
  km_value_number(arena, record, "mobility", mobility->mobility);
  km_value_number(arena, record, "redundant_constraints", mobility->redundant_constraints);
  km_value_number(arena, record, "residual", mobility->residual);
  add_coordinates(m, s, record, arena);
  add_plane(m, s, mobility, record, arena);
  return arena->failed ? NULL : record;
}

bool km_sweep_drives(const km_mechanism *m, const km_mobility_sweep *sweep, int c) {
  const bool *idle = sweep->motion.passive_coordinates;
  if (m->substructure_of[c] != sweep->motion.substructure || m->held[c] || (idle && idle[c]))
    return false;
  for (size_t i = 0; i < sweep->toggle_count; ++i)
    if (sweep->toggles[i].coordinate == c)
      return false;
  return sweep->extremes[c].number > 1e-9;
}

/* Joints that can drive the range: smallest mobility number, its location, and the verdict as text. */
static void add_drivers(const km_mechanism *m, const km_mobility_sweep *sweep, km_value *record, km_arena *arena) {
  km_value *drivers = km_value_add(arena, record, "drivers", KM_LIST);
  for (int c = 0; c < m->coordinate_count && !arena->failed; ++c) {
    if (m->substructure_of[c] != sweep->motion.substructure || sweep->motion.substructure < 0 || m->held[c])
      continue;
    km_value *driver = km_value_add(arena, drivers, NULL, KM_OBJECT);
    km_value_string(arena, driver, "joint", m->model->coordinates[c].label);
    km_value_number(arena, driver, "smallest", sweep->extremes[c].number);
    km_value_number(arena, driver, "at", sweep->extremes[c].s);
    const bool *idle = sweep->motion.passive_coordinates;
    km_value_string(arena, driver, "verdict",
                    idle && idle[c]                ? "idle"
                    : km_sweep_drives(m, sweep, c) ? "keeps its grip"
                                                   : "loses its grip");
  }
}

/* Redundant constraints of all configurations, and the ranges with further ones. */
static void add_redundancies(const km_mechanism *m, const km_sweep_redundancies *r, km_value *record, km_arena *arena) {
  km_redundancies_record(m, &r->persistent, record, arena);
  km_value *extra = km_value_add(arena, record, "redundant_at_poses", KM_LIST);
  for (size_t i = 0; i < r->extra_count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, extra, NULL, KM_OBJECT);
    km_value_number(arena, item, "s", r->extra[i].s);
    km_value_number(arena, item, "more", r->extra[i].more);
  }
}

km_value *km_mobility_sweep_record(const km_mechanism *m, const km_mobility_sweep *sweep,
                                   const km_sweep_redundancies *redundancies, const char *stopped_by, const char *name,
                                   km_arena *arena) {
  km_value *record = km_record_head(m, "kmob", name, arena);
  km_table_record(sweep->motion.table, record, arena);
  km_value *toggles = km_value_add(arena, record, "toggles", KM_LIST);
  for (size_t i = 0; i < sweep->toggle_count && !arena->failed; ++i) {
    km_value *toggle = km_value_add(arena, toggles, NULL, KM_OBJECT);
    km_value_string(arena, toggle, "joint", m->model->coordinates[sweep->toggles[i].coordinate].label);
    km_value_number(arena, toggle, "s", sweep->toggles[i].s);
  }
  add_drivers(m, sweep, record, arena);
  km_singularities_record(m, sweep, record, arena);
  add_redundancies(m, redundancies, record, arena);
  km_clearance_course_record(m, &sweep->clearances, record, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}
