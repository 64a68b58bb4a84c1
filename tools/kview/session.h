/* Session of a page: the model of the file and as changed by the page, in a configuration. Belongs to one thread. */
#ifndef KVIEW_SESSION_H
#define KVIEW_SESSION_H

#include "kview/map_job.h"
#include "kview/server/encode.h"

#include "kmech/base.h"
#include "kmech/continuation.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mechanism.h"
#include "kmech/model.h"
#include "kmech/question.h"

#include <time.h>

enum { KV_UNDO_BYTES = 8 << 20, KV_MOST_UNDO = 200 };

/* Options of opening the model, the same for every page. */
typedef struct kv_opening {
  const char *path; /* path of the model's file */
  bool floating;
  double closure_tolerance; /* 0: the file's */
  bool exact;               /* rounded numbers are taken as written */
  const char *pose;         /* named in the model; NULL: its own */
  const char *study;        /* path study of the question "track"; NULL: none */
} kv_opening;

/* A step of the undo list: configuration, frames and parameters. */
typedef struct kv_moment {
  double *numbers; /* [coordinates + 3 · frames + parameters] */
} kv_moment;

/* A question of the page, computed again when the design changes. */
typedef struct kv_asked {
  int kind; /* -1: none */
  int driver, steps, input, output;
  int branch; /* branch at the first branch point by arc length; 1, or 0: the smooth one */
  double from, to;
} kv_asked;

/* A parameter of the file that is a plain number. */
typedef struct kv_parameter {
  const char *name, *note;
  double value, file; /* name of the present design, and of the file's */
  double low, high;   /* defaults of the file */
} kv_parameter;

typedef struct kv_parameters {
  km_arena memory;
  kv_parameter *items;
  int count;
} kv_parameters;

typedef struct kv_session {
  kv_opening opening;
  struct timespec changed; /* when the file was written last */
  km_model *model;
  km_mechanism *mechanism;
  km_state *state, *probe; /* the page's pose; and one for sweeps and searches */
  km_manipulation *hand;
  km_mobility mobility;
  km_manipulation_step move; /* result of the last pull */
  km_hold *holds;            /* [hold_count] of [coordinate_count] held coordinates */
  int hold_count;
  int *origin;         /* [body] its frame `origin` */
  double *file_places; /* [3 · frames] as the file has them */
  double *own_places;  /* text with the present parameters */
  kv_parameters parameters;
  double file_length; /* the characteristic length of the file's design */
  bool edited;        /* a number of the design isn't the file's */
  bool unsaved;       /* and it has changed since it was written last */
  kv_moment undo[KV_MOST_UNDO];
  int undo_count, undo_at; /* poses kept; the place of the present one */
  kv_asked asked;
  km_question *question; /* answer of `asked`; NULL: not yet computed */
  double *modes;         /* assembly modes found last: [mode_count × coordinates] */
  int mode_count;
  km_space_map map;      /* the last map; its tables are NULL where there is none */
  kv_map_job *job;       /* a map that is being computed; NULL: none */
  km_messages *messages; /* messages of the reader */
} kv_session;

/* Reads and assembles the model. On failure `error` describes it, and the session has no model, or the previous one. */
km_status kv_session_load(kv_session *session, km_error *error);
void kv_session_close(kv_session *session);
/* True if the file has been written since it was read. */
bool kv_session_is_stale(const kv_session *session);

/* Compiles the model with other holds in the present configuration. Unchanged on failure. */
km_status kv_session_hold(kv_session *session, int coordinate, bool held, km_error *error);
/* Compiles the model with the present holds in the configuration nearest to q. Unchanged on failure. */
km_status kv_session_compile(kv_session *session, const double *q, km_error *error);
/* Takes over another model of the same parts at the pose next to q; on failure everything stays, and the model is the
 * caller's. */
km_status kv_session_set_model(kv_session *session, km_model *model, const double *q, km_error *error);
/* Says whether the design is still that of the file. */
void kv_session_note_edits(kv_session *session);
/* All coordinates; NULL when out of memory. The caller frees it. */
double *kv_session_coordinates(const kv_session *session);
/* Puts the coordinates at values and closes the loops next to them; where they don't close, the pose stays. */
km_status kv_session_place(kv_session *session, const double *q, km_error *error);
/* The state has moved: poses, mobility numbers and evidence follow. */
void kv_session_follow(kv_session *session);
/* Brings `probe` to the page's pose. */
km_status kv_session_probe(kv_session *session, km_error *error);

/* Adds the present configuration and design to the undo list; and moves a step back (−1) or forward (+1). */
km_status kv_session_mark(kv_session *session, km_error *error);
km_status kv_session_step(kv_session *session, int direction, km_error *error);

/* map_messages.c: ends a map that is being computed, before the mechanism changes. */
void kv_map_stop(kv_session *session);

/* Moves the frames of a joint on both its bodies so that its place in the present pose is at `point` (inertial frame):
 * the pose stays, the links change. */
km_status kv_session_move_pivot(kv_session *session, int joint, const double point[3], km_error *error);
/* Gives a frame another place in its body. The loops close next to the present pose; else the frame stays. */
km_status kv_session_move_frame(kv_session *session, int frame, const double T[3], km_error *error);
/* Places of all frames in their bodies: [3 · frames]. NULL when out of memory; the caller frees it. */
double *kv_frame_places(const km_model *model);
/* Takes the places of all frames: T[3 · frames], of a design that was kept; at the pose next to q[coordinate], NULL:
 * the present one. */
km_status kv_session_set_design(kv_session *session, const double *T, const double *q, km_error *error);

/* stored_designs.c: a design that isn't the file's, by its numbers and as the text of a file. */
typedef struct kv_design {
  km_text parts, file;
  double *values, *places; /* values of the parameters; three coordinates of each frame */
  bool unsaved;
} kv_design;
/* The session's design; NULL: it is the file's, or memory is out. */
kv_design *kv_session_keep(const kv_session *session);
/* Gives it to a session that has just been loaded; false where its model has other parts, or doesn't close with it. */
bool kv_session_restore(kv_session *session, const kv_design *design);
void kv_design_free(kv_design *design);

/* parameters.c: those of a file's bytes; none where its format has none. KM_MEMORY. Free in any case. */
km_status kv_parameters_read(const km_text *file, kv_parameters *out, km_error *error);
void kv_parameters_free(kv_parameters *parameters);
bool kv_parameters_differ(const kv_parameters *parameters);
/* Reads the file with other parameter values, in the configuration nearest to the present one. Unchanged on failure. */
km_status kv_session_set_parameters(kv_session *session, const double *values, km_error *error);

#endif
