/* Singular values over a sweep and their minima, as a record and as text. */
#include "report/record/singular_value_record.h"

#include "report/record/sweep_text.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdlib.h>

typedef enum kind { KIND_TOGGLE, KIND_GAIN, KIND_MINIMUM } kind;

typedef struct singularity {
  double s;
  kind kind;
  size_t index;   /* index of the sweep's toggle, branch point or minimum */
  int coordinate; /* joints of a toggle */
} singularity;

static int by_place(const void *a, const void *b) {
  const singularity *x = a, *y = b;
  if (x->s != y->s)
    return (x->s > y->s) - (x->s < y->s);
  return x->kind != y->kind ? (int)x->kind - (int)y->kind : (x->index > y->index) - (x->index < y->index);
}

static singularity *gather(const km_mobility_sweep *sweep, km_arena *arena, size_t *count) {
  const km_sweep *motion = &sweep->motion;
  singularity *list =
      KM_ARENA_NEW(arena, singularity, sweep->toggle_count + motion->branch_count + sweep->minimum_count);
  *count = 0;
  for (size_t i = 0; list && i < sweep->toggle_count; ++i)
    list[(*count)++] = (singularity){sweep->toggles[i].s, KIND_TOGGLE, i, sweep->toggles[i].coordinate};
  for (size_t i = 0; list && i < motion->branch_count; ++i)
    list[(*count)++] = (singularity){motion->branches[i].s, KIND_GAIN, i, -1};
  for (size_t i = 0; list && i < sweep->minimum_count; ++i)
    list[(*count)++] = (singularity){sweep->minima[i].s, KIND_MINIMUM, i, -1};
  if (list)
    qsort(list, *count, sizeof *list, by_place);
  return list;
}

static int by_coordinate(const void *a, const void *b) {
  return ((const singularity *)a)->coordinate - ((const singularity *)b)->coordinate;
}

/* Joints that are at a toggle together make one entry, in the model's order. Returns how many there are. */
static size_t add_toggle(const km_mechanism *m, singularity *list, size_t count, km_value *item, km_arena *arena) {
  size_t same = 0;
  const double s = list->s;
  km_text meaning = {0};
  km_value *joints = km_value_add(arena, item, "joints", KM_LIST);
  while (same < count && list[same].kind == KIND_TOGGLE && fabs(list[same].s - s) <= 1e-9 * (1.0 + fabs(s)))
    ++same;
  qsort(list, same, sizeof *list, by_coordinate);
  km_text_add(&meaning, "dead point: driving");
  for (size_t i = 0; i < same; ++i) {
    const char *label = m->model->coordinates[list[i].coordinate].label;
    km_value_string(arena, joints, NULL, label);
    km_text_format(&meaning, "%s %s", i ? "," : "", label);
  }
  km_text_add(&meaning, " moves nothing here");
  km_value_words(arena, item, "meaning", &meaning);
  return same;
}

static void add_gain(const km_branch_point *point, km_value *item, km_arena *arena) {
  km_text meaning = {0};
  km_text_format(&meaning, "gain of mobility: %d here; %d motion%s meet", point->mobility, point->branches,
                 km_plural(point->branches));
  km_value_number(arena, item, "mobility", point->mobility);
  km_value_words(arena, item, "meaning", &meaning);
}

void km_singularities_record(const km_mechanism *m, const km_mobility_sweep *sweep, km_value *record, km_arena *arena) {
  static const char *const kinds[] = {"toggle", "gain", "minimum"};
  size_t count, step;
  singularity *list = gather(sweep, arena, &count);
  km_value *out = km_value_add(arena, record, "singularities", KM_LIST);
  for (size_t i = 0; i < count && !arena->failed; i += step) {
    km_value *item = km_value_add(arena, out, NULL, KM_OBJECT);
    km_value_number(arena, item, "s", list[i].s);
    km_value_string(arena, item, "kind", kinds[list[i].kind]);
    step = 1;
    if (list[i].kind == KIND_TOGGLE) {
      step = add_toggle(m, list + i, count - i, item, arena);
    } else if (list[i].kind == KIND_GAIN) {
      add_gain(&sweep->motion.branches[list[i].index], item, arena);
    } else {
      km_value_number(arena, item, "singular_value", sweep->minima[list[i].index].number);
      km_value_string(arena, item, "meaning", "nearest to a gain of mobility");
    }
  }
  if (isnan(sweep->smallest.number)) {
    km_value_add(arena, record, "smallest_singular_value", KM_NULL);
    return;
  }
  km_value *smallest = km_value_add(arena, record, "smallest_singular_value", KM_OBJECT);
  km_value_number(arena, smallest, "value", sweep->smallest.number);
  km_value_number(arena, smallest, "s", sweep->smallest.s);
}

void km_singularities_print(const km_mobility_sweep *sweep, const char *unit, km_text *out) {
  if (isnan(sweep->smallest.number))
    return;
  km_text_format(out, "  nearest to a gain of mobility at %.6g%s: smallest kept singular value %.2g\n",
                 sweep->smallest.s, unit, sweep->smallest.number);
  for (size_t i = 0; i < sweep->minimum_count; ++i)
    if (sweep->minima[i].s != sweep->smallest.s)
      km_text_format(out, "    also a minimum at %.6g%s: %.2g\n", sweep->minima[i].s, unit, sweep->minima[i].number);
}
