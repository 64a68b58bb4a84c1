/* kview open: a page in the browser. */
#include "kview/kview.h"
#include "kview/server/server.h"

#include "kmech/arm.h"
#include "kmech/base.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct options {
  kt_common common;
  const char *model, *port, *study;
  bool no_browser, stay;
  char page[4096]; /* a file that leads the browser to the address; "": none */
} options;

/* The address holds the session's token, and every user sees the arguments of a process: the browser gets the name
 * of a file that only this user can read, and which leads on. */
static bool write_page(options *o, const char *address) {
  static const char ending[] = ".html";
  const char *folder = getenv("XDG_RUNTIME_DIR");
  if (!folder || access(folder, W_OK) != 0)
    folder = getenv("TMPDIR");
  snprintf(o->page, sizeof o->page, "%.4000s/kview.XXXXXX%s", folder && *folder ? folder : "/tmp", ending);
  int descriptor = mkstemps(o->page, (int)strlen(ending));
  FILE *file = descriptor >= 0 ? fdopen(descriptor, "w") : NULL;
  if (!file) {
    if (descriptor >= 0) {
      close(descriptor);
      unlink(o->page);
    }
    o->page[0] = '\0';
    return false;
  }
  fprintf(file,
          "<!doctype html><meta charset=utf-8><title>kview</title><meta http-equiv=refresh content=\"0;url=%s\">\n",
          address);
  return fclose(file) == 0;
}

/* Starts a grandchild process, which needs no wait. */
static void open_browser(const char *page) {
  pid_t child = fork();
  if (child == 0) {
    if (fork() == 0) {
      if (freopen("/dev/null", "w", stdout) && freopen("/dev/null", "w", stderr))
        execlp("xdg-open", "xdg-open", page, (char *)NULL);
      _exit(127);
    }
    _exit(0);
  }
  if (child > 0)
    waitpid(child, NULL, 0);
}

static void ready(void *context, const char *address) {
  options *o = context;
  printf("%s\n", address);
  fflush(stdout);
  if (!o->no_browser && write_page(o, address))
    open_browser(o->page);
}

/* Writes a new file: nothing is replaced. */
static void write_unsaved(void *context, const km_text *file) {
  enum { MOST = 1000 };
  const options *o = context;
  char base[256], path[320];
  kt_base_name(o->model, base, sizeof base);
  for (int k = 1; k <= MOST; ++k) {
    snprintf(path, sizeof path, k == 1 ? "%s.unsaved.json" : "%s.unsaved-%d.json", base, k);
    FILE *out = fopen(path, "wx");
    if (!out && errno == EEXIST)
      continue;
    bool written = out && fwrite(file->data, 1, file->size, out) == file->size;
    written = out && fclose(out) == 0 && written;
    if (written)
      kt_print_message(&o->common, KM_NOTE, "a design that no page has saved was written to %s", path);
    else
      kt_print_message(&o->common, KM_WARNING, "%s: a design that no page has saved can't be written: %s", path,
                       strerror(errno));
    return;
  }
}

static bool read_port(const options *o, int *port) {
  if (!o->port || kt_integer(o->port, 1, 65535, port))
    return true;
  kt_usage(&o->common, "--port", o->port, "a whole number from 1 to 65535");
  return false;
}

/* A file that can't be read is named by the error itself. */
void kview_say(const kt_common *common, const char *path, km_status status, const km_error *error) {
  if (status == KM_IO)
    kt_print_message(common, KM_ERROR, "%s", error->text);
  else
    kt_print_message(common, KM_ERROR, "%s: %s", path, error->text);
}

/* Errors of the model are reported here, not only in a page. */
static kt_exit try_model(const options *o) {
  kv_session session = {.opening = {.path = o->model,
                                    .floating = o->common.floating,
                                    .closure_tolerance = o->common.closure_tolerance,
                                    .exact = o->common.exact,
                                    .pose = o->common.pose}};
  km_error error;
  km_status status = kv_session_load(&session, &error);
  if (status)
    kview_say(&o->common, o->model, status, &error);
  kv_session_close(&session);
  return kt_exit_of(status);
}

/* Errors of the study, too, although it is read with its first question. */
static kt_exit try_study(const options *o) {
  char folder[4096];
  km_text text = {0};
  km_error error;
  km_messages *messages = km_messages_create();
  km_study_def def = km_study_def_default();
  km_status status = km_file_read(o->study, &text, &error);
  kt_folder_of(o->study, folder, sizeof folder);
  if (status) {
    kt_print_message(&o->common, KM_ERROR, "%s", error.text);
  } else {
    status = km_study_read(text.data, text.size, folder, messages, &def, &error);
    kt_report_messages(&o->common, o->study, messages, status, error.text);
  }
  km_study_def_free(&def);
  km_messages_free(messages);
  km_text_free(&text);
  return kt_exit_of(status);
}

kt_exit kview_open(int argc, char **argv) {
  options o = {.common = KT_COMMON("kview")};
  kt_options all = {0};
  const kt_option table[] = {
      {"port", 0, "N", "Listen on this port of 127.0.0.1 (default: a free one)", KT_TEXT, &o.port, KT_ABOUT_METHOD},
      {"no-browser", 0, NULL, "Only print the address", KT_FLAG, &o.no_browser, KT_ABOUT_METHOD},
      {"stay", 0, NULL, "Go on when the last page is closed, until Ctrl-C", KT_FLAG, &o.stay, KT_ABOUT_METHOD},
      {"study", 0, "FILE", "Offer the question track too, along the path of this path study", KT_INPUT, &o.study,
       KT_ABOUT_MODEL},
      {"pose", 0, "NAME", "Start from this one of the poses that the model names", KT_TEXT, &o.common.pose,
       KT_ABOUT_MODEL},
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_options_read(&all, "Open a model in the browser: a page of this machine alone, which moves it by hand.", argc,
                  argv);
  kv_server_def def = {.opening = {.path = o.model,
                                   .floating = o.common.floating,
                                   .closure_tolerance = o.common.closure_tolerance,
                                   .exact = o.common.exact,
                                   .pose = o.common.pose,
                                   .study = o.study},
                       .stay = o.stay,
                       .ready = ready,
                       .unsaved = write_unsaved,
                       .context = &o};
  if (!read_port(&o, &def.port))
    return KT_USAGE;
  if (strcmp(o.model, "-") == 0)
    return kt_usage(&o.common, "MODEL", "-", "a file, which is read again when it changes");
  kt_exit result = try_model(&o);
  if (result == KT_DONE && o.study)
    result = try_study(&o);
  km_error error;
  if (result == KT_DONE && kv_server_run(&def, &error)) {
    kt_print_message(&o.common, KM_ERROR, "%s", error.text);
    result = KT_USAGE;
  }
  if (o.page[0])
    unlink(o.page);
  return result;
}
