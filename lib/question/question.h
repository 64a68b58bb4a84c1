/* Data of a request and of its kinds. Private to the library. */
#ifndef KM_QUESTION_QUESTION_H
#define KM_QUESTION_QUESTION_H

#include "kmech/question.h"
#include "sweep/sweep.h"
#include "topology/mechanism.h"

/* Functions of one kind; `kind_data` is the kind's part of the request, of `size` bytes, zeroed. */
typedef struct km_question_class {
  const char *name;
  const km_option *options; /* own options */
  int option_count;
  const km_option *shared; /* options that several kinds have, behind the own ones */
  int shared_count;
  size_t size;
  bool is_space; /* rows are configurations of a space, and no curve connects them */
  /* Prepares `kind_data` from the options. Can be NULL. */
  km_status (*prepare)(km_question *question, km_error *error);
  /* Opens the sweep that computes the result; the last result is freed before. */
  void (*open)(km_question *question, km_sweep_job *job);
  /* Computes results after a successful sweep. Can be NULL. */
  km_status (*conclude)(km_question *question, km_error *error);
  const km_sweep *(*motion)(const km_question *question);
  /* Kinds without a sweep, whose `open` and `motion` are NULL, need the five functions below. */
  km_status (*answer)(km_question *question, km_state *state, km_error *error); /* computes the result */
  const km_table *(*table)(const km_question *question);                        /* its rows */
  int (*planned_rows)(const km_question *question);              /* number of rows of a complete result */
  double (*planned_place)(const km_question *question, int row); /* arc length or time of such a row; NaN: unknown */
  void (*end_reason)(const km_question *question, km_text *out); /* reason of KM_PARTIAL as text */
  int (*event_count)(const km_question *question);               /* events besides those of every motion */
  km_question_event (*event)(const km_question *question, int index);
  void (*clear_result)(km_question *question);      /* frees the last result */
  void (*clear_preparation)(km_question *question); /* frees the preparation, also a failed one; NULL: there is none */
} km_question_class;

extern const km_question_class km_mobility_question, km_advantage_question, km_forces_question, km_track_question,
    km_run_question, km_inverse_question, km_motion_question, km_allowance_question, km_clearance_question,
    km_modes_question, km_map_question, km_turning_question, km_volume_question;

struct km_question {
  const km_mechanism *m;
  const km_question_class *kind;
  km_arena arena;          /* memory of copied values */
  km_option_value *values; /* [the kind's options, then those of every motion] */
  bool *is_set_value;
  km_messages *notes;
  km_sweep_plan plan;
  km_progress progress;
  void *context;
  bool is_prepared, has_result;
  bool no_reactions;            /* reactions are not read; a request of kind "forces" leaves their columns at NaN */
  bool table_only;              /* see km_sweep_job; `conclude` is skipped */
  const char **read_columns;    /* see km_sweep_job */
  km_sweep_workspace workspace; /* memory of the last result, for the next one */
  void *kind_data;
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

/* Creates the clearance of an option `between` (NULL: the default pairs), unless there is one. */
km_status km_question_prepare_clearance(const km_question *question, km_state *state, const km_option_value *between,
                                        km_clearance **out, km_error *error);
/* Contacts of a course and its least clearance as events. */
int km_clearance_event_count(const km_clearance_course *course);
km_question_event km_clearance_event(const km_clearance_course *course, int index);

/* Keeps the table of a freed result for the next one. */
void km_question_keep_table(km_question *question, km_sweep *motion);

/* Return the value of one of the kind's options, or of every motion's; NULL: not set. */
const km_option_value *km_question_own_value(const km_question *question, int index);
const km_option_value *km_question_motion_value(const km_question *question, int index);

/* Computes up to KM_BATCH_LANES requests, each with its own mechanism and state: those of one kind advance in a
 * batch, with the bits of single ones. */
void km_questions_compute(km_question *const *questions, km_state *const *states, int count, km_status *statuses,
                          km_error *errors);

/* True if the request is of this kind and prepared, or has a result. */
bool km_question_is(const km_question *question, const km_question_class *kind);
bool km_question_has(const km_question *question, const km_question_class *kind);

#endif
