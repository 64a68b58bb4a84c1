/* The socket of a session: one client at a Unix socket or a TCP port of this machine. */
#include "ksim/serve.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

static int listen_at_port(int port) {
  const struct sockaddr_in address = {
      .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  int on = 1, found = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (found < 0)
    return -1;
  setsockopt(found, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(found, (const struct sockaddr *)&address, sizeof address) == 0 && listen(found, 1) == 0)
    return found;
  close(found);
  return -1;
}

static int listen_at_path(const char *path) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  if (strlen(path) >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    return -1;
  }
  strcpy(address.sun_path, path);
  int found = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (found < 0)
    return -1;
  if (bind(found, (const struct sockaddr *)&address, sizeof address) == 0 && listen(found, 1) == 0)
    return found;
  close(found);
  return -1;
}

bool ksim_accept(const kt_common *common, const char *place, FILE **in, FILE **out) {
  int port = 0, on = 1;
  bool is_port = kt_integer(place, 1, 65535, &port);
  int listener = is_port ? listen_at_port(port) : listen_at_path(place);
  if (listener >= 0)
    kt_print_message(common, KM_NOTE, "waits for a client at %s %s", is_port ? "port" : "socket", place);
  int client = listener < 0 ? -1 : accept(listener, NULL, NULL);
  int failure = errno;
  if (listener >= 0)
    close(listener);
  if (listener >= 0 && !is_port)
    unlink(place);
  if (client >= 0 && is_port)
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  *in = client < 0 ? NULL : fdopen(client, "r");
  int copy = *in ? dup(client) : -1;
  *out = copy < 0 ? NULL : fdopen(copy, "w");
  if (!*out)
    kt_print_message(common, KM_ERROR, "--socket %s: %s", place, strerror(failure));
  return *out != NULL;
}
