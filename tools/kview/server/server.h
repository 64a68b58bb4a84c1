/* Pages in browsers on this machine: HTTP and WebSocket on a loopback address. */
#ifndef KT_KVIEW_SERVER_SERVER_H
#define KT_KVIEW_SERVER_SERVER_H

#include "kview/session.h"

enum { KV_ADDRESS = 128 };

typedef struct kv_server_def {
  kv_opening opening;
  int port;  /* 0: a free one */
  bool stay; /* goes on when the last page is closed */
  /* Called with the address when the server is ready. */
  void (*ready)(void *context, const char *address);
  /* Given the text of every design that no page has saved, at the end. */
  void (*unsaved)(void *context, const km_text *file);
  void *context;
} kv_server_def;

/* Runs the server until the last page is closed or the process is interrupted. KM_IO: the port is unavailable. */
km_status kv_server_run(const kv_server_def *def, km_error *error);

#endif
