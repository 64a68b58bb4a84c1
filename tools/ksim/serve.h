/* A session of another program: its inputs and its motion are JSON, one line each. */
#ifndef KSIM_SERVE_H
#define KSIM_SERVE_H

#include "ksim/ksim.h"

#include <stdio.h>

/* A session that another program controls. Lists are borrowed. */
typedef struct ksim_server {
  const kt_common *common;
  const char *path; /* the model's file */
  kt_pose pose;
  km_option_value frames; /* points of --frame */
  km_crossing *crossings; /* [crossing_count] those of --event and --stop */
  int crossing_count;
  km_session *session;
  double step; /* the model's time unit */
  int crossings_told;
  long steps; /* steps made; and their clock time, seconds */
  double total, longest;
  bool is_over; /* the client ended it, or the run can't go on */
  kt_exit result;
} ksim_server;

/* Appends the description of the session: model, step, units, joints, frames, controllers. */
void ksim_describe(const ksim_server *server, km_text *out);
/* Handles a request, and appends the reply: the motion after the steps, or an error. */
void ksim_reply(ksim_server *server, const char *request, size_t size, km_text *out);

/* Waits for one client at a Unix socket (a path) or a TCP port of this machine (a number); streams to read and to
 * write. False with a message. */
bool ksim_accept(const kt_common *common, const char *place, FILE **in, FILE **out);

#endif
