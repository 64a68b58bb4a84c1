/* Self-motions and branches of inverse kinematics. */
#include "report/record/record.h"
#include "report/record/track_record.h"

#include <string.h>

static bool is_motion_of(const km_arm *a, const km_selfmotion *m) {
  return a && m && (m->columns == a->n || (m->count == 0 && m->row_count == 0 && m->arc_count == 0));
}

static void add_motion(const km_arm *a, const km_selfmotion *m, km_value *record, km_arena *arena) {
  km_value_boolean(arena, record, "closed", m->closed);
  km_value_boolean(arena, record, "but_for_full_turns", m->continues_by_turns);
  km_value_number(arena, record, "length", m->length);
  km_value_boolean(arena, record, "within_limits_all_round", m->is_within_limits);
  km_value *arcs = km_value_add(arena, record, "arcs", KM_LIST);
  for (int i = 0; i < m->arc_count && !arena->failed; ++i) {
    km_value *arc = km_value_add(arena, arcs, NULL, KM_OBJECT);
    km_value_number(arena, arc, "from", m->arcs[i].from);
    km_value_number(arena, arc, "to", m->arcs[i].to);
    for (int end = 0; end < 2; ++end) {
      int column = m->arcs[i].column[end];
      if (column >= 0)
        km_value_string(arena, arc, end ? "to_limit" : "from_limit", km_arm_label(a, column));
      else
        km_value_add(arena, arc, end ? "to_limit" : "from_limit", KM_NULL);
    }
    km_value *turns = m->turn ? km_value_add(arena, arc, "turns", KM_OBJECT) : NULL;
    for (int k = 0; k < a->n && turns; ++k)
      if (m->turn[i * a->n + k])
        km_value_number(arena, turns, km_arm_label(a, k), m->turn[i * a->n + k]);
  }
}

km_value *km_selfmotion_record(const km_arm *a, const km_selfmotion *m, bool all, const char *model, km_arena *arena) {
  if (!is_motion_of(a, m) || !model || !arena)
    return NULL;
  km_value *record = km_arm_record(a, model, arena);
  km_table *table = km_selfmotion_table(a, m, all);
  add_motion(a, m, record, arena);
  km_value_number(arena, record, "error", m->error);
  if (table)
    km_table_record(table, record, arena);
  else
    arena->failed = true;
  km_table_free(table);
  return arena->failed ? NULL : record;
}

/* False when out of memory. */
static bool add_motion_columns(const km_arm *a, km_table *table) {
  bool added = km_table_add_column(table, "step", NULL) >= 0 && km_table_add_plain_column(table, "s", "rad") >= 0 &&
               km_table_add_column(table, "arc", NULL) >= 0;
  for (int k = 0; k < a->n && added; ++k) {
    km_text name = {0};
    const char *unit = km_model_coordinate_unit(a->mechanism->model, a->coordinate[k]);
    km_text_format(&name, "q.%s", km_arm_label(a, k));
    added = !name.failed && km_table_add_column(table, name.data, unit) >= 0;
    km_text_free(&name);
  }
  return added && km_table_add_column(table, "objective.manipulability", NULL) >= 0 &&
         km_table_add_column(table, "objective.singular-value", NULL) >= 0 &&
         km_table_add_column(table, "limit_margin", NULL) >= 0;
}

/* A row; `shown` in the model's units. */
static bool add_motion_row(const km_arm *a, km_arm_space *space, km_table *table, double arc, double u,
                           const double *shown) {
  double q[KM_ARM_MAX_JOINTS], sigma[KM_ARM_ROWS], product = 1.0, *row = km_table_add_row(table);
  if (!row)
    return false;
  for (int k = 0; k < a->n; ++k)
    q[k] = km_arm_from_units(a, k, shown[k]);
  km_arm_update(a, space, q);
  km_arm_singular_values(a, space, sigma);
  for (int r = 0; r < a->rows; ++r)
    product *= sigma[r];
  *row++ = (double)km_table_rows(table) - 1.0;
  *row++ = u;
  *row++ = arc;
  memcpy(row, shown, (size_t)a->n * sizeof *row);
  row += a->n;
  *row++ = product;
  *row++ = sigma[a->rows - 1];
  *row = km_arm_limit_distance(a, q);
  return true;
}

km_table *km_selfmotion_table(const km_arm *a, const km_selfmotion *m, bool all) {
  if (!is_motion_of(a, m))
    return NULL;
  km_table *table = km_table_create();
  km_arm_space space;
  if (!table || !km_arm_space_create(a, &space)) {
    km_table_free(table);
    return NULL;
  }
  bool whole = add_motion_columns(a, table);
  all = all && m->count > 0; /* a surface has no whole curve */
  for (int i = 0; i < (all ? m->count : m->row_count) && whole; ++i)
    whole = all ? add_motion_row(a, &space, table, (double)NAN, m->u[i], m->q + i * a->n)
                : add_motion_row(a, &space, table, m->row_arc[i] + 1, m->row_u[i], m->row_q + i * a->n);
  km_arm_space_free(&space);
  if (whole)
    return table;
  km_table_free(table);
  return NULL;
}

static void print_arcs(const km_arm *a, const km_selfmotion *m, const char *indent, km_text *out) {
  for (int i = 0; i < m->arc_count; ++i) {
    const km_arc_span *arc = &m->arcs[i];
    km_text_format(out, "%s%.9g to %.9g rad (length %.6g rad)", indent, arc->from, arc->to, arc->to - arc->from);
    if (arc->column[0] >= 0 || arc->column[1] >= 0)
      km_text_format(out, ", ended by %s and %s",
                     arc->column[0] >= 0 ? km_arm_label(a, arc->column[0])
                     : a->freedom == 2   ? "the start"
                                         : "the curve's end",
                     arc->column[1] >= 0 ? km_arm_label(a, arc->column[1]) : "the curve's end");
    for (int k = 0; k < a->n && m->turn; ++k)
      if (m->turn[i * a->n + k])
        km_text_format(out, ", %s in turn %d", km_arm_label(a, k), m->turn[i * a->n + k]);
    km_text_add(out, "\n");
  }
}

static void print_motion(const km_arm *a, const km_selfmotion *m, const char *indent, km_text *out) {
  if (a->freedom == 2) {
    km_text_format(out, "a surface of poses; in %d directions round the start:\n", m->arc_count);
    print_arcs(a, m, indent, out);
    return;
  }
  if (m->closed)
    km_text_format(out, "a closed curve of %.6g rad%s", m->length,
                   m->continues_by_turns ? " but for full turns of joints within limits" : "");
  else
    km_text_format(out, "an open curve of %.6g rad", m->length);
  if (m->is_within_limits) {
    km_text_add(out, ", within the limits all the way round");
    km_text_format(out, m->arc_count > 1 ? ", in each of %d combinations of full turns\n" : "\n", m->arc_count);
    return;
  }
  km_text_format(out, "; %d arc%s within the limits%s\n", m->arc_count, m->arc_count == 1 ? "" : "s",
                 m->arc_count ? ":" : "");
  print_arcs(a, m, indent, out);
}

void km_selfmotion_print(const km_arm *a, const km_selfmotion *m, const char *name, km_text *out) {
  if (!is_motion_of(a, m) || !name || !out)
    return;
  km_text_format(out, "%s: self-motion, ", name);
  print_motion(a, m, "  ", out);
  km_text_format(out, "  effector held to %.2g (lengths over L); %d poses\n", m->error,
                 a->freedom == 2 ? m->row_count : m->count);
}

/* True if the result is a random sample: two or more redundant freedoms make the solutions surfaces. */
static bool is_sampled(const km_arm *a) {
  return a->freedom > 1;
}

/* Number of full turns within the limits of a single solution. */
static double turns_of(const km_arm *a, const double *shown, int *first, int *last) {
  double count = 1.0;
  for (int k = 0; k < a->n; ++k) {
    double q = km_arm_from_units(a, k, shown[k]);
    km_arm_full_turn_range(a, k, q, q, &first[k], &last[k]);
    count *= fmax(last[k] - first[k] + 1, 0);
  }
  return count;
}

static void add_turns(const km_arm *a, const double *shown, km_value *branch, km_arena *arena) {
  enum { MOST_LISTED = 1024 };
  int first[KM_ARM_MAX_JOINTS], last[KM_ARM_MAX_JOINTS];
  double count = turns_of(a, shown, first, last);
  km_value_number(arena, branch, "poses_within_limits", count);
  km_value *list = km_value_add(arena, branch, "configurations", KM_LIST);
  for (int i = 0; i < count && i < MOST_LISTED && !arena->failed; ++i) {
    km_value *pose = km_value_add(arena, list, NULL, KM_OBJECT);
    for (int k = 0, rest = i; k < a->n; ++k) {
      int ways = last[k] - first[k] + 1, turn = first[k] + rest % ways;
      rest /= ways;
      km_value_number(arena, pose, km_arm_label(a, k),
                      turn ? km_arm_to_units(a, k, km_arm_from_units(a, k, shown[k]) + 2.0 * M_PI * turn) : shown[k]);
    }
  }
  km_value_boolean(arena, branch, "truncated", count > MOST_LISTED);
}

km_value *km_ik_solutions_record(const km_arm *a, const km_ik_solutions *b, const char *model, km_arena *arena) {
  if (!a || !b || !model || !arena)
    return NULL;
  km_value *record = km_arm_record(a, model, arena);
  km_value_number(arena, record, "count", b->count);
  km_value_boolean(arena, record, "sampled", is_sampled(a));
  km_value_number(arena, record, "within_limits", b->within);
  km_value_boolean(arena, record, "confirmed", b->confirmed && !is_sampled(a));
  km_value_boolean(arena, record, "closed_form", b->closed_form);
  km_value_number(arena, record, "starts", b->starts);
  km_value_number(arena, record, "converged", b->converged);
  km_value *list = km_value_add(arena, record, "branches", KM_LIST);
  for (int i = 0; i < b->count && !arena->failed; ++i) {
    km_value *branch = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_number(arena, branch, "id", i + 1);
    if (a->freedom == 1)
      add_motion(a, &b->items[i], branch, arena);
    km_value_boolean(arena, branch, "singular", b->singular[i]);
    km_value_boolean(arena, branch, "within_limits", b->margin[i] >= 0.0);
    km_value_number(arena, branch, "limit_margin", b->margin[i]);
    km_value *pose = km_value_add(arena, branch, "configuration", KM_OBJECT);
    for (int k = 0; k < a->n; ++k)
      km_value_number(arena, pose, km_arm_label(a, k), b->pose[i * a->n + k]);
    if (a->freedom == 0 && b->margin[i] >= 0.0)
      add_turns(a, b->pose + i * a->n, branch, arena);
  }
  return arena->failed ? NULL : record;
}

static const double pose_rounding = 1e-9; /* file's units: poses are solved to about 1e-12 rad */

static void print_pose(const km_arm *a, const km_ik_solutions *b, int i, km_text *out) {
  int first[KM_ARM_MAX_JOINTS], last[KM_ARM_MAX_JOINTS];
  double turns = a->freedom == 0 && b->margin[i] >= 0.0 ? turns_of(a, b->pose + i * a->n, first, last) : 1.0;
  km_text_add(out, a->freedom > 0   ? "one pose of a family"
                   : b->singular[i] ? "a singular pose, perhaps one of a family"
                                    : "a pose");
  if (turns > 1.0)
    km_text_format(out, ", %g with the full turns that the limits leave room for", turns);
  km_text_add(out, "\n");
}

void km_ik_solutions_print(const km_arm *a, const km_ik_solutions *b, const char *name, km_text *out) {
  if (!a || !b || !name || !out)
    return;
  bool sampled = is_sampled(a);
  km_text_format(out, "%s: %s%d branch%s", name, sampled ? "a sample of " : "", b->count, b->count == 1 ? "" : "es");
  if (b->within < b->count)
    km_text_format(out, ", %d of them with poses within the limits", b->within);
  if (b->starts == 0)
    km_text_add(out, " (in closed form)\n");
  else
    km_text_format(out, " (%s%d solutions from %d starts)\n", b->closed_form ? "closed form, and " : "", b->converged,
                   b->starts);
  if (!sampled && !b->confirmed)
    km_text_add(out, "  the count isn't confirmed: there may be more\n");
  if (sampled)
    km_text_add(out, "  each is one pose of a family; how many are found depends on --seed\n");
  for (int i = 0; i < b->count; ++i) {
    km_text_format(out, "  %d: ", i + 1);
    if (a->freedom == 1 && b->items[i].count == 1)
      km_text_add(out, "singular poses: more than a curve\n");
    else if (a->freedom == 1)
      print_motion(a, &b->items[i], "       ", out);
    else
      print_pose(a, b, i, out);
    km_text_format(out, "     %s:", b->margin[i] >= 0.0 ? "best pose" : "never within the limits; nearest");
    for (int k = 0; k < a->n; ++k) {
      const double value = b->pose[i * a->n + k];
      km_text_format(out, "%s %s %.6g %s", k ? "," : "", km_arm_label(a, k), fabs(value) < pose_rounding ? 0.0 : value,
                     km_model_coordinate_unit(a->mechanism->model, a->coordinate[k]));
    }
    km_text_format(out, " (limit distance %.4g)\n", b->margin[i]);
  }
}
