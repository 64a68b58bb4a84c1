/* Messages between a page and the server: docs/kview-protocol.md. */
#ifndef KVIEW_MESSAGES_H
#define KVIEW_MESSAGES_H

#include "kview/session.h"

enum {
  KV_PROTOCOL = 1,
  KV_MOST_MESSAGE = 64 * 1024, /* bytes that a page may send in one message */
  KV_MOST_ARGUMENTS = 40000    /* numbers in it */
};

/* The first word of a binary answer. */
typedef enum kv_answer_kind { KV_POSE = 1, KV_PATCH = 2, KV_TABLE = 3 } kv_answer_kind;

typedef struct kv_answer {
  km_text bytes;
  bool binary;    /* else JSON text */
  km_error fault; /* error of the text; status KM_OK if there is none */
} kv_answer;

/* Answers one message of a page: always one answer, which may be {"kind":"error"}. The message needn't end with a
 * NUL, and may hold anything. */
void kv_answer_message(kv_session *session, const char *message, size_t size, kv_answer *out);

/* The parts of answers. */
void kv_describe(const kv_session *session, unsigned request, km_text *out);
void kv_add_pose(const kv_session *session, unsigned request, km_text *out);
void kv_add_error(unsigned request, const km_error *error, km_text *out);

/* Arguments of a verb. */
typedef struct kv_call {
  kv_session *session;
  unsigned request;
  const double *arguments;
  int count;
  kv_answer *answer;
} kv_call;

/* Each fills the answer, or returns a status with the error that becomes the answer. */
typedef km_status kv_verb(const kv_call *call, km_error *error);

/* `question_messages.c`: sweeps and the limits of a slider. */
kv_verb kv_compute_question, kv_recompute, kv_track;
/* Kind of the index-th question of a page: those over a driver's range, and with a path study the track; −1 if there
 * is none. */
int kv_question_kind(const kv_session *session, int index);
/* Explanations of the motion (explanations.c). */
kv_verb kv_motions, kv_diagnose, kv_forces, kv_lever;
/* map_messages.c: maps over two drivers. */
kv_verb kv_map, kv_mapping, kv_mapped, kv_stop, kv_singular, kv_boundary;
/* modes.c: poses that are found or named. */
kv_verb kv_modes, kv_mode, kv_named;
/* selfmotion.c, arm_columns.c: arms with joints to spare. */
kv_verb kv_selfmotion, kv_columns;
/* surface_messages.c: what bodies look like. */
kv_verb kv_patch;
/* parameters.c */
kv_verb kv_set_parameters;
/* saved_model.c */
kv_verb kv_write;

/* table_message.c: `,"columns":[{name, unit}]` of a header; and the answer with a header, which is padded. */
void kv_add_columns(const km_table *table, km_text *header);
km_status kv_add_table(const kv_call *call, km_text *header, const km_table *table, km_error *error);

/* An argument as an index; -1 where it is none. */
int kv_index(const kv_call *call, int argument);

#endif
