/* kmob schema: the formats of models and of studies, for editors, for the guide and for manual pages. */
#include "kmob/kmob.h"

#include "common/command_line/roff.h"

#include "kmech/exchange.h"

#define FORMATS "json or markdown or roff"
#define FILES   "model or study or path"

enum { JSON, MARKDOWN, ROFF }; /* as FORMATS */

static kt_exit write_keys(const kt_common *common, const char *file, km_schema of, bool roff) {
  km_text tables = {0}, page = {0};
  km_schema_markdown(of, &tables);
  if (roff && tables.size)
    kt_roff_keys(tables.data, &page);
  page.failed = page.failed || tables.failed;
  kt_exit result = page.failed ? KT_NO_MEMORY : kmob_write_text(common, file, roff ? &page : &tables);
  km_text_free(&tables);
  km_text_free(&page);
  return result;
}

kt_exit kmob_schema(int argc, char **argv) {
  kt_common common = KT_COMMON("kmob");
  const char *file = NULL;
  int format = 0, of = 0;
  kt_options all = {0};
  const kt_option table[] = {
      KMOB_FILE(&file),
      {"format", 0, "WORD", "json, the schema (default); every key as markdown tables, or as roff of a manual page",
       KT_WORD(FORMATS), &format, KT_ABOUT_FILES},
      {"of", 0, "WORD", "model (default), study, what kstudy reads, or path, what kredund reads", KT_WORD(FILES), &of,
       KT_ABOUT_FILES},
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &common, 0);
  kt_options_read(&all, "The JSON schema of the model format, or of studies.", argc, argv);
  char room[KT_FILE_ROOM]; /* the endings of manual pages are numbers */
  const char *words = format == JSON ? "json" : "md or markdown";
  if (format != ROFF && kt_file_name(&common, words, &file, room) != KT_DONE)
    return KT_USAGE;
  if (format != JSON)
    return write_keys(&common, file, (km_schema)of, format == ROFF);
  km_arena arena = {0};
  const km_value *schema = km_schema_record((km_schema)of, &arena);
  kt_exit result = schema ? kmob_write_value(&common, file, schema) : KT_NO_MEMORY;
  km_arena_free(&arena);
  return result;
}
