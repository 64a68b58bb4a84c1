/* kmob schema: the formats of models and of studies of designs, for editors and for the guide. */
#include "kmob/kmob.h"

#include "kmech/schema.h"

#define FORMATS "json or markdown"
#define FILES   "model or study"

kt_exit kmob_schema(int argc, char **argv) {
  kt_common common = KT_COMMON("kmob");
  const char *file = NULL;
  int markdown = 0, of = 0;
  kt_options all = {0};
  const kt_option table[] = {
      KMOB_FILE(&file),
      {"format", 0, "WORD", "json, the schema (default), or markdown, every key in tables", KT_WORD(FORMATS), &markdown,
       KT_ABOUT_FILES},
      {"of", 0, "WORD", "model (default), or study, what kstudy reads", KT_WORD(FILES), &of, KT_ABOUT_FILES},
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &common, 0);
  kt_options_read(&all, "The JSON schema of the model format, or of studies of designs.", argc, argv);
  if (markdown) {
    km_text text = {0};
    km_schema_markdown((km_schema)of, &text);
    kt_exit result = kmob_write_text(&common, file, &text);
    km_text_free(&text);
    return result;
  }
  km_arena arena = {0};
  const km_value *schema = km_schema_record((km_schema)of, &arena);
  kt_exit result = schema ? kmob_write_value(&common, file, schema) : KT_NO_MEMORY;
  km_arena_free(&arena);
  return result;
}
