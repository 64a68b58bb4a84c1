/* The head of a report: title, author, date, note and logo, by options or by the model. */
#include "common/report_head.h"

#include "common/pose.h"

#include "kmech/base.h"

#include <stdio.h>

void kt_report_word_options(kt_options *out, kt_report_head *head) {
  const kt_option table[] = {
      {"title", 0, "TEXT", "Title in place of the model's or the report's own", KT_TEXT, &head->stated.title,
       KT_ABOUT_FILES},
      {"author", 0, "TEXT", "Author, under the title", KT_TEXT, &head->stated.author, KT_ABOUT_FILES},
      {"date", 0, "TEXT", "Date, under the title", KT_TEXT, &head->stated.date, KT_ABOUT_FILES},
      {"note", 0, "TEXT", "A paragraph behind the answer", KT_TEXT, &head->stated.note, KT_ABOUT_FILES},
      {"logo", 0, "FILE.png", "Picture beside the title", KT_INPUT, &head->logo, KT_ABOUT_FILES},
  };
  KT_OPTIONS_ADD(out, table);
}

void kt_report_head_options(kt_options *out, kt_report_head *head, const char **format, const char **base,
                            const char *base_help) {
  const kt_option table[] = {
      {"format", 0, "FORMAT", "pdf (default) or html", KT_TEXT_OF("pdf or html"), format, KT_ABOUT_FILES},
      KT_BASE(base, base_help),
  };
  kt_report_word_options(out, head);
  KT_OPTIONS_ADD(out, table);
}

static kt_exit read_logo(const kt_common *common, const char *place, const char *file, km_text *out) {
  km_error error;
  km_status status = km_logo_read(file, out, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", place, error.text);
  return status ? KT_USAGE : KT_DONE;
}

kt_exit kt_report_head_read(const kt_common *common, kt_report_head *head) {
  return head->logo ? read_logo(common, "--logo", head->logo, &head->logo_bytes) : KT_DONE;
}

/* The stated words, else the model's. */
static const char *choose(const char *stated, const km_model *model, km_model_word word) {
  return stated ? stated : km_model_word_text(model, word);
}

kt_exit kt_report_head_complete(const kt_common *common, kt_report_head *head, const km_model *model,
                                const char *path) {
  const char *logo = head->logo ? NULL : km_model_word_text(model, KM_WORD_LOGO);
  kt_exit result = KT_DONE;
  if (logo) {
    char folder[4096], file[8192];
    kt_folder_of(path, folder, sizeof folder);
    snprintf(file, sizeof file, "%s%s%s", logo[0] == '/' ? "" : folder, logo[0] == '/' || !folder[0] ? "" : "/", logo);
    result = read_logo(common, path, file, &head->logo_bytes);
  }
  head->header = (km_report_header){.title = choose(head->stated.title, model, KM_WORD_TITLE),
                                    .author = choose(head->stated.author, model, KM_WORD_AUTHOR),
                                    .date = choose(head->stated.date, model, KM_WORD_DATE),
                                    .note = choose(head->stated.note, model, KM_WORD_NOTES),
                                    .logo = head->logo_bytes.size ? &head->logo_bytes : NULL};
  return result;
}

void kt_report_head_free(kt_report_head *head) {
  km_text_free(&head->logo_bytes);
}
