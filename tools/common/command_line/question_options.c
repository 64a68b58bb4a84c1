/* Questions on the command line. */
#include "common/command_line/question_options.h"

#include <stdio.h>
#include <string.h>

static int find_kind(const char *name) {
  int kind = 0;
  while (kind < km_question_kinds() && strcmp(km_question_kind_name(kind), name) != 0)
    ++kind;
  return kind;
}

/* The length of an option's name in backquotes at the start of the text; 0: there is none. */
static size_t option_at(const char *text) {
  size_t length = *text == '`' ? strspn(text + 1, "abcdefghijklmnopqrstuvwxyz-") : 0;
  return length && text[length + 1] == '`' ? length : 0;
}

/* Appends a text of the library with the names of options as on the command line: `joint` becomes --joint. */
static void add_words(const char *text, km_text *out) {
  for (const char *c = text; *c;) {
    size_t length = option_at(c);
    if (length)
      km_text_add(out, "--");
    km_text_bytes(out, length ? c + 1 : c, length ? length : 1);
    c += length ? length + 2 : 1;
  }
}

static void add_option(kt_options *out, kt_question *asked, const km_option *o) {
  int i = asked->count++;
  bool flag = o->type == KM_OPTION_FLAG;
  km_text help = {0};
  asked->options[i] = o;
  snprintf(asked->name_texts[i], sizeof asked->name_texts[i], "--%s", o->name);
  asked->names[i] = asked->name_texts[i];
  add_words(o->help, &help);
  if (o->otherwise)
    km_text_format(&help, " (default: %s)", o->otherwise);
  snprintf(asked->help[i], sizeof asked->help[i], "%s", help.data ? help.data : "");
  km_text_free(&help);
  const kt_option option = {.name = o->name,
                            .argument = o->argument,
                            .help = asked->help[i],
                            .kind = flag ? KT_FLAG : (kt_kind){KT_KEEP_TEXTS, o->words},
                            .target = flag ? (void *)&asked->flags[i] : (void *)&asked->texts[i],
                            .group = KT_ABOUT_MODEL};
  kt_options_add(out, &option, 1);
}

void kt_question_options(kt_options *out, kt_question *asked, const char *kind, bool motion) {
  asked->kind = find_kind(kind);
  const km_option *o;
  for (int i = 0; (o = km_question_option(asked->kind, i)) != NULL && asked->count < KT_MOST_ASKED; ++i)
    if (motion || !o->of_motion)
      add_option(out, asked, o);
}

static bool is_listed(const char *name, const char *const *names) {
  while (*names && strcmp(*names, name) != 0)
    ++names;
  return *names != NULL;
}

void kt_question_some(kt_options *out, kt_question *asked, const char *kind, const char *const *names) {
  asked->kind = find_kind(kind);
  const km_option *o;
  for (int i = 0; (o = km_question_option(asked->kind, i)) != NULL && asked->count < KT_MOST_ASKED; ++i)
    if (is_listed(o->name, names))
      add_option(out, asked, o);
}

void kt_question_explain(kt_options *out, const char *option, const char *argument, const char *help) {
  for (int i = 0; i < out->count; ++i) {
    if (strcmp(out->items[i].name, option) != 0)
      continue;
    out->items[i].argument = argument;
    out->items[i].help = help;
  }
}

static int find(const kt_question *asked, const char *option) {
  for (int i = 0; i < asked->count; ++i)
    if (strcmp(asked->options[i]->name, option) == 0)
      return i;
  return -1;
}

bool kt_question_given(const kt_question *asked, const char *option) {
  int i = find(asked, option);
  return i >= 0 && (asked->flags[i] || asked->texts[i].count > 0);
}

kt_texts *kt_question_texts(kt_question *asked, const char *option) {
  int i = find(asked, option);
  return i >= 0 ? &asked->texts[i] : NULL;
}

void kt_question_set(kt_question *asked, const char *option) {
  int i = find(asked, option);
  if (i >= 0)
    asked->flags[i] = true;
}

void kt_question_call(kt_question *asked, const char *option, const char *name) {
  int i = find(asked, option);
  if (i >= 0)
    asked->names[i] = name;
}

void kt_print_messages(const kt_common *common, km_severity severity, const char *path, const char *text) {
  km_text out = {0};
  km_text_add(&out, "");
  add_words(text, &out);
  kt_print_message(common, severity, "%s%s%s", path ? path : "", path ? ": " : "", out.failed ? text : out.data);
  km_text_free(&out);
}

static kt_exit set(const kt_common *common, const km_model *model, const kt_question *asked, int i, km_question *q) {
  km_arena arena = {0};
  km_option_value value = {.flag = asked->flags[i]};
  km_error error;
  kt_exit result = KT_DONE;
  if (asked->options[i]->type != KM_OPTION_FLAG)
    result = kt_question_value(common, model, asked->options[i], asked->names[i], &asked->texts[i], &arena, &value);
  km_status status = result == KT_DONE ? km_question_set(q, asked->options[i]->name, &value, &error) : KM_OK;
  if (status)
    kt_print_messages(common, KM_ERROR, NULL, error.text);
  km_arena_free(&arena);
  return status ? kt_exit_of(status) : result;
}

kt_exit kt_question_read(const kt_common *common, const km_model *model, const kt_question *asked, const char *option,
                         km_arena *arena, km_option_value *out) {
  int i = find(asked, option);
  *out = (km_option_value){0};
  if (i < 0 || !asked->texts[i].count)
    return KT_DONE;
  return kt_question_value(common, model, asked->options[i], asked->names[i], &asked->texts[i], arena, out);
}

kt_exit kt_compute_question(const kt_common *common, const char *path, const kt_question *asked, const kt_pose *pose,
                            km_question **out) {
  km_error error;
  km_status status = km_question_create(pose->mechanism, km_question_kind_name(asked->kind), out, &error);
  kt_exit result = kt_exit_of(status);
  for (int i = 0; i < asked->count && result == KT_DONE; ++i)
    if (asked->flags[i] || asked->texts[i].count)
      result = set(common, pose->model, asked, i, *out);
  if (result == KT_DONE) {
    status = km_question_prepare(*out, &error);
    result = kt_exit_of(status);
  }
  if (status)
    kt_print_messages(common, KM_ERROR, path, error.text);
  const km_messages *notes = result == KT_DONE ? km_question_notes(*out) : NULL;
  for (size_t i = 0; notes && i < km_messages_count(notes); ++i)
    kt_print_messages(common, km_messages_severity(notes, i), path, km_messages_text(notes, i));
  return result;
}
