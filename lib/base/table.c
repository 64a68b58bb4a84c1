/* Tables of numbers with named columns. */
#include "kmech/table.h"

#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

typedef struct column {
  const char *name, *unit;
  int plain;
} column;

struct km_table {
  km_arena arena;
  column *columns;
  double *data;
  size_t column_count, column_capacity, row_count, data_capacity;
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

static int add_column(km_table *table, const char *name, const char *unit, int plain) {
  void *columns = table->columns;
  if (!km_reserve(&columns, &table->column_capacity, table->column_count + 1, sizeof(column)))
    return -1;
  table->columns = columns;
  column new = {km_arena_string(&table->arena, name), km_arena_string(&table->arena, unit ? unit : ""), plain};
  if (table->arena.failed)
    return -1;
  table->columns[table->column_count] = new;
  return (int)table->column_count++;
}

int km_table_add_column(km_table *table, const char *name, const char *unit) {
  return add_column(table, name, unit, 0);
}

int km_table_add_plain_column(km_table *table, const char *name, const char *unit) {
  return add_column(table, name, unit, 1);
}

int km_table_is_plain(const km_table *table, size_t index) {
  return table->columns[index].plain;
}

double *km_table_add_row(km_table *table) {
  void *data = table->data;
  size_t used = table->row_count * table->column_count;
  if (!km_reserve(&data, &table->data_capacity, used + table->column_count, sizeof(double)))
    return NULL;
  table->data = data;
  for (size_t c = 0; c < table->column_count; ++c)
    table->data[used + c] = nan("");
  table->row_count++;
  return table->data + used;
}

size_t km_table_rows(const km_table *table) {
  return table->row_count;
}
size_t km_table_columns(const km_table *table) {
  return table->column_count;
}
const char *km_table_name(const km_table *table, size_t index) {
  return table->columns[index].name;
}
const char *km_table_unit(const km_table *table, size_t index) {
  return table->columns[index].unit;
}
const double *km_table_row(const km_table *table, size_t row) {
  return table->data + row * table->column_count;
}

int km_table_find(const km_table *table, const char *name) {
  for (size_t c = 0; c < table->column_count; ++c)
    if (strcmp(table->columns[c].name, name) == 0)
      return (int)c;
  return -1;
}

km_span km_table_span(const km_table *table, const char *prefix) {
  size_t length = strlen(prefix);
  km_span span = {0, 0};
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
