/* Records and texts of clearances: at a configuration, and along a sweep. */
#include "report/record/sweep_text.h"

#include "base/memory.h"
#include "report/record/mobility_record.h"
#include "report/record/record.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_SHOWN = 6 }; /* lines of a list in a text */

/* A pair with its least clearance, to be sorted. */
typedef struct ranked {
  int pair;
  double distance;
} ranked;

static int by_distance(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  return x->distance != y->distance ? (x->distance < y->distance ? -1 : 1) : x->pair - y->pair;
}

static const char *length_unit(const km_mechanism *m) {
  return m->model->units.length->suffix;
}

static const char *body_name(const km_mechanism *m, int body) {
  return m->model->bodies[body].name;
}

/* "boom and cabin" */
static void pair_words(const km_mechanism *m, km_body_pair pair, km_text *out) {
  km_text_format(out, "%s and %s", body_name(m, pair.body[0]), body_name(m, pair.body[1]));
}

/* ---- What the pairs are */

static int count_left_out(const km_clearance *c, km_left_out reason) {
  int count = 0;
  for (int i = 0; i < km_clearance_left_out_count(c); ++i)
    count += km_clearance_left_out(c, i).reason == reason;
  return count;
}

static void print_left_out(const km_mechanism *m, const km_clearance *c, km_text *out) {
  int joined = count_left_out(c, KM_LEFT_OUT_JOINED) + count_left_out(c, KM_LEFT_OUT_RIGID),
      overlaps = count_left_out(c, KM_LEFT_OUT_OVERLAP), shown = 0;
  if (joined + overlaps == 0)
    return;
  km_text_add(out, "  left out:");
  if (joined > 0)
    km_text_format(out, " %d pair%s that joints connect", joined, km_plural(joined));
  if (overlaps > 0)
    km_text_format(out, "%s %d that overlap%s at the pose:", joined > 0 ? " and" : "", overlaps,
                   overlaps == 1 ? "s" : "");
  for (int i = 0; i < km_clearance_left_out_count(c) && overlaps > 0; ++i) {
    km_body_pair pair = km_clearance_left_out(c, i);
    if (pair.reason == KM_LEFT_OUT_OVERLAP && ++shown <= MOST_SHOWN) {
      km_text_add(out, shown > 1 ? ", " : " ");
      pair_words(m, pair, out);
    }
  }
  if (shown > MOST_SHOWN)
    km_text_format(out, ", and %d more", shown - MOST_SHOWN);
  km_text_add(out, overlaps > 0 ? " (--between asks for them)\n" : " (--between asks for one)\n");
}

/* Hulls that are farther from their meshes than rounding. */
static void print_hulls(const km_mechanism *m, const km_clearance *c, km_text *out) {
  static const double rounding = 1e-6; /* part of the characteristic length */
  int worst = -1, count = 0;
  for (int b = 0; b < m->model->body_count; ++b) {
    double off = km_clearance_hull_error(c, b);
    count += off > rounding * m->length;
    if (off > rounding * m->length && (worst < 0 || off > km_clearance_hull_error(c, worst)))
      worst = b;
  }
  if (count > 0)
    km_text_format(out,
                   "  meshes are convex hulls of their parts: %d bod%s from the surface by up to %.3g %s (%s), so that "
                   "distances are too small by at most that\n",
                   count, count == 1 ? "y differs" : "ies differ", km_clearance_hull_error(c, worst), length_unit(m),
                   body_name(m, worst));
}

static void add_bodies(const km_mechanism *m, km_body_pair pair, km_value *item, km_arena *arena) {
  km_value *bodies = km_value_add(arena, item, "bodies", KM_LIST);
  for (int k = 0; k < 2; ++k)
    km_value_string(arena, bodies, NULL, body_name(m, pair.body[k]));
}

/* `left_out` [{bodies, reason}] and `hulls` [{body, parts, error}]. */
static void add_choice(const km_mechanism *m, const km_clearance *c, km_value *record, km_arena *arena) {
  km_value *left_out = km_value_add(arena, record, "left_out", KM_LIST);
  for (int i = 0; i < km_clearance_left_out_count(c) && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, left_out, NULL, KM_OBJECT);
    add_bodies(m, km_clearance_left_out(c, i), item, arena);
    km_value_string(arena, item, "reason", km_left_out_word(km_clearance_left_out(c, i).reason));
  }
  km_value *hulls = km_value_add(arena, record, "hulls", KM_LIST);
  for (int b = 0; b < m->model->body_count && !arena->failed; ++b)
    if (km_clearance_hull_error(c, b) > 0.0) {
      km_value *item = km_value_add(arena, hulls, NULL, KM_OBJECT);
      km_value_string(arena, item, "body", body_name(m, b));
      km_value_number(arena, item, "parts", km_clearance_part_count(c, b));
      km_value_number(arena, item, "error", km_clearance_hull_error(c, b));
    }
}

/* ---- At a configuration */

km_value *km_clearance_record(const km_mechanism *m, const km_clearance *c, const km_pair_clearance *at,
                              const char *name, km_arena *arena) {
  if (!m || !c || !at || !name || !arena)
    return NULL;
  km_value *record = km_record_head(m, "kspace clearance", name, arena);
  km_value *pairs = km_value_add(arena, record, "pairs", KM_LIST);
  for (int i = 0; i < km_clearance_pair_count(c) && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, pairs, NULL, KM_OBJECT);
    add_bodies(m, km_clearance_pair(c, i), item, arena);
    km_value_number(arena, item, "clearance", at[i].distance);
    km_value_number(arena, item, "error", at[i].error);
    km_value *points = km_value_add(arena, item, "points", KM_LIST);
    for (int k = 0; k < 2; ++k)
      km_value_numbers(arena, points, NULL, at[i].point[k], 3);
    km_value_numbers(arena, item, "normal", at[i].normal, 3);
  }
  add_choice(m, c, record, arena);
  return arena->failed ? NULL : record;
}

/* Pairs by their distance. The caller frees them; NULL without memory. */
static ranked *rank_pairs(int count, const double *distance, size_t stride) {
  ranked *order = KM_NEW(ranked, (size_t)count + 1);
  for (int i = 0; i < count && order; ++i)
    order[i] = (ranked){i, distance[(size_t)i * stride]};
  if (order)
    qsort(order, (size_t)count, sizeof *order, by_distance);
  return order;
}

void km_clearance_print(const km_mechanism *m, const km_clearance *c, const km_pair_clearance *at, const char *name,
                        km_text *out) {
  if (!m || !c || !at || !name || !out)
    return;
  int count = km_clearance_pair_count(c);
  ranked *order = rank_pairs(count, &at->distance, sizeof *at / sizeof(double));
  if (!order) {
    out->failed = true;
    return;
  }
  const km_pair_clearance *least = &at[order[0].pair];
  km_text_format(out, "%s: ", name);
  if (least->distance < 0.0)
    km_text_format(out, "overlap of %.6g %s of ", -least->distance, length_unit(m));
  else
    km_text_format(out, "least clearance %.6g %s between ", least->distance, length_unit(m));
  pair_words(m, km_clearance_pair(c, order[0].pair), out);
  km_text_add(out, "\n");
  for (int i = 0; i < count && i < MOST_SHOWN; ++i) {
    const km_pair_clearance *d = &at[order[i].pair];
    km_text_format(out, "  %-12.6g  ", d->distance);
    pair_words(m, km_clearance_pair(c, order[i].pair), out);
    km_text_format(out, ", from (%.5g, %.5g, %.5g) to (%.5g, %.5g, %.5g)\n", d->point[0][0], d->point[0][1],
                   d->point[0][2], d->point[1][0], d->point[1][1], d->point[1][2]);
  }
  if (count > MOST_SHOWN)
    km_text_format(out, "  and %d more pairs, farther apart (--format json lists all)\n", count - MOST_SHOWN);
  print_left_out(m, c, out);
  print_hulls(m, c, out);
  km_free(order);
}

/* ---- Along a sweep */

void km_clearance_course_record(const km_mechanism *m, const km_clearance_course *course, km_value *record,
                                km_arena *arena) {
  const km_clearance *c = course->clearance;
  if (!c)
    return;
  km_value *clearance = km_value_add(arena, record, "clearances", KM_OBJECT);
  km_value *pairs = km_value_add(arena, clearance, "pairs", KM_LIST);
  for (int i = 0; i < course->pair_count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, pairs, NULL, KM_OBJECT);
    add_bodies(m, km_clearance_pair(c, i), item, arena);
    km_value_number(arena, item, "least", course->least[i].number);
    km_value_number(arena, item, "least_at", course->least[i].s);
  }
  km_value_number(arena, clearance, "least", course->smallest.number);
  km_value_number(arena, clearance, "least_at", course->smallest.s);
  km_value *contacts = km_value_add(arena, clearance, "contacts", KM_LIST);
  for (size_t i = 0; i < course->contact_count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, contacts, NULL, KM_OBJECT);
    add_bodies(m, km_clearance_pair(c, course->contacts[i].pair), item, arena);
    km_value_number(arena, item, "s", course->contacts[i].s);
    km_value_boolean(arena, item, "separates", course->contacts[i].separates);
  }
  add_choice(m, c, clearance, arena);
}

/* Name of the variable, "A" or "arc length". */
static const char *variable(const km_mechanism *m, const km_sweep_plan *plan) {
  return plan->arclength > 0.0 ? "arc length" : m->model->coordinates[plan->coordinate].label;
}

static void print_contact(const km_mechanism *m, const km_sweep_plan *plan, const km_clearance_course *course,
                          const km_contact_event *e, km_text *out) {
  km_text_add(out, "  ");
  pair_words(m, km_clearance_pair(course->clearance, e->pair), out);
  km_text_format(out, e->separates ? " are apart from %s = %.9g%s\n" : " touch from %s = %.9g%s\n", variable(m, plan),
                 e->s, km_sweep_unit(m, plan));
}

static void print_least(const km_mechanism *m, const km_sweep_plan *plan, const km_clearance_course *course,
                        km_text *out) {
  ranked *order = KM_NEW(ranked, (size_t)course->pair_count + 1);
  for (int i = 0; i < course->pair_count && order; ++i)
    order[i] = (ranked){i, course->least[i].number};
  if (!order) {
    out->failed = true;
    return;
  }
  qsort(order, (size_t)course->pair_count, sizeof *order, by_distance);
  if (course->pair_count > 1)
    km_text_add(out, "  least clearance of the pairs:\n");
  for (int i = 0; i < course->pair_count && i < MOST_SHOWN && course->pair_count > 1; ++i) {
    km_text_format(out, "    %.6g %s  ", order[i].distance, length_unit(m));
    pair_words(m, km_clearance_pair(course->clearance, order[i].pair), out);
    km_text_format(out, " (%.6g%s)\n", course->least[order[i].pair].s, km_sweep_unit(m, plan));
  }
  if (course->pair_count > MOST_SHOWN)
    km_text_format(out, "    and %d more pairs, farther apart (--format json lists all)\n",
                   course->pair_count - MOST_SHOWN);
  km_free(order);
}

void km_clearance_course_print(const km_mechanism *m, const km_sweep_plan *plan, const km_clearance_course *course,
                               km_text *out) {
  if (!course->clearance || course->smallest_pair < 0)
    return;
  if (course->smallest.number < 0.0)
    km_text_format(out, "  overlap of up to %.6g %s of ", -course->smallest.number, length_unit(m));
  else
    km_text_format(out, "  least clearance %.6g %s between ", course->smallest.number, length_unit(m));
  pair_words(m, km_clearance_pair(course->clearance, course->smallest_pair), out);
  km_text_format(out, " at %s = %.6g%s\n", variable(m, plan), course->smallest.s, km_sweep_unit(m, plan));
  for (size_t i = 0; i < course->contact_count && i < MOST_SHOWN; ++i)
    print_contact(m, plan, course, &course->contacts[i], out);
  if (course->contact_count > MOST_SHOWN)
    km_text_format(out, "  and %zu more contacts (--format json lists all)\n", course->contact_count - MOST_SHOWN);
  print_least(m, plan, course, out);
  print_left_out(m, course->clearance, out);
  print_hulls(m, course->clearance, out);
}

km_value *km_clearance_sweep_record(const km_mechanism *m, const km_clearance_sweep *sweep, const char *stopped_by,
                                    const char *name, km_arena *arena) {
  km_value *record = km_record_head(m, "kspace clearance", name, arena);
  km_table_record(sweep->motion.table, record, arena);
  km_clearance_course_record(m, &sweep->course, record, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}

void km_clearance_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_clearance_sweep *sweep,
                              const char *name, km_text *out) {
  km_sweep_print_range(m, plan, &sweep->motion, name, out);
  km_clearance_course_print(m, plan, &sweep->course, out);
  km_sweep_print_mobility(m, plan, &sweep->motion, out);
}
