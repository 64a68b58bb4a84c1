/* Access control. */
#include "kview/server/access_control.h"

#include <stdio.h>
#include <string.h>
#include <sys/random.h>

bool kv_guard_make(kv_guard *g) {
  unsigned char bits[(KV_TOKEN - 1) / 2];
  if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits)
    return false;
  for (size_t i = 0; i < sizeof bits; ++i)
    snprintf(g->token + 2 * i, 3, "%02x", bits[i]);
  return true;
}

/* Comparison in constant time, so that its duration reveals nothing. */
static bool same(const char *a, const char *b, size_t size) {
  unsigned char different = 0;
  for (size_t i = 0; i < size; ++i)
    different |= (unsigned char)(a[i] ^ b[i]);
  return different == 0;
}

bool kv_guard_path(const kv_guard *g, const char *path, const char *behind) {
  enum { LENGTH = KV_TOKEN - 1 };
  return strlen(path) == LENGTH + 2 + strlen(behind) && path[0] == '/' && same(path + 1, g->token, LENGTH) &&
         path[1 + LENGTH] == '/' && strcmp(path + 2 + LENGTH, behind) == 0;
}

static bool is_address(const kv_guard *g, const char *text, const char *scheme) {
  static const char *const names[] = {"127.0.0.1", "localhost"};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
    char expected[64];
    snprintf(expected, sizeof expected, "%s%s:%d", scheme, names[i], g->port);
    if (strcmp(text, expected) == 0)
      return true;
  }
  return false;
}

bool kv_guard_host(const kv_guard *g, const char *host) {
  return is_address(g, host, "");
}

bool kv_guard_origin(const kv_guard *g, const char *origin) {
  return is_address(g, origin, "http://");
}
