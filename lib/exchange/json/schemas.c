/* Formats by name, for publication as schemas. */
#include "kmech/exchange.h"

#include "exchange/json/format/format.h"

static const struct {
  const km_object_format *format;
  const char *title;
  bool expressions;
} formats[KM_SCHEMAS] = {[KM_SCHEMA_MODEL] = {&km_format_model, "kmech model", true},
                         [KM_SCHEMA_DESIGNS] = {&km_format_designs, "kmech study of designs", true},
                         [KM_SCHEMA_PATHS] = {&km_format_study, "kmech path study", false}};

static bool is_known(km_schema of) {
  return (int)of >= 0 && of < KM_SCHEMAS;
}

const km_value *km_schema_record(km_schema of, km_arena *arena) {
  return is_known(of) && arena ? km_format_schema(formats[of].format, formats[of].title, formats[of].expressions, arena)
                               : NULL;
}

void km_schema_markdown(km_schema of, km_text *out) {
  if (is_known(of) && out)
    km_format_markdown(formats[of].format, out);
}
