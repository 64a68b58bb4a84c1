/* Who may come in: only pages of this server, by its address and token. */
#ifndef KVIEW_GUARD_H
#define KVIEW_GUARD_H

#include <stdbool.h>
#include <stddef.h>

enum { KV_TOKEN = 33 }; /* 128 random bits in hexadecimal, and a NUL */

typedef struct kv_guard {
  char token[KV_TOKEN];
  int port;
} kv_guard;

/* A new token; false: the system gives no random bits. */
bool kv_guard_make(kv_guard *guard);
/* Is this the path of the page, "/TOKEN/", or with "ws" behind it that of its messages? */
bool kv_guard_path(const kv_guard *guard, const char *path, const char *behind);
/* Is the Host this address (a foreign name that leads here isn't)? */
bool kv_guard_host(const kv_guard *guard, const char *host);
/* Is the Origin of a WebSocket a page of this address? */
bool kv_guard_origin(const kv_guard *guard, const char *origin);

#endif
