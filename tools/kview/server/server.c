/* HTTP and WebSocket by libwebsockets: one page of HTML, and one session for each page that is open.
 *
 * A page's messages are answered one after another: while an answer waits for the page to read it, nothing more is read
 * from that page. So a slow page, or one that never reads, costs one answer's memory. */
#include "kview/server/server.h"

#include "kview/messages.h"
#include "kview/page.h"
#include "kview/server/access_control.h"

#include <libwebsockets.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PAGES = 16, HEADER = 256, PATIENCE = 30 /* seconds for a page to read an answer */ };
static const lws_usec_t tick = 250 * LWS_US_PER_MS;
static const int ticks_without_page = 12; /* after the last page was closed: a reload opens it again */

static volatile sig_atomic_t interrupted;

typedef struct page {
  kv_session *session;
  km_text in;     /* bytes of a message in several pieces */
  km_text answer; /* LWS_PRE bytes, then the answer; empty: none waits */
  bool binary, stale, counted;
} page;

typedef struct server {
  const kv_server_def *def;
  kv_guard guard;
  struct lws_context *context;
  struct lws_vhost *host;
  lws_sorted_usec_list_t timer;
  int pages, idle; /* open ones; ticks since there is none */
  bool had_page, over;
  kv_design *kept[MOST_PAGES]; /* designs of pages that were closed, the newest last */
  int kept_count;
} server;

/* HTTP */

static int send_page(struct lws *wsi) {
  static const char policy[] = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                               "img-src data: blob:; connect-src 'self'; base-uri 'none'; frame-ancestors 'none'";
  size_t room = LWS_PRE + 1024 + kv_page_size;
  unsigned char *bytes = malloc(room);
  if (!bytes)
    return -1;
  unsigned char *start = bytes + LWS_PRE, *at = start, *end = bytes + LWS_PRE + 1024;
  bool good =
      !lws_add_http_common_headers(wsi, HTTP_STATUS_OK, "text/html; charset=utf-8", kv_page_size, &at, end) &&
      !lws_add_http_header_by_name(wsi,
                                   (const unsigned char *)"content-security-policy:", (const unsigned char *)policy,
                                   (int)sizeof policy - 1, &at, end) &&
      !lws_add_http_header_by_name(wsi, (const unsigned char *)"referrer-policy:", (const unsigned char *)"no-referrer",
                                   11, &at, end) &&
      !lws_add_http_header_by_name(wsi, (const unsigned char *)"cache-control:", (const unsigned char *)"no-store", 8,
                                   &at, end) &&
      !lws_finalize_write_http_header(wsi, start, &at, end);
  if (good) {
    memcpy(bytes + LWS_PRE, kv_page, kv_page_size);
    good = lws_write(wsi, bytes + LWS_PRE, kv_page_size, LWS_WRITE_HTTP_FINAL) >= 0;
  }
  free(bytes);
  return !good || lws_http_transaction_completed(wsi) ? -1 : 0;
}

static void header_of(struct lws *wsi, enum lws_token_indexes token, char out[HEADER]) {
  if (lws_hdr_copy(wsi, out, HEADER, token) < 0)
    out[0] = '\0';
}

static int refuse(struct lws *wsi, unsigned status) {
  return lws_return_http_status(wsi, status, NULL) || lws_http_transaction_completed(wsi) ? -1 : 0;
}

static int on_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size) {
  const server *s = lws_context_user(lws_get_context(wsi));
  char host[HEADER];
  if (reason == LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION) { /* a socket that doesn't name our protocol */
    lws_return_http_status(wsi, HTTP_STATUS_FORBIDDEN, NULL);
    return -1;
  }
  if (reason != LWS_CALLBACK_HTTP)
    return lws_callback_http_dummy(wsi, reason, user, in, size);
  header_of(wsi, WSI_TOKEN_HOST, host);
  if (!kv_guard_host(&s->guard, host))
    return refuse(wsi, HTTP_STATUS_FORBIDDEN);
  if (!lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) || !kv_guard_path(&s->guard, in, ""))
    return refuse(wsi, HTTP_STATUS_NOT_FOUND);
  return send_page(wsi);
}

/* WebSocket */

static bool is_welcome(const server *s, struct lws *wsi) {
  char path[HEADER], host[HEADER], origin[HEADER];
  header_of(wsi, WSI_TOKEN_GET_URI, path);
  header_of(wsi, WSI_TOKEN_HOST, host);
  header_of(wsi, WSI_TOKEN_ORIGIN, origin);
  return kv_guard_path(&s->guard, path, "ws") && kv_guard_host(&s->guard, host) && kv_guard_origin(&s->guard, origin);
}

/* Puts an answer in line, and reads no further message until it is gone. */
static void answer(struct lws *wsi, page *p, kv_answer *a) {
  static const unsigned char before[LWS_PRE] = {0};
  km_text_bytes(&p->answer, before, sizeof before);
  km_text_bytes(&p->answer, a->bytes.data ? a->bytes.data : "", a->bytes.size);
  p->binary = a->binary;
  km_text_free(&a->bytes);
  lws_rx_flow_control(wsi, 0);
  lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, PATIENCE);
  lws_callback_on_writable(wsi);
}

/* Stores the design; the oldest one is dropped if necessary. */
static void keep(server *s, kv_design *design) {
  if (!design)
    return;
  if (s->kept_count == MOST_PAGES) {
    kv_design_free(s->kept[0]);
    memmove(s->kept, s->kept + 1, (MOST_PAGES - 1) * sizeof *s->kept);
    --s->kept_count;
  }
  s->kept[s->kept_count++] = design;
}

/* A page that is loaded again has the design that it was closed with. */
static void restore(server *s, kv_session *session) {
  if (s->kept_count > 0 && kv_session_restore(session, s->kept[s->kept_count - 1]))
    kv_design_free(s->kept[--s->kept_count]);
}

static int too_many(struct lws *wsi) {
  static const char text[] = "16 pages are open already: close one of them";
  lws_close_reason(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, (unsigned char *)(size_t)text, sizeof text - 1);
  return -1;
}

static int open_page(server *s, struct lws *wsi, page *p) {
  if (s->pages >= MOST_PAGES)
    return too_many(wsi);
  *p = (page){.session = calloc(1, sizeof *p->session)};
  if (!p->session)
    return -1;
  p->session->opening = s->def->opening;
  p->session->asked.kind = -1;
  p->counted = s->had_page = true;
  ++s->pages;
  km_error error;
  if (kv_session_load(p->session, &error)) {
    kv_answer wrong = {0};
    kv_add_error(0, &error, &wrong.bytes);
    answer(wsi, p, &wrong);
  } else {
    restore(s, p->session);
  }
  return 0;
}

static void close_page(server *s, page *p) {
  if (!p || !p->counted)
    return;
  --s->pages;
  s->idle = 0;
  km_text_free(&p->in);
  km_text_free(&p->answer);
  keep(s, kv_session_keep(p->session));
  kv_session_close(p->session);
  free(p->session);
  *p = (page){0};
}

static int too_large(struct lws *wsi) {
  static const char text[] = "a message of more than 64 kB";
  lws_close_reason(wsi, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, (unsigned char *)(size_t)text, sizeof text - 1);
  return -1;
}

static int receive(struct lws *wsi, page *p, const void *bytes, size_t size) {
  if (p->in.size + size > KV_MOST_MESSAGE || p->answer.size)
    return too_large(wsi);
  km_text_bytes(&p->in, bytes, size);
  if (p->in.failed)
    return -1;
  if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi))
    return 0;
  kv_answer reply;
  kv_answer_message(p->session, p->in.data ? p->in.data : "", p->in.size, &reply);
  p->in.size = 0;
  answer(wsi, p, &reply);
  return 0;
}

/* The file has changed: the page gets the model anew, with its own design where that fits; or what is wrong with the
 * file. */
static void renew(server *s, struct lws *wsi, page *p) {
  kv_answer news = {0};
  km_error error;
  kv_design *design = kv_session_keep(p->session);
  p->stale = false;
  if (kv_session_load(p->session, &error)) {
    kv_add_error(0, &error, &news.bytes);
    kv_design_free(design); /* the session has kept what it had */
  } else {
    if (design && kv_session_restore(p->session, design))
      kv_design_free(design);
    else
      keep(s, design);
    kv_describe(p->session, 0, &news.bytes);
  }
  answer(wsi, p, &news);
}

static int write_answer(server *s, struct lws *wsi, page *p) {
  if (!p->answer.size) {
    if (p->stale)
      renew(s, wsi, p);
    return 0;
  }
  size_t size = p->answer.size - LWS_PRE;
  int sent = p->answer.failed ? -1
                              : lws_write(wsi, (unsigned char *)p->answer.data + LWS_PRE, size,
                                          p->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT);
  p->answer.size = 0;
  if (p->answer.capacity > 4 * KV_MOST_MESSAGE)
    km_text_free(&p->answer);
  if (sent < (int)size)
    return -1;
  lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
  lws_rx_flow_control(wsi, 1);
  return 0;
}

static int on_page(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size) {
  server *s = lws_context_user(lws_get_context(wsi));
  page *p = user;
  switch (reason) {
  case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
    if (is_welcome(s, wsi))
      return 0;
    lws_return_http_status(wsi, HTTP_STATUS_FORBIDDEN, NULL);
    return -1;
  case LWS_CALLBACK_ESTABLISHED:
    return open_page(s, wsi, p);
  case LWS_CALLBACK_RECEIVE:
    return receive(wsi, p, in, size);
  case LWS_CALLBACK_SERVER_WRITEABLE:
    return write_answer(s, wsi, p);
  case LWS_CALLBACK_CLOSED:
    close_page(s, p);
    return 0;
  case LWS_CALLBACK_USER: /* timer: checks whether the file has changed */
    if (p && p->session && kv_session_is_stale(p->session)) {
      p->stale = true;
      lws_callback_on_writable(wsi);
    }
    return 0;
  default:
    return 0;
  }
}

static const struct lws_protocols protocols[] = {{"http", on_http, 0, 0, 0, NULL, 0},
                                                 {"kview", on_page, sizeof(page), KV_MOST_MESSAGE, 0, NULL, 0},
                                                 {NULL, NULL, 0, 0, 0, NULL, 0}};

static void on_tick(lws_sorted_usec_list_t *timer) {
  server *s = lws_container_of(timer, server, timer);
  lws_callback_all_protocol_vhost_args(s->host, lws_vhost_name_to_protocol(s->host, "kview"), LWS_CALLBACK_USER, NULL,
                                       0);
  s->idle = s->pages ? 0 : s->idle + 1;
  if (interrupted || (s->had_page && !s->def->stay && s->idle > ticks_without_page))
    s->over = true;
  lws_sul_schedule(s->context, 0, timer, on_tick, tick);
}

static void on_signal(int signal) {
  (void)signal;
  interrupted = 1;
}

static km_status start(server *s, km_error *error) {
  struct lws_context_creation_info info = {0};
  lws_set_log_level(0, NULL);
  info.port = s->def->port;
  info.iface = "127.0.0.1";
  info.protocols = protocols;
  info.user = s;
  info.keepalive_timeout = 5;
  info.options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  if (!kv_guard_make(&s->guard))
    return km_fail(error, KM_IO, "the system gives no random bits");
  s->context = lws_create_context(&info);
  s->host = s->context ? lws_get_vhost_by_name(s->context, "default") : NULL;
  s->guard.port = s->host ? lws_get_vhost_listen_port(s->host) : 0;
  if (s->guard.port <= 0)
    return km_fail(error, KM_IO, "port %d of 127.0.0.1 can't be had", s->def->port);
  return KM_OK;
}

km_status kv_server_run(const kv_server_def *def, km_error *error) {
  server s = {.def = def};
  char address[KV_ADDRESS];
  km_status status = start(&s, error);
  if (!status) {
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    snprintf(address, sizeof address, "http://127.0.0.1:%d/%s/", s.guard.port, s.guard.token);
    def->ready(def->context, address);
    lws_sul_schedule(s.context, 0, &s.timer, on_tick, tick);
    while (!s.over && !interrupted && lws_service(s.context, 0) >= 0)
      ;
  }
  if (s.context)
    lws_context_destroy(s.context); /* pages that are open are closed, and leave their designs */
  for (int i = 0; i < s.kept_count; ++i) {
    if (s.kept[i]->unsaved)
      def->unsaved(def->context, &s.kept[i]->file);
    kv_design_free(s.kept[i]);
  }
  return status;
}
