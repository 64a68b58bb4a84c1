/* A question and what makes its kind. Private to the library. */
#ifndef KM_QUESTION_QUESTION_H
#define KM_QUESTION_QUESTION_H

#include "kmech/question.h"
#include "sweep/sweep.h"
#include "topology/mechanism.h"

/* What is different from kind to kind. `own` below is the kind's part of the question, of `size` bytes, zeroed. */
typedef struct km_question_class {
  const char *name;
  const km_option *options;
  int option_count;
  size_t size;
  /* Makes `own` ready from the options, after the plan. */
  km_status (*prepare)(km_question *question, km_error *error);
  /* Opens the sweep that answers; the last answer is gone already. */
  void (*open)(km_question *question, km_sweep_job *job);
  /* What is found behind a sweep that has ended well. May be NULL. */
  km_status (*conclude)(km_question *question, km_error *error);
  const km_sweep *(*motion)(const km_question *question);
  /* Of a kind that moves by other means than a sweep, whose `open` and `motion` are NULL: the answer, and its rows. */
  km_status (*answer)(km_question *question, km_state *state, km_error *error);
  const km_table *(*table)(const km_question *question);
  int (*event_count)(const km_question *question); /* beside those of every motion */
  km_question_event (*event)(const km_question *question, int index);
  void (*forget)(km_question *question);    /* frees the last answer */
  void (*unprepare)(km_question *question); /* frees what `prepare` made; after a failed one too */
} km_question_class;

extern const km_question_class km_mobility_question, km_advantage_question, km_forces_question, km_track_question;

struct km_question {
  const km_mechanism *m;
  const km_question_class *kind;
  km_arena arena;          /* of copied values */
  km_option_value *values; /* [own options, then those of every motion] */
  bool *given;
  km_messages *notes;
  km_sweep_plan plan;
  km_progress progress;
  void *context;
  bool prepared, answered;
  bool no_reactions;            /* nobody reads their columns, which a question about forces leaves at NaN */
  bool table_only;              /* see km_sweep_job; nor is anything concluded from it */
  const char **read_columns;    /* the same */
  km_sweep_workspace workspace; /* of the last answer, for the next one */
  void *own;
};

/* The options of every motion, in the order of km_motion_options. */
enum {
  KM_MOTION_JOINT,
  KM_MOTION_RANGE,
  KM_MOTION_STEPS,
  KM_MOTION_ARCLENGTH,
  KM_MOTION_DIRECTION,
  KM_MOTION_CYCLE,
  KM_MOTION_BRANCH_POINT,
  KM_MOTION_IGNORE_LIMITS,
  KM_MOTION_DERIVATIVES,
  KM_MOTION_POINT,
  KM_MOTION_OPTIONS
};
extern const km_option km_motion_options[KM_MOTION_OPTIONS];

/* Keeps the table of an answer that is forgotten, for the next one. */
void km_question_keep_table(km_question *question, km_sweep *motion);

/* The value of one of the kind's own options, or of every motion's; NULL: it isn't set. */
const km_option_value *km_question_own_value(const km_question *question, int index);
const km_option_value *km_question_motion_value(const km_question *question, int index);

/* km_question_compute of up to KM_BATCH_LANES questions, each about a mechanism and a state of its own: those of one kind go side
 * by side where that is faster, with the same bits. */
void km_questions_compute(km_question *const *questions, km_state *const *states, int count, km_status *statuses,
                          km_error *errors);

/* Is it a question of this kind, with an answer (or ready for one)? */
bool km_question_is(const km_question *question, const km_question_class *kind);
bool km_question_has(const km_question *question, const km_question_class *kind);

#endif
