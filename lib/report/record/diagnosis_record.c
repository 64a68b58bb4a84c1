/* Finite mobility, motions, redundant constraints and findings of a check, as records and as text. */
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

/* Adds the motions of a change: translations along and rotations about the axes of the joint's parent frame. */
static void add_change_motions(const km_joint_change *change, km_value *entry, km_arena *arena) {
  static const char *const words[] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  km_value *list = km_value_add(arena, entry, "motions_added", KM_LIST);
  for (int k = 0; k < 6 && !arena->failed; ++k)
    if (change->motions >> k & 1)
      km_value_string(arena, list, NULL, words[k]);
}

void km_remedy_set_record(const km_mechanism *m, const km_remedy_set *set, km_value *record, km_arena *arena) {
  km_value *item = km_value_add(arena, record, "remedy_set", KM_OBJECT);
  km_value_number(arena, item, "redundant_constraints", set->redundant);
  km_value_number(arena, item, "remaining", set->remaining);
  km_value_number(arena, item, "mobility", set->mobility);
  km_value_boolean(arena, item, "checked", set->is_checked);
  km_value_boolean(arena, item, "infinitesimal", set->is_infinitesimal);
  km_value_boolean(arena, item, "too_large", set->is_too_large);
  km_value *changes = km_value_add(arena, item, "changes", KM_LIST);
  for (int i = 0; i < set->change_count && !arena->failed; ++i) {
    const km_joint_change *change = &set->changes[i];
    km_value *entry = km_value_add(arena, changes, NULL, KM_OBJECT);
    km_value_string(arena, entry, "joint", m->model->joints[change->joint].label);
    km_value_string(arena, entry, "from", km_joint_kind_of(m->model->joints[change->joint].type)->word);
    km_value_string(arena, entry, "to", change->to);
    km_value_number(arena, entry, "freedoms_added", change->freedoms);
    add_change_motions(change, entry, arena);
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
  if (d->redundancies.count)
    km_remedy_set_record(m, &d->remedies, record, arena);
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
                   km_plural(across), across == 1 ? "is" : "are",
                   all ? "" : " (--verbose lists them and a set of joint types without them)");
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

static void print_change(const km_mechanism *m, const km_joint_change *change, km_text *out) {
  const km_model_joint *joint = &m->model->joints[change->joint];
  km_text_format(out, "  %s %s instead of %s", joint->label, change->to, km_joint_kind_of(joint->type)->word);
  const char *before = ": also";
  for (int k = 0; k < 6; ++k) {
    if (!(change->motions >> k & 1))
      continue;
    km_text_format(out, "%s %s %c", before, k < 3 ? "along" : "about", "xyzxyz"[k]);
    before = ",";
  }
  km_text_format(out, " of its frame in %s\n", m->model->bodies[m->model->frames[joint->frame[0]].body].name);
}

void km_remedy_set_print(const km_mechanism *m, const km_remedy_set *set, km_text *out) {
  enum { MOST_SHOWN = 24 };
  if (set->is_infinitesimal) {
    km_text_add(out,
                "\nno set of joint types ends them: some motions are infinitesimal, so the dimensions must change\n");
    return;
  }
  if (set->change_count == 0) {
    km_text_format(out, "\nno set of joint types that ends them was found%s\n",
                   set->is_too_large ? ": a substructure is too large for the search" : "");
    return;
  }
  if (set->remaining == 0)
    km_text_format(out, "\na set of joint types that ends all %d with mobility %d", set->redundant, set->mobility);
  else
    km_text_format(out, "\na set of joint types that ends %d of %d with mobility %d", set->redundant - set->remaining,
                   set->redundant, set->mobility);
  km_text_add(out, set->is_checked ? " (checked on the changed model)\n" : " (not confirmed on the changed model)\n");
  for (int i = 0; i < set->change_count && i < MOST_SHOWN; ++i)
    print_change(m, &set->changes[i], out);
  if (set->change_count > MOST_SHOWN)
    km_text_format(out, "  and %d more (--format json lists all)\n", set->change_count - MOST_SHOWN);
}

void km_diagnosis_print(const km_mechanism *m, const km_diagnosis *d, bool all, km_text *out) {
  if (!m || !d || !out)
    return;
  print_idle(m, d, out);
  print_redundancies(m, &d->redundancies, all, out);
  if (d->redundancies.count > (all ? 0 : km_redundancies_out_of_plane(&d->redundancies, -1)))
    km_remedy_set_print(m, &d->remedies, out);
}

/* Faults first; of one severity in the order in which they were found. */
void km_findings_print(const km_findings *f, const char *name, km_text *out) {
  if (!f || !name || !out)
    return;
  if (f->count == 0) {
    km_text_format(out, "%s: nothing suspicious\n", name);
    return;
  }
  km_text_format(out, "%s:", name);
  for (int severity = 0, listed = 0; severity < KM_FINDING_SEVERITIES; ++severity)
    if (f->counts[severity])
      km_text_format(out, "%s %zu %s%s", listed++ ? "," : "", f->counts[severity],
                     km_finding_severity_name((km_finding_severity)severity), f->counts[severity] == 1 ? "" : "s");
  km_text_add(out, "\n");
  for (int severity = 0; severity < KM_FINDING_SEVERITIES; ++severity)
    for (size_t i = 0; i < f->count; ++i)
      if (f->items[i].severity == (km_finding_severity)severity)
        km_text_format(out, "  %s: %s: %s\n    → %s\n", km_finding_severity_name(f->items[i].severity),
                       f->items[i].kind, f->items[i].statement, f->items[i].advice);
}

void km_findings_record(const km_findings *f, km_value *record, km_arena *arena) {
  if (!f || !record || !arena)
    return;
  km_value *list = km_value_add(arena, record, "findings", KM_LIST);
  for (size_t i = 0; i < f->count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "kind", f->items[i].kind);
    km_value_string(arena, item, "severity", km_finding_severity_name(f->items[i].severity));
    km_value_string(arena, item, "statement", f->items[i].statement);
    km_value_string(arena, item, "advice", f->items[i].advice);
  }
}
