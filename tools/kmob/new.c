/* kmob new: a model to start from. */
#include "kmob/kmob.h"

#include "kmob/dh_table.h"
#include "kmob/starters.h"

#include <string.h>

typedef struct options {
  kt_common common;
  const char *name, *file, *units, *dh;
  int kind, convention;
} options;

/* Millimetres and degrees by default. */
static kt_exit choose_units(const options *o, km_units *units) {
  *units = km_units_default();
  units->length = km_unit_find(KM_LENGTH, "mm");
  units->angle = km_unit_find(KM_ANGLE, "deg");
  return kmob_choose_units(&o->common, o->units, units);
}

/* Output path: -o unchanged, or the name with the extension of a model. */
static void choose_path(const options *o, km_text *path) {
  const char *name = o->file ? o->file : o->name;
  size_t length = strlen(name);
  bool complete = o->file || strcmp(name, "-") == 0 || (length > 5 && strcmp(name + length - 5, ".json") == 0);
  km_text_format(path, "%s%s", name, complete ? "" : ".json");
}

static kt_exit write_starter(const options *o, const km_units *units, const char *path) {
  if (!kt_may_write(&o->common, path))
    return KT_USAGE;
  km_text text = {0};
  kt_exit result = KT_DONE;
  if (o->dh)
    result = kmob_dh_write(&o->common, o->dh, o->convention == 1, units, &text);
  else
    kmob_starter_write(o->kind, units, &text);
  if (result == KT_DONE)
    result = kmob_write_text(&o->common, path, &text);
  km_text_free(&text);
  if (result == KT_DONE && strcmp(path, "-") != 0)
    kt_print_message(&o->common, KM_NOTE, "wrote %s; try: kmob %s %s", path, o->dh ? "draw" : "sweep", path);
  return result;
}

kt_exit kmob_new(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"name", "[NAME]", false, &o.name, NULL}};
  const kt_option table[] = {
      {"kind", 0, "KIND", "What to start from: " KMOB_KINDS, KT_WORD(KMOB_KINDS), &o.kind, KT_ABOUT_MODEL},
      {"dh", 0, "FILE.csv",
       "An arm by Denavit and Hartenberg's parameters: columns a, alpha, d, theta, and name, type (R, P, or F for fixed), "
       "min, max, mass; theta of a hinge and d of a slide are offsets",
       KT_INPUT, &o.dh, KT_ABOUT_MODEL},
      {"convention", 0, "WORD",
       "Of --dh: standard (default: rows Rz(theta) Tz(d) Tx(a) Rx(alpha)) or modified (Rx(alpha) Tx(a) Rz(theta) Tz(d), "
       "alpha and a of the link before)",
       KT_WORD("standard or modified"), &o.convention, KT_ABOUT_MODEL},
      {"units", 0, "LIST", "Units of the model: words or symbols, as mm,deg (default: mm, deg, kg, s, N)", KT_TEXT,
       &o.units, KT_ABOUT_MODEL},
      KMOB_FILE(&o.file),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FORCE);
  kt_options_read(&all, "Write NAME.json, or the file of -o, a model to start from; - is the standard output.", argc,
                  argv);
  const char *given = o.file ? o.file : o.name;
  if (!given || !given[0] || (o.file && o.name)) {
    kt_print_message(&o.common, KM_ERROR, "%s (kmob new --help)",
                     o.file && o.name ? "found a name and -o; expected one of them" : "no name is given");
    return KT_USAGE;
  }
  char room[KT_FILE_ROOM];
  if (kt_file_name(&o.common, "json", &o.file, room) != KT_DONE)
    return KT_USAGE;
  km_units units;
  km_text path = {0};
  kt_exit result = choose_units(&o, &units);
  choose_path(&o, &path);
  if (result == KT_DONE)
    result = path.data && !path.failed ? write_starter(&o, &units, path.data) : KT_NO_MEMORY;
  km_text_free(&path);
  return result;
}
