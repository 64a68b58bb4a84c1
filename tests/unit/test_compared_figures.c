/* Merged figures of merit: what differs, by how much, and which is best. */
#include "report/document/comparison/compared_figures.h"
#include "report/document/comparison/comparison_page.h"

#include "support/shown.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const km_compared_row *row_named(const km_compared_rows *rows, const char *name) {
  for (size_t i = 0; i < rows->count; ++i)
    if (strcmp(rows->items[i].figure->name, name) == 0)
      return &rows->items[i];
  return NULL;
}

/* Spread = (max − min) / max(|max|, |min|); the best value by the figure's better side; primary figures first. */
static void figures_are_merged(void **state) {
  (void)state;
  km_document_maker k = {.count = 0};
  static km_compared_figures figures[3];
  static const double force[3] = {10.0, 8.0, 12.0}, angle[3] = {30.0, 45.0, 40.0}, reaction[3] = {1.0, 9.0, 5.0};
  memset(figures, 0, sizeof figures);
  for (int i = 0; i < 3; ++i) {
    km_compared_add(&figures[i], (km_compared_figure){"reaction", "N", reaction[i], KM_BETTER_LESS, NULL, true});
    km_compared_add(&figures[i], (km_compared_figure){"force", "N", force[i], KM_BETTER_LESS, "f.A", false});
    km_compared_add(&figures[i], (km_compared_figure){"angle", "deg", angle[i], KM_BETTER_MORE, "f.A", false});
    km_compared_add(&figures[i], (km_compared_figure){"stroke", "mm", 5.0 + 1e-9 * i, KM_BETTER_LESS, NULL, false});
    km_compared_add(&figures[i], (km_compared_figure){"rounding", "N", 1e-12 * i, KM_BETTER_LESS, NULL, false});
    if (i > 0)
      km_compared_add(&figures[i], (km_compared_figure){"extra", "rad", 2.0, KM_BETTER_NEITHER, "q.B", false});
  }
  const km_compared_rows rows = km_compared_merge(&k, figures, 3);
  assert_int_equal(rows.count, 5);
  assert_int_equal(rows.different, 4);
  assert_string_equal(rows.items[0].figure->name, "extra");
  assert_string_equal(rows.items[3].figure->name, "reaction");
  assert_string_equal(rows.items[4].figure->name, "stroke");
  assert_null(row_named(&rows, "rounding"));
  const km_compared_row *f = row_named(&rows, "force"), *a = row_named(&rows, "angle"), *e = row_named(&rows, "extra");
  assert_int_equal(f->best, 1);
  assert_near(f->spread, 4.0 / 12.0, 1e-15);
  assert_int_equal(a->best, 1);
  assert_near(a->spread, 15.0 / 45.0, 1e-15);
  assert_int_equal(e->best, -1);
  assert_true(isnan(e->values[0]) && e->values[1] == 2.0);
  assert_int_equal(row_named(&rows, "stroke")->best, -1);
  const char *columns[4];
  assert_int_equal(km_comparison_columns(&rows, columns, 4), 2);
  assert_string_equal(columns[0], "q.B");
  assert_string_equal(columns[1], "f.A");
  km_arena_free(&k.arena);
}

/* The greatest of each kind comes first, by spread; then the others. */
static void kinds_lead(void **state) {
  (void)state;
  km_document_maker k = {.count = 0};
  static km_compared_figures figures[2];
  static const char *const names[] = {"speed of A", "speed of B", "swing of A", "swing of B", "energy"};
  static const double greatest[] = {4.0, 5.0, 2.0, 3.0, 1.5}; /* over 1 */
  static const char *const order[] = {"speed of B", "swing of B", "energy", "speed of A", "swing of A"};
  memset(figures, 0, sizeof figures);
  for (int f = 0; f < 5; ++f) {
    km_compared_add(&figures[0], (km_compared_figure){names[f], "", 1.0, KM_BETTER_NEITHER, NULL, false});
    km_compared_add(&figures[1], (km_compared_figure){names[f], "", greatest[f], KM_BETTER_NEITHER, NULL, false});
  }
  const km_compared_rows rows = km_compared_merge(&k, figures, 2);
  assert_int_equal(rows.different, 5);
  for (int f = 0; f < 5; ++f)
    assert_string_equal(rows.items[f].figure->name, order[f]);
  km_arena_free(&k.arena);
}

/* The table of the page marks the best, whether things are columns or rows. */
static void the_best_is_marked(void **state) {
  (void)state;
  static const char *const names[6] = {"u", "v", "w", "x", "y", "z"};
  for (int count = 2; count <= 6; count += 4) {
    km_document_maker k = {.count = 0};
    static km_compared_figures figures[6];
    memset(figures, 0, sizeof figures);
    for (int i = 0; i < count; ++i)
      km_compared_add(&figures[i], (km_compared_figure){"force", "N", 10.0 - i, KM_BETTER_LESS, NULL, false});
    const km_compared_rows rows = km_compared_merge(&k, figures, count);
    km_comparison_page_add(&k, names, count, "variant", "variants", &rows);
    size_t marked = 0, cells = 0;
    char best[32];
    snprintf(best, sizeof best, "★ %d", 11 - count);
    for (size_t b = 0; b < k.count; ++b)
      for (size_t c = 0; k.blocks[b].kind == KM_BLOCK_TABLE && c < k.blocks[b].rows * k.blocks[b].columns; ++c) {
        ++cells;
        marked += strcmp(k.blocks[b].cells[c], best) == 0;
      }
    assert_int_equal(marked, 1);
    assert_int_equal(cells, 2 * (count + 1));
    km_arena_free(&k.arena);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(figures_are_merged),
      cmocka_unit_test(kinds_lead),
      cmocka_unit_test(the_best_is_marked),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
