/* Finite mobility, motions and redundant constraints as a record and as text. */
#include "report/record/diagnosis_record.h"

#include "diagnosis/finding_texts.h"
#include "report/record/sweep_text.h"
#include "topology/mechanism.h"

#include <math.h>

static void remedy_words(const km_mechanism *m, const km_remedy *remedy, km_text *out) {
  const km_model_joint *joint = &m->model->joints[remedy->joint];
  km_text_format(out, "%s %s instead of %s", joint->label, remedy->to, km_joint_kind_of(joint->type)->word);
}

static void add_motions(const km_mechanism *m, const km_finite_mobility *finite, km_value *record, km_arena *arena) {
  km_value *motions = km_value_add(arena, record, "motions", KM_LIST);
  for (int i = 0; i < finite->motion_count && !arena->failed; ++i) {
    const km_finite_motion *motion = &finite->motions[i];
    km_value *item = km_value_add(arena, motions, NULL, KM_OBJECT);
    km_value_string(arena, item, "kind", km_motion_kind_name(motion->kind));
    km_value_number(arena, item, "substructure", motion->substructure + 1);
    km_value *direction = km_value_add(arena, item, "direction", KM_OBJECT);
    for (int c = 0; c < m->coordinate_count; ++c)
      if (m->substructure_of[c] == motion->substructure && !m->held[c])
        km_value_number(arena, direction, m->model->coordinates[c].label, motion->direction[c]);
    km_value_number(arena, item, "confirmed_length", motion->confirmed_length);
  }
}

void km_redundancies_record(const km_mechanism *m, const km_redundancies *redundancies, km_value *record,
                            km_arena *arena) {
  km_value *list = km_value_add(arena, record, "redundancies", KM_LIST);
  for (int i = 0; i < redundancies->count && !arena->failed; ++i) {
    const km_redundancy *r = &redundancies->items[i];
    km_text text = {0};
    km_redundancy_statement(m, r, &text);
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_number(arena, item, "substructure", r->substructure + 1);
    km_value_number(arena, item, "loop", r->loop + 1);
    km_value_words(arena, item, "statement", &text);
    km_value_boolean(arena, item, "lasting", r->persistent);
    km_value_boolean(arena, item, "out_of_plane", r->out_of_plane);
    km_value *remedies = km_value_add(arena, item, "remedies", KM_LIST);
    for (int k = 0; k < r->remedy_count && !arena->failed; ++k) {
      const km_remedy *remedy = &r->remedies[k];
      km_value *entry = km_value_add(arena, remedies, NULL, KM_OBJECT);
      km_value_string(arena, entry, "joint", m->model->joints[remedy->joint].label);
      km_value_string(arena, entry, "from", km_joint_kind_of(m->model->joints[remedy->joint].type)->word);
      km_value_string(arena, entry, "to", remedy->to);
      km_value_number(arena, entry, "freedoms_added", remedy->freedoms);
    }
  }
}

static void add_idle(const km_mechanism *m, const km_passive_freedoms *idle, km_value *record, km_arena *arena) {
  km_value_number(arena, record, "idle_mobility", idle->mobility);
  km_value *list = km_value_add(arena, record, "idle_freedoms", KM_LIST);
  for (int i = 0; i < idle->count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_number(arena, item, "substructure", idle->items[i].substructure + 1);
    km_value_number(arena, item, "freedoms", idle->items[i].freedoms);
    km_value *bodies = km_value_add(arena, item, "bodies", KM_LIST);
    for (int k = 0; k < idle->items[i].body_count && !arena->failed; ++k)
      km_value_string(arena, bodies, NULL, m->model->bodies[idle->items[i].bodies[k]].name);
  }
}

static void print_idle(const km_mechanism *m, const km_diagnosis *d, km_text *out) {
  enum { MOST_SHOWN = 24 };
  if (d->passive.count == 0)
    return;
  km_text_format(out, "\nidle freedoms: %d of the finite mobility %d; no other joint drives or feels them\n",
                 d->passive.mobility, d->finite.mobility);
  for (int i = 0; i < d->passive.count && i < MOST_SHOWN; ++i) {
    km_text_add(out, "  ");
    km_passive_freedom_statement(m, &d->passive.items[i], out);
    km_text_add(out, "\n");
  }
}

void km_diagnosis_record(const km_mechanism *m, const km_diagnosis *d, km_value *record, km_arena *arena) {
  if (!m || !d || !record || !arena)
    return;
  if (d->finite.undecided)
    km_value_add(arena, record, "finite_mobility", KM_NULL);
  else
    km_value_number(arena, record, "finite_mobility", d->finite.mobility);
  add_motions(m, &d->finite, record, arena);
  km_value_boolean(arena, record, "truncated", d->finite.truncated);
  add_idle(m, &d->passive, record, arena);
  km_redundancies_record(m, &d->redundancies, record, arena);
}

static void print_finite(const km_finite_mobility *finite, km_text *out) {
  int branches = 0, shaky = 0;
  double followed = HUGE_VAL;
  for (int i = 0; i < finite->motion_count; ++i) {
    branches += finite->motions[i].kind == KM_MOTION_BRANCH;
    shaky += finite->motions[i].kind == KM_MOTION_SHAKY;
    if (finite->motions[i].kind == KM_MOTION_UNDECIDED)
      followed = fmin(followed, finite->motions[i].confirmed_length);
  }
  if (finite->undecided)
    km_text_format(out, "\nfinite mobility undecided, at least %d", finite->mobility);
  else
    km_text_format(out, "\nfinite mobility %d", finite->mobility);
  if (followed == 0.0)
    km_text_add(out, ": no motion along the directions that first order allows is confirmed, and none is ruled out");
  else if (isfinite(followed))
    km_text_format(out,
                   ": the loops stay within the closure tolerance for an arc of %.2g, and what opens them there tells "
                   "neither a motion nor a structure",
                   followed);
  if (branches)
    branches = km_finite_mobility_branches(finite);
  if (branches == 1 && !finite->truncated)
    km_text_add(out, ": not all motions that first order allows are real");
  else if (branches && finite->truncated)
    km_text_add(out, ": a branch point, where several motions meet");
  else if (branches)
    km_text_format(out, ": a branch point, where %d motions meet", branches);
  if (shaky)
    km_text_format(out, "%s it shakes: %d direction%s that first order allows, but no motion follows",
                   branches || isfinite(followed) ? "; also" : ":", shaky, shaky == 1 ? "" : "s");
  if (finite->undecided && finite->truncated)
    km_text_add(out, "; only some of the directions that first order allows were tried");
  km_text_add(out, "\n");
}

static void print_redundancy(const km_mechanism *m, const km_redundancy *r, km_text *out) {
  km_text_add(out, "  ");
  km_redundancy_statement(m, r, out);
  km_text_add(out, r->remedy_count ? "\n    " : "\n    no single swap of a joint ends it\n");
  for (int k = 0; k < r->remedy_count && k < 4; ++k) {
    km_text_add(out, k ? "; " : "");
    remedy_words(m, &r->remedies[k], out);
  }
  km_text_add(out, r->remedy_count ? "\n" : "");
}

/* Those that planar loops have by nature in one line. */
static void print_redundancies(const km_mechanism *m, const km_redundancies *found, bool all, km_text *out) {
  enum { MOST_SHOWN = 24 };
  int across = km_redundancies_out_of_plane(found, -1), shown = 0, listed = all ? found->count : found->count - across;
  if (across)
    km_text_format(out, "\n%d constraint%s out of the plane of planar loops %s redundant by nature%s\n", across,
                   km_plural(across), across == 1 ? "is" : "are", all ? "" : " (--verbose lists them)");
  if (listed)
    km_text_add(out, "\nredundant constraints, and what would end each with the same mobility\n");
  for (int i = 0; i < found->count && shown < MOST_SHOWN; ++i) {
    if (found->items[i].out_of_plane && !all)
      continue;
    print_redundancy(m, &found->items[i], out);
    ++shown;
  }
  if (listed > MOST_SHOWN)
    km_text_format(out, "  and %d more (--format json lists all)\n", listed - MOST_SHOWN);
}

void km_diagnosis_print(const km_mechanism *m, const km_diagnosis *d, bool all, km_text *out) {
  if (!m || !d || !out)
    return;
  print_finite(&d->finite, out);
  print_idle(m, d, out);
  print_redundancies(m, &d->redundancies, all, out);
}
