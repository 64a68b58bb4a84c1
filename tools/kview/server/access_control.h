/* Access control: only pages of this server, by its address and token. */
#ifndef KT_KVIEW_SERVER_ACCESS_CONTROL_H
#define KT_KVIEW_SERVER_ACCESS_CONTROL_H

#include <stdbool.h>
#include <stddef.h>

enum { KV_TOKEN = 33 }; /* 128 random bits in hexadecimal, and a NUL */

typedef struct kv_guard {
  char token[KV_TOKEN];
  int port;
} kv_guard;

/* A new token; false: the system gives no random bits. */
bool kv_guard_make(kv_guard *guard);
/* True if this is the path of the page, "/TOKEN/", or of its messages, "/TOKEN/ws". */
bool kv_guard_path(const kv_guard *guard, const char *path, const char *behind);
/* True if the Host is this address, and not another name that resolves to it. */
bool kv_guard_host(const kv_guard *guard, const char *host);
/* True if the Origin of a WebSocket is a page of this address. */
bool kv_guard_origin(const kv_guard *guard, const char *origin);

#endif
