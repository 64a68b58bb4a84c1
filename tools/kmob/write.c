/* Commands that write model files: file and units. */
#include "kmob/kmob.h"

#include "kmech/base.h"
#include "kmech/data.h"

kt_exit kmob_write_text(const kt_common *common, const char *file, const km_text *text) {
  km_error error;
  km_status status = km_file_write(file ? file : "-", text, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  return kt_exit_of(status);
}

kt_exit kmob_write_value(const kt_common *common, const char *file, const km_value *value) {
  km_text text = {0};
  km_json_write(value, &text);
  kt_exit result = kmob_write_text(common, file, &text);
  km_text_free(&text);
  return result;
}

/* A unit's word or symbol decides which quantity it is for: -1 if none. */
static int choose_unit(const char *word, km_units *units) {
  for (int q = 0; q < KM_QUANTITIES; ++q) {
    const km_unit *unit = km_unit_find((km_quantity)q, word);
    if (!unit)
      continue;
    *km_units_slot(units, (km_quantity)q) = unit;
    return q;
  }
  return -1;
}

kt_exit kmob_choose_units(const kt_common *common, const char *list, km_units *units) {
  const char *rest = list;
  bool chosen[KM_QUANTITIES] = {false};
  for (char last = list ? ',' : 0; last == ',';) {
    kt_piece piece = kt_split(&rest, ",");
    int quantity = choose_unit(piece.text, units);
    last = piece.separator;
    if (quantity < 0)
      kt_print_message(
          common, KM_ERROR,
          "--units %s: \"%s\" is not a unit; expected some of radians degrees, meters millimeters centimeters inches, "
          "kilograms grams pounds, seconds milliseconds, newtons pounds-force",
          list, piece.text);
    else if (chosen[quantity])
      kt_print_message(common, KM_ERROR, "--units %s: \"%s\" is a second unit of %s; expected one", list, piece.text,
                       km_quantity_name((km_quantity)quantity));
    km_free(piece.text);
    if (quantity < 0 || chosen[quantity])
      return KT_USAGE;
    chosen[quantity] = true;
  }
  return KT_DONE;
}
