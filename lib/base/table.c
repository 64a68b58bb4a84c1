/* Tables of numbers with named columns. */
#include "base/table.h"

#include "base/arguments.h"
#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef struct column {
  const char *name, *unit;
  bool plain;
} column;

struct km_table {
  km_arena arena;
  column *columns;
  double *data;
  size_t column_count, column_capacity, row_count, data_capacity;
  size_t kept_columns; /* before the table was restarted; 0 if other columns have been added since */
};

km_table *km_table_create(void) {
  return KM_NEW(km_table, 1);
}

void km_table_free(km_table *table) {
  if (!table)
    return;
  km_arena_free(&table->arena);
  km_free(table->columns);
  km_free(table->data);
  km_free(table);
}

km_table *km_table_restart(km_table *table) {
  if (!table)
    return km_table_create();
  if (table->column_count > table->kept_columns)
    table->kept_columns = table->column_count;
  table->column_count = 0;
  table->row_count = 0;
  return table;
}

/* A column name in three parts. */
typedef struct title {
  const char *prefix, *name, *suffix;
} title;

/* The rest of `text` after its beginning `part`; NULL if it begins otherwise, or for NULL. */
static const char *behind(const char *text, const char *part) {
  for (; text && *part; ++text, ++part)
    if (*text != *part)
      return NULL;
  return text;
}

static bool is_called(const char *text, const title *t) {
  const char *end = behind(behind(behind(text, t->prefix), t->name), t->suffix);
  return end && !*end;
}

static char *joined(km_arena *arena, const title *t) {
  size_t prefix = strlen(t->prefix), name = strlen(t->name), suffix = strlen(t->suffix);
  char *text = km_arena_alloc(arena, prefix + name + suffix + 1, 1);
  if (text) {
    memcpy(text, t->prefix, prefix);
    memcpy(text + prefix, t->name, name);
    memcpy(text + prefix + name, t->suffix, suffix + 1);
  }
  return text;
}

/* True if the next column had this name before the table was restarted. */
static bool is_kept(const km_table *table, const title *t, const char *unit, bool plain) {
  if (table->column_count >= table->kept_columns)
    return false;
  const column *kept = &table->columns[table->column_count];
  return is_called(kept->name, t) && strcmp(kept->unit, unit) == 0 && kept->plain == plain;
}

static int add_column(km_table *table, const title *t, const char *unit, bool plain) {
  if (!table || !t->name || table->row_count > 0)
    return -1;
  if (!is_kept(table, t, unit ? unit : "", plain)) {
    void *columns = table->columns;
    if (!km_reserve(&columns, &table->column_capacity, table->column_count + 1, sizeof(column)))
      return -1;
    table->columns = columns;
    column new = {joined(&table->arena, t), km_arena_string(&table->arena, unit ? unit : ""), plain};
    if (table->arena.failed)
      return -1;
    table->columns[table->column_count] = new;
    table->kept_columns = 0;
  }
  return (int)table->column_count++;
}

bool km_table_add_joined_column(km_table *table, const char *prefix, const char *name, const char *suffix,
                                const char *unit) {
  return add_column(table, &(title){prefix, name, suffix}, unit, false) >= 0;
}

int km_table_add_column(km_table *table, const char *name, const char *unit) {
  return add_column(table, &(title){"", name, ""}, unit, false);
}

int km_table_add_plain_column(km_table *table, const char *name, const char *unit) {
  return add_column(table, &(title){"", name, ""}, unit, true);
}

bool km_table_is_plain(const km_table *table, size_t index) {
  if (!table || index >= table->column_count)
    return false;
  return table->columns[index].plain;
}

static bool reserve(km_table *table, size_t numbers) {
  void *data = table->data;
  bool made = km_reserve(&data, &table->data_capacity, numbers, sizeof(double));
  table->data = data;
  return made;
}

bool km_table_reserve(km_table *table, size_t rows) {
  if (!table || (table->column_count && rows > SIZE_MAX / 16 / table->column_count))
    return false;
  return reserve(table, rows * table->column_count);
}

double *km_table_add_raw_rows(km_table *table, size_t count) {
  size_t used = table->row_count * table->column_count, end = used + count * table->column_count;
  if (end > table->data_capacity && !reserve(table, end))
    return NULL;
  table->row_count += count;
  return table->data + used;
}

double *km_table_add_row(km_table *table) {
  double *cells = table ? km_table_add_raw_rows(table, 1) : NULL;
  for (size_t c = 0; cells && c < table->column_count; ++c)
    cells[c] = nan("");
  return cells;
}

void km_table_drop_row(km_table *table) {
  if (table->row_count > 0)
    table->row_count--;
}

size_t km_table_rows(const km_table *table) {
  if (!table)
    return 0;
  return table->row_count;
}
size_t km_table_columns(const km_table *table) {
  if (!table)
    return 0;
  return table->column_count;
}
const char *km_table_name(const km_table *table, size_t index) {
  if (!table || index >= table->column_count)
    return "";
  return table->columns[index].name;
}
const char *km_table_unit(const km_table *table, size_t index) {
  if (!table || index >= table->column_count)
    return "";
  return table->columns[index].unit;
}
double *km_table_cells(km_table *table, size_t row) {
  return table && row < table->row_count ? table->data + row * table->column_count : NULL;
}

const double *km_table_row(const km_table *table, size_t row) {
  if (!table || row >= table->row_count)
    return NULL;
  return table->data + row * table->column_count;
}

km_status km_table_column(const km_table *table, size_t index, double *values, km_error *error) {
  km_status status = km_check_given(table && values, "table or place for the values", error);
  if (status)
    return status;
  if (index >= table->column_count)
    return km_fail(error, KM_USAGE, "there is no column %zu; the table has %zu", index, table->column_count);
  for (size_t r = 0; r < table->row_count; ++r)
    values[r] = table->data[r * table->column_count + index];
  return KM_OK;
}

int km_table_find(const km_table *table, const char *name) {
  if (!table || !name)
    return -1;
  for (size_t c = 0; c < table->column_count; ++c)
    if (*table->columns[c].name == *name && strcmp(table->columns[c].name, name) == 0)
      return (int)c;
  return -1;
}

km_span km_table_span(const km_table *table, const char *prefix) {
  km_span span = {0, 0};
  if (!table || !prefix)
    return span;
  size_t length = strlen(prefix);
  for (size_t c = 0; c < table->column_count; ++c) {
    bool fits = strncmp(table->columns[c].name, prefix, length) == 0;
    if (fits && span.count == 0)
      span.first = c;
    else if (!fits && span.count > 0)
      break;
    span.count += fits;
  }
  return span;
}
