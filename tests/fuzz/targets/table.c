/* A CSV table: writing and reading it is bit-exact; and the text read as a path's poses. */
#include "target.h"

#include "kmech/arm.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static void check_same(const km_table *a, const km_table *b) {
  if (km_table_rows(a) != km_table_rows(b) || km_table_columns(a) != km_table_columns(b))
    fuzz_fail("a table that is written and read has another size");
  for (size_t r = 0; r < km_table_rows(a); ++r)
    for (size_t c = 0; c < km_table_columns(a); ++c) {
      double x = km_table_row(a, r)[c], y = km_table_row(b, r)[c];
      if (memcmp(&x, &y, sizeof x) != 0 && !(x != x && y != y))
        fuzz_fail("a number that is written and read is another one");
    }
}

static void read_table(const uint8_t *data, size_t size) {
  km_text text = {0}, written = {0};
  km_table *table = NULL, *again = NULL;
  km_error error = {0};
  km_text_bytes(&text, data, size);
  km_status status = km_csv_read(&text, "input", &table, &error);
  if (status) {
    if (status != KM_IO || !error.text[0] || table)
      fuzz_fail("a refused table has no reason, or stays");
  } else {
    km_csv_write(table, &written);
    if (km_csv_read(&written, "written", &again, &error))
      fuzz_fail("a table that was written isn't read");
    check_same(table, again);
  }
  km_table_free(again);
  km_table_free(table);
  km_text_free(&written);
  km_text_free(&text);
}

static void read_poses(const uint8_t *data, size_t size) {
  char path[64];
  km_error error = {0};
  km_study_def def = km_study_def_default();
  int file = memfd_create("poses", 0);
  if (file < 0 || write(file, data, size) != (ssize_t)size)
    fuzz_fail("no memory for a file");
  snprintf(path, sizeof path, "/proc/self/fd/%d", file);
  km_messages *messages = km_messages_create();
  km_status status = km_study_read_poses(path, (km_study_place){"--path", true}, messages, &def, &error);
  if (status && (!error.text[0] || (status != KM_USAGE && status != KM_IO && status != KM_MODEL)))
    fuzz_fail("refused poses have no reason");
  if (!status && def.path.plan.segment_count != 1)
    fuzz_fail("poses aren't one segment");
  km_study_def_free(&def);
  km_messages_free(messages);
  close(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  read_table(data, size);
  read_poses(data, size);
  return 0;
}
