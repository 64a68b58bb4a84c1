/* Output files and their formats. */
#include "common/common.h"

#include "kmech/base.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const words[KT_FORMATS] = {"csv", "json", "xlsx", "svg", "pdf", "png", "html", "apng", "dxf"};

const char *kt_format_word(kt_format format) {
  return words[format];
}

km_picture_format kt_picture_format(kt_format format) {
  return format == KT_PDF ? KM_PICTURE_PDF : format == KT_PNG ? KM_PICTURE_PNG : KM_PICTURE_SVG;
}

static int find_format(const char *word) {
  for (int f = 0; f < KT_FORMATS; ++f)
    if (strcmp(word, words[f]) == 0)
      return f;
  return -1;
}

/* True if a word is in a comma-separated list. */
static bool stands_in(const char *list, const char *word) {
  size_t length = strlen(word);
  for (const char *at = list; *at; at += strcspn(at, ","), at += *at == ',')
    if (strcspn(at, ",") == length && memcmp(at, word, length) == 0)
      return true;
  return false;
}

bool kt_formats_parse_among(const kt_common *common, const char *text, const char *among, kt_formats *out) {
  *out = (kt_formats){{0}};
  const char *rest = text;
  bool good = true;
  for (char last = ','; last == ',' && good;) {
    kt_piece piece = kt_split(&rest, ",");
    int found = find_format(piece.text);
    last = piece.separator;
    good = found >= 0 && stands_in(among, words[found]);
    if (good)
      out->wanted[found] = true;
    else if (found >= 0)
      kt_print_message(common, KM_ERROR, "--format %s: expected some of %s", piece.text, among);
    else
      kt_print_message(common, KM_ERROR, "--format %s: \"%s\" is not a format; expected some of %s", text, piece.text,
                       among);
    km_free(piece.text);
  }
  return good;
}

bool kt_formats_parse(const kt_common *common, const char *text, kt_formats *out) {
  return kt_formats_parse_among(common, text, "csv,json,xlsx,svg,pdf,png", out);
}

int kt_formats_count(const kt_formats *formats) {
  int count = 0;
  for (int f = 0; f < KT_FORMATS; ++f)
    count += formats->wanted[f];
  return count;
}

bool kt_is_piped(const char *base) {
  return base && strcmp(base, "-") == 0;
}

kt_exit kt_write(const kt_common *common, const char *base, const char *result, const char *format,
                 const km_text *bytes) {
  if (kt_is_piped(base))
    return isatty(STDOUT_FILENO) ? kt_print(common, bytes) : kt_print_bytes(common, bytes);
  km_text path = {0};
  km_text_format(&path, "%s.%s.%s", base, result, format);
  kt_exit written = path.failed ? KT_NO_MEMORY : kt_write_file(common, path.data, bytes);
  if (path.failed)
    kt_print_message(common, KM_ERROR, "out of memory");
  km_text_free(&path);
  return written;
}

/* Extension of a file name; "" if it isn't a word. */
static const char *ending_of(const char *path) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
  bool word = dot && dot != name && isalpha((unsigned char)dot[1]);
  for (const char *c = word ? dot + 1 : ""; *c; ++c)
    word = word && isalnum((unsigned char)*c);
  return word ? dot + 1 : "";
}

kt_exit kt_file_name(const kt_common *common, const char *kinds, const char **file, char room[KT_FILE_ROOM]) {
  struct stat there;
  if (!*file || strcmp(*file, "-") == 0)
    return KT_DONE;
  const char *ending = ending_of(*file);
  if (kt_word_place(kinds, ending) >= 0 || (stat(*file, &there) == 0 && !S_ISREG(there.st_mode)))
    return KT_DONE;
  if (ending[0]) {
    char expected[256] = "";
    for (const char *c = kinds; *c && strlen(expected) + 8 < sizeof expected;) {
      size_t length = strcspn(c, " ");
      snprintf(expected + strlen(expected), sizeof expected - strlen(expected), "%s.%.*s", c == kinds ? "" : " or ",
               (int)length, c);
      c += length;
      c += *c ? strlen(" or ") : 0;
    }
    kt_print_message(common, KM_ERROR, "-o %s: this command writes no .%s; expected a name that ends with %s", *file,
                     ending, expected);
    return KT_USAGE;
  }
  snprintf(room, KT_FILE_ROOM, "%s.%.*s", *file, (int)strcspn(kinds, " "), kinds);
  *file = room;
  return KT_DONE;
}

const char *kt_foreign_ending(const char *base, const char *const *lists) {
  static const char all[] =
      "csv or json or svg or pdf or png or html or apng or dxf or txt or dot or xlsx or docx or odt or ods or tex or md or "
      "xml or urdf or sdf or step or stp or iges or igs or stl or obj or ply or dae or dwg or gif or mp4 or webm or jpg or jpeg "
      "or eps or ps or xls or doc or ppt or pptx or htm or mat or sqlite or zip";
  const char *ending = ending_of(base);
  bool known = ending[0] && kt_word_place(all, ending) >= 0;
  for (; *lists && known; ++lists)
    known = kt_word_place(*lists, ending) < 0;
  return known ? ending : NULL;
}

void kt_note_size(const kt_common *common, double numbers) {
  const double bytes = 20.0, told = 100e6;
  kt_common loud = *common;
  loud.quiet = false;
  if (numbers * bytes > told)
    kt_print_message(&loud, KM_NOTE, "about %.0f MB are written", numbers * bytes / 1e6);
}

bool kt_may_write(const kt_common *common, const char *path) {
  struct stat there;
  if (common->force || strcmp(path, "-") == 0 || stat(path, &there) != 0 || !S_ISREG(there.st_mode))
    return true;
  kt_print_message(common, KM_ERROR, "%s: exists already; expected a new name, or --force", path);
  return false;
}
