/* Base services: numbers as text, names, records, JSON, tables, CSV. */
#include "support/support.h"

#include "report/document/escape.h"

#include "base/memory.h"
#include "base/name_map.h"
#include "base/table.h"
#include "exchange/json/json.h"
#include "kmech/report.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check_number(double value, const char *expected) {
  char text[KM_NUMBER_TEXT];
  size_t length = km_number_format(text, value);
  assert_int_equal(length, strlen(text));
  if (expected)
    assert_string_equal(text, expected);
  assert_true(strtod(text, NULL) == value);
}

static void numbers_are_shortest_and_exact(void **state) {
  (void)state;
  check_number(0.1, "0.1");
  check_number(1.0 / 3.0, "0.3333333333333333");
  check_number(0.1 + 0.2, "0.30000000000000004");
  check_number(-0.0, "-0");
  check_number(1e22, "1e+22");
  check_number(5e-324, "5e-324");
  check_number(DBL_MAX, "1.7976931348623157e+308");
  check_number(HUGE_VAL, "inf");
  check_number(-HUGE_VAL, "-inf");
  randomness r = {1};
  for (int i = 0; i < 20000; ++i)
    check_number(uniform(&r, -1.0, 1.0) * pow(10.0, uniform(&r, -300.0, 300.0)), NULL);
}

static void names_keep_their_scopes(void **state) {
  (void)state;
  km_names names = {0};
  char text[1000][16];
  for (int i = 0; i < 1000; ++i) {
    snprintf(text[i], sizeof text[i], "n%d", i);
    assert_true(km_names_set(&names, i % 7, text[i], i));
  }
  for (int i = 0; i < 1000; ++i) {
    assert_int_equal(km_names_get(&names, i % 7, text[i]), i);
    assert_int_equal(km_names_get(&names, i % 7 + 1, text[i]), -1);
  }
  km_names_free(&names);
}

static const km_value *parse(const char *text, km_arena *arena) {
  const km_value *root = NULL;
  km_error error;
  if (km_json_parse(text, strlen(text), arena, &root, &error))
    fail_msg("%s", error.text);
  return root;
}

static void json_comes_back(void **state) {
  (void)state;
  const char *text =
      "\xEF\xBB\xBF{\"a\": [1, 2.5, -3e-7], \"b\\\"\\n\": {\"c\": null, \"d\": true}, \"e\": \"ä\\u0007\"}";
  km_arena arena = {0};
  km_text first = {0}, second = {0};
  km_json_write(parse(text, &arena), &first);
  km_json_write(parse(first.data, &arena), &second);
  assert_string_equal(first.data, second.data);
  assert_non_null(strstr(first.data, "\\u0007"));
  km_text_free(&first);
  km_text_free(&second);
  km_arena_free(&arena);
}

static void bad_json_has_a_place(void **state) {
  (void)state;
  static const char *const bad[] = {"{",       "[1,",  "{\"a\": 1, \"a\": 2}", "[NaN]",
                                    "[1e999]", "[01]", "\"\\u0000\"",          "[1] x"};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
    km_arena arena = {0};
    const km_value *root;
    km_error error;
    assert_int_equal(km_json_parse(bad[i], strlen(bad[i]), &arena, &root, &error), KM_MODEL);
    assert_non_null(strstr(error.text, "line 1, column"));
    km_arena_free(&arena);
  }
}

static void blank_json_is_told_as_empty(void **state) {
  (void)state;
  static const char *const blank[] = {"", " ", "\n\t\r\n"};
  for (size_t i = 0; i < sizeof blank / sizeof *blank; ++i) {
    km_arena arena = {0};
    const km_value *root;
    km_error error;
    assert_int_equal(km_json_parse(blank[i], strlen(blank[i]), &arena, &root, &error), KM_MODEL);
    assert_string_equal(error.text, "the text is empty; expected JSON text");
    km_arena_free(&arena);
  }
}

static void csv_quotes_what_needs_it(void **state) {
  (void)state;
  km_table *table = km_table_create();
  assert_int_equal(km_table_add_column(table, "s", NULL), 0);
  assert_int_equal(km_table_add_column(table, "q.a,\"b\"", "mm"), 1);
  double *row = km_table_add_row(table);
  row[0] = 0.5;
  row[1] = HUGE_VAL;
  km_table_add_row(table);
  km_text out = {0};
  km_csv_write(table, &out);
  assert_string_equal(out.data, "s,\"q.a,\"\"b\"\"_mm\"\r\n0.5,inf\r\nnan,nan\r\n");
  assert_int_equal(km_table_find(table, "q.a,\"b\""), 1);
  km_span span = km_table_span(table, "q."), none = km_table_span(table, "r.");
  assert_true(span.first == 1 && span.count == 1 && none.count == 0);
  km_text_free(&out);
  km_table_free(table);
}

/* Whatever columns it had, it has those that are added now. */
static void tables_begin_again(void **state) {
  (void)state;
  static const char *const sets[][3] = {
      {"s", "q.a", "q.b"}, {"s", "q.a", "q.b"}, {"s", "q.ab", "q.b"}, {"s", "q.b", "m.b"}, {"s", "q.b", NULL}};
  km_table *table = km_table_restart(NULL);
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k) {
    table = km_table_restart(table);
    assert_int_equal(km_table_rows(table), 0);
    assert_int_equal(km_table_columns(table), 0);
    size_t count = sets[k][2] ? 3 : 2;
    assert_int_equal(km_table_add_plain_column(table, sets[k][0], k % 2 ? "mm" : "deg"), 0);
    for (size_t c = 1; c < count; ++c)
      assert_true(km_table_add_joined_column(table, c == 1 ? "q." : "", sets[k][c] + (c == 1 ? 2 : 0), "", "rad"));
    double *row = km_table_add_row(table);
    for (size_t c = 0; c < count; ++c) {
      assert_string_equal(km_table_name(table, c), sets[k][c]);
      assert_string_equal(km_table_unit(table, c), c ? "rad" : k % 2 ? "mm" : "deg");
      assert_true(isnan(row[c]));
    }
    assert_true(km_table_is_plain(table, 0) && !km_table_is_plain(table, 1));
    assert_int_equal(km_table_columns(table), count);
  }
  km_table_free(table);
}

/* The extreme row is the first one whose value no other row exceeds, whatever the values are. */
static void extremes_are_the_first_of_their_kind(void **state) {
  (void)state;
  static const double values[] = {(double)NAN, -HUGE_VAL, HUGE_VAL, -0.0, 0.0, 1.0, -1.0};
  enum { KINDS = sizeof values / sizeof *values, MOST = 9 };
  randomness random = {5};
  for (int trial = 0; trial < 2000; ++trial) {
    km_table *table = km_table_create();
    size_t rows = (size_t)trial % (MOST + 1);
    km_table_add_column(table, "x", "");
    km_table_add_column(table, "y", "");
    for (size_t r = 0; r < rows; ++r)
      km_table_add_row(table)[1] = values[below(&random, trial % 2 ? 2 : KINDS)];
    for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
      size_t first = rows;
      for (size_t r = rows; r-- > 0;) {
        double value = sign * km_table_row(table, r)[1];
        if (!isnan(value) && (first == rows || value <= sign * km_table_row(table, first)[1]))
          first = r;
      }
      assert_int_equal(km_table_extreme_row(table, 1, sign), first);
    }
    km_table_free(table);
  }
}

/* Recycled memory is zeroed, whatever its size. */
static void arenas_are_passed_on(void **state) {
  (void)state;
  km_arena memory = {0};
  for (size_t round = 0; round < 4; ++round) {
    km_arena arena = km_arena_reuse(&memory);
    assert_null(memory.block);
    for (size_t size = 100; size < 100000; size *= 3) {
      unsigned char *bytes = KM_ARENA_NEW(&arena, unsigned char, size);
      for (size_t i = 0; i < size; ++i)
        assert_int_equal(bytes[i], 0);
      memset(bytes, 0xff, size);
    }
    km_arena_recycle(&arena, round % 2 ? NULL : &memory);
    assert_null(arena.block);
    assert_true((memory.block != NULL) == (round % 2 == 0));
  }
  km_arena_free(&memory);
}

static void messages_stop_at_twenty_errors(void **state) {
  (void)state;
  km_messages *messages = km_messages_create();
  for (int i = 0; i < 50; ++i)
    km_messages_add(messages, KM_ERROR, "error %d", i);
  km_messages_add(messages, KM_NOTE, "a note");
  assert_int_equal(km_messages_errors(messages), 50);
  assert_int_equal(km_messages_count(messages), 21);
  assert_string_equal(km_messages_text(messages, 19), "error 19");
  km_messages_free(messages);
}

/* Controls, also those of two and three bytes, are shown; line ends, tabs, letters of any script and bytes that are
 * no UTF-8 stay. */
static void controls_are_shown(void **state) {
  (void)state;
  static const char *const texts[][2] = {{"", ""},
                                         {"a\tb\n", "a\tb\n"},
                                         {"\033[2J\a\r\177", "\\u001b[2J\\u0007\\u000d\\u007f"},
                                         {"\302\233x\302\240", "\\u009bx\302\240"},
                                         {"\342\200\256ab\342\201\251\330\234", "\\u202eab\\u2069\\u061c"},
                                         {"\342\200\231 \303\251 \346\227\245", "\342\200\231 \303\251 \346\227\245"},
                                         {"\342\200", "\342\200"},
                                         {"\377", "\377"}};
  for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
    km_text shown = {0}, page = {0};
    km_text_visible(&shown, texts[i][0], strlen(texts[i][0]));
    assert_string_equal(shown.data ? shown.data : "", texts[i][1]);
    km_html_escape(texts[i][0], &page);
    assert_string_equal(page.data ? page.data : "", texts[i][1]);
    km_text_free(&shown);
    km_text_free(&page);
  }
  km_text page = {0};
  km_html_escape("<a\033&\"b>", &page);
  assert_string_equal(page.data, "&lt;a\\u001b&amp;&quot;b&gt;");
  km_text_free(&page);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(controls_are_shown),
      cmocka_unit_test(numbers_are_shortest_and_exact),
      cmocka_unit_test(names_keep_their_scopes),
      cmocka_unit_test(json_comes_back),
      cmocka_unit_test(bad_json_has_a_place),
      cmocka_unit_test(blank_json_is_told_as_empty),
      cmocka_unit_test(csv_quotes_what_needs_it),
      cmocka_unit_test(tables_begin_again),
      cmocka_unit_test(extremes_are_the_first_of_their_kind),
      cmocka_unit_test(arenas_are_passed_on),
      cmocka_unit_test(messages_stop_at_twenty_errors),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
