/* Questions: one shape for every analysis of a motion. A question has a name and a table of options; when it is asked, it
 * gives rows in named columns, located events, and figures of merit over the rows (km_table_figure). Tools, studies, other languages and
 * viewers ask by this one interface; what a kind gives beyond it stands in a header of its own.
 *
 *   km_question_create(mechanism, "advantage", &question, &error);
 *   km_option_value range = {.numbers = {20.0, 32.0}};
 *   km_question_set(question, "range", &range, &error);
 *   km_question_compute(question, state, &error);
 *   km_table_write_csv(km_question_table(question), "brake.advantage.csv", &error);
 *   km_question_free(question);
 */
#ifndef KMECH_QUESTION_H
#define KMECH_QUESTION_H

#include "kmech/arm.h"
#include "kmech/base.h"
#include "kmech/sweep.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What an option takes, and which member of km_option_value holds it. */
typedef enum km_option_type {
  KM_OPTION_FLAG,        /* flag */
  KM_OPTION_WHOLE,       /* whole */
  KM_OPTION_NUMBER,      /* numbers[0] */
  KM_OPTION_RANGE,       /* numbers[0], numbers[1] */
  KM_OPTION_VECTOR,      /* numbers[0 … 2] */
  KM_OPTION_WORD,        /* whole: the place of the word in the option's `words` */
  KM_OPTION_COORDINATE,  /* coordinate */
  KM_OPTION_SENSE,       /* coordinate, and numbers[0] > 0: forwards, < 0: backwards */
  KM_OPTION_COORDINATES, /* coordinates[count] */
  KM_OPTION_POINTS,      /* points[count] */
  KM_OPTION_END,         /* end */
  KM_OPTION_ENDS,        /* ends[count]: points along directions */
  KM_OPTION_LOADS,       /* loads[count]: all that act, instead of the model's own */
  KM_OPTION_FILE         /* text: a file's name */
} km_option_type;

/* An option of a kind of question. */
typedef struct km_option {
  const char *name;      /* as km_question_set takes it */
  km_option_type type;   /* what it takes */
  const char *argument;  /* as a help shows it: "FROM:TO"; NULL: a flag has none */
  const char *unit;      /* "driver's", "length/time²" …; "": none */
  const char *otherwise; /* what holds where it isn't set, in words; NULL: nothing to tell */
  const char *help;      /* one phrase */
  double low, high;      /* of KM_OPTION_WHOLE and _NUMBER: what is legal */
  const char *words;     /* of KM_OPTION_WORD: "one or another" */
  bool of_motion;        /* says how the mechanism moves: no matter to a question about one pose */
} km_option;

/* The value of an option: those members count that its type names. */
typedef struct km_option_value {
  bool flag;                    /* switched on */
  int whole;                    /* a whole number, or the place of a word */
  double numbers[3];            /* in the option's unit */
  int coordinate;               /* of the model; -1: none */
  int count;                    /* of the list */
  const int *coordinates;       /* of the model */
  const km_sweep_point *points; /* frames with the names of their columns */
  const km_load *loads;         /* instead of the model's */
  const km_port *ends;          /* that are pushed */
  km_port end;                  /* of an advantage */
  const char *text;             /* of a file */
} km_option_value;

/* The kinds of question, 0 … km_question_kinds() - 1: the name ("mobility", "advantage", "forces", "track"; "" if there
 * is no such kind) and an option, its own ones first, then those of every motion, which a track has none of; NULL past
 * the last one. */
KM_API int km_question_kinds(void);
KM_API const char *km_question_kind_name(int kind);
KM_API const km_option *km_question_option(int kind, int index);

/* A question about a mechanism, which must outlive it. One thread's. */
typedef struct km_question km_question;

/* KM_USAGE: there is no such kind. The caller frees `*out`. */
KM_API km_status km_question_create(const km_mechanism *mechanism, const char *kind, km_question **out,
                                    km_error *error);
KM_API void km_question_free(km_question *question);

/* Sets an option; lists and names are copied. The model's own `analysis` holds where nothing is set. KM_USAGE: there is no
 * such option, or the value doesn't fit it. Texts have the names of options in `backquotes`. */
KM_API km_status km_question_set(km_question *question, const char *option, const km_option_value *value,
                                 km_error *error);
/* Who is told how far the work is; NULL: nobody. */
KM_API void km_question_observe(km_question *question, km_progress progress, void *context);

/* Checks what needs several options, and makes what answers need; asking does it by itself. KM_USAGE, KM_MODEL. */
KM_API km_status km_question_prepare(km_question *question, km_error *error);
/* After km_mechanism_renumber: what was prepared and answered is forgotten, options stay. */
KM_API void km_question_refresh(km_question *question);
/* What the caller should know of how the options were understood, of the last preparation. Borrowed. */
KM_API const km_messages *km_question_notes(const km_question *question);

/* The plan by which asking would move the mechanism. Points are borrowed until an option is set. KM_USAGE: also of a
 * track, which moves by a path study. */
KM_API km_status km_question_make_plan(km_question *question, km_sweep_plan *out, km_error *error);

/* Moves the assembled state over the motion and answers at every row. KM_PARTIAL: the rows end (or begin) before the
 * range does, or the answer is no for a part of them; KM_NO_RESULT: there is no row. A new answer replaces the last
 * one. Cost: that of the sweep (km_mobility_sweep_run …). */
KM_API km_status km_question_compute(km_question *question, km_state *state, km_error *error);
/* One row at the state's pose, where nothing moves. Options of the motion don't count, but for the points. KM_USAGE: a
 * track isn't about one pose. */
KM_API km_status km_question_compute_here(km_question *question, km_state *state, km_error *error);

/* The last answer. Before the first one: NULL, 0. Borrowed until the next. A track has neither plan nor motion. */
KM_API const km_sweep_plan *km_question_plan(const km_question *question);
KM_API const km_sweep *km_question_motion(const km_question *question);
KM_API const km_table *km_question_table(const km_question *question);

/* A place that was located along the motion. */
typedef struct km_question_event {
  const char *name;    /* "toggle", "zero", "pole", "undefined", "peak", "minimum", "maximum", "branch point",
                        * "limit", "end" */
  const char *subject; /* a joint's label; "": the answer itself, or the mechanism */
  double s, value;     /* value: NaN where there is none */
} km_question_event;
/* The places of the last answer in the order of the sweep, 0 … the count; past the last one with
 * names "" and numbers NaN. Texts are borrowed. */
KM_API int km_question_event_count(const km_question *question);
KM_API km_question_event km_question_event_at(const km_question *question, int index);

/* What each kind gives beyond that; NULL of another kind, and before the first answer. */
KM_API const km_track *km_question_track(const km_question *question);
KM_API const km_mobility_sweep *km_question_mobility(const km_question *question);
KM_API const km_sweep_redundancies *km_question_redundancies(const km_question *question); /* of "mobility" */
KM_API const km_advantage_sweep *km_question_advantage(const km_question *question);
KM_API const km_statics_sweep *km_question_statics(const km_question *question);
/* Of a prepared question: input and output of "advantage"; forces, balance of "forces". NULL of another kind. */
KM_API const km_port *km_question_end(const km_question *question, bool output);
KM_API km_forces *km_question_forces(const km_question *question);
KM_API km_statics *km_question_balance(const km_question *question);

#ifdef __cplusplus
}
#endif
#endif
