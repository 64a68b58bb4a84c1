/* Requests (km_question): one interface for every analysis of a motion. A request has a kind and options. Its result
 * has rows in named columns, located events, and figures of merit over the rows (km_table_figure). Tools, studies,
 * other languages and viewers use this interface; results of a single kind have their own headers.
 *
 *   km_question_create(mechanism, "advantage", &question, &error);
 *   km_option_value range = {.numbers = {20.0, 32.0}};
 *   km_question_set(question, "range", &range, &error);
 *   km_question_compute(question, state, &error);
 *   km_table_write_csv(km_question_table(question), "brake.advantage.csv", &error);
 *   km_question_free(question); */
#ifndef KMECH_QUESTION_H
#define KMECH_QUESTION_H

#include "kmech/arm.h"
#include "kmech/base.h"
#include "kmech/clearance.h"
#include "kmech/dynamics.h"
#include "kmech/sweep.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Type of an option's value, with the member of km_option_value that holds it. */
typedef enum km_option_type {
  KM_OPTION_FLAG,        /* flag */
  KM_OPTION_WHOLE,       /* whole */
  KM_OPTION_NUMBER,      /* numbers[0] */
  KM_OPTION_RANGE,       /* numbers[0], numbers[1] */
  KM_OPTION_VECTOR,      /* numbers[0 … 2] */
  KM_OPTION_WORD,        /* whole: index of the word in the option's `words` */
  KM_OPTION_COORDINATE,  /* coordinate */
  KM_OPTION_SENSE,       /* coordinate, and numbers[0] > 0: forwards, < 0: backwards */
  KM_OPTION_COORDINATES, /* coordinates[count] */
  KM_OPTION_POINTS,      /* points[count] */
  KM_OPTION_END,         /* end */
  KM_OPTION_ENDS,        /* ends[count]: points along directions */
  KM_OPTION_LOADS,       /* loads[count]: all loads, in place of the model's own */
  KM_OPTION_SETTINGS,    /* coordinates[count] with a number each, settings[count] */
  KM_OPTION_MODULES,     /* modules[count]: force modules */
  KM_OPTION_PAIR,        /* numbers[0], and numbers[1], 0 where one is stated */
  KM_OPTION_FILE,        /* text: a file's name */
  KM_OPTION_BODY_PAIRS   /* pairs[count]: bodies whose clearance is wanted */
} km_option_type;

/* An option of a kind of request. */
typedef struct km_option {
  const char *name;      /* name for km_question_set */
  km_option_type type;   /* type of its value */
  const char *argument;  /* placeholder in a help text, such as "FROM:TO"; NULL: a flag */
  const char *unit;      /* "driver's", "length/time²" …; "": none */
  const char *otherwise; /* default, in words; NULL: obvious */
  const char *help;      /* description in one phrase */
  double low, high;      /* legal range of KM_OPTION_WHOLE and KM_OPTION_NUMBER */
  const char *words;     /* words of KM_OPTION_WORD: "one or another" */
  bool of_motion;        /* concerns the motion: ignored by a request at one configuration */
} km_option;

/* The value of an option; its type selects the members. */
typedef struct km_option_value {
  bool flag;                    /* switched on */
  int whole;                    /* an integer, or the index of a word */
  double numbers[3];            /* numbers in the option's unit */
  int coordinate;               /* index in the model; -1: none */
  int count;                    /* length of the list */
  const int *coordinates;       /* indices in the model */
  const double *settings;       /* numbers of the coordinates: values, or rates per time unit */
  const int *modules;           /* indices of force modules of the model */
  const km_sweep_point *points; /* frames with the names of their columns */
  const km_load *loads;         /* loads in place of the model's */
  const km_port *ends;          /* pushed points */
  const km_body_pair *pairs;    /* two bodies each */
  km_port end;                  /* port of an advantage */
  const char *text;             /* name of a file */
} km_option_value;

/* Kinds of requests, 0 … km_question_kinds() - 1: the name ("mobility", "advantage", "forces", "track", "run",
 * "inverse", "motion", "allowance", "clearance", "modes", "map", "turning",
 * "volume"; "" for another index) and an option: the kind's own ones first, then those of every sweep
 * ("mobility", "advantage", "forces", "motion", "allowance", "clearance"); NULL past the last. */
KM_API int km_question_kinds(void);
KM_API const char *km_question_kind_name(int kind);
KM_API const km_option *km_question_option(int kind, int index);

/* A request about a mechanism, which must outlive it. Not thread-safe. */
typedef struct km_question km_question;

/* Creates a request. KM_USAGE: unknown kind; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_question_create(const km_mechanism *mechanism, const char *kind, km_question **out,
                                    km_error *error);
KM_API void km_question_free(km_question *question);

/* Sets an option; lists and names are copied. The model's own `analysis` applies to unset options. KM_USAGE: an
 * unknown option or an invalid value. Messages show option names in `backquotes`. */
KM_API km_status km_question_set(km_question *question, const char *option, const km_option_value *value,
                                 km_error *error);
/* Sets the progress callback; NULL: none. */
KM_API void km_question_observe(km_question *question, km_progress progress, void *context);

/* Checks combinations of options and prepares the computation; km_question_compute does it implicitly. KM_USAGE,
 * KM_MODEL. */
KM_API km_status km_question_prepare(km_question *question, km_error *error);
/* Invalidates preparation and result after km_mechanism_renumber; options remain. */
KM_API void km_question_refresh(km_question *question);
/* Returns the notes of the last preparation about the interpretation of the options. Borrowed. */
KM_API const km_messages *km_question_notes(const km_question *question);

/* Returns the plan of the motion. Points are borrowed until an option is set. KM_USAGE: also for a kind without a
 * sweep: a track moves by a path study, a run by its forces, an inverse motion by its rates. */
KM_API km_status km_question_make_plan(km_question *question, km_sweep_plan *out, km_error *error);

/* Moves the assembled state over the motion and computes every row; a run and an inverse motion leave the state where
 * it is. KM_PARTIAL: the rows end (or begin) before the range, or a part of them is negative, or a run passes a limit
 * where no stop acts; KM_NO_RESULT: no row. A new result replaces the last one. Cost: that of the
 * sweep (km_mobility_sweep_run …). */
KM_API km_status km_question_compute(km_question *question, km_state *state, km_error *error);
/* Computes one row at the state's configuration. Options of the motion are ignored, except for points. KM_USAGE: a
 * kind without a sweep isn't about one configuration. */
KM_API km_status km_question_compute_here(km_question *question, km_state *state, km_error *error);

/* Return parts of the last result; NULL before the first. Borrowed until the next. Kinds without a sweep have neither
 * plan nor motion. */
KM_API const km_sweep_plan *km_question_plan(const km_question *question);
KM_API const km_sweep *km_question_motion(const km_question *question);
KM_API const km_table *km_question_table(const km_question *question);

/* An event along the motion. */
typedef struct km_question_event {
  const char *name;    /* "toggle", "zero", "pole", "undefined", "peak", "minimum", "maximum", "branch point",
                        * "limit", "end", "crossing", "contact" */
  const char *subject; /* a joint's label, two bodies; "": the result itself, or the mechanism */
  double s, value;     /* driver value, arc length or time; value, NaN without one */
} km_question_event;
/* Return the events of the last result, 0 … count - 1, in the order of the sweep; past the last one with names "" and
 * numbers NaN. Texts are borrowed. */
KM_API int km_question_event_count(const km_question *question);
KM_API km_question_event km_question_event_at(const km_question *question, int index);

/* Return the results of one kind; NULL for another kind, and before the first result. */
KM_API const km_track *km_question_track(const km_question *question);
KM_API const km_history *km_question_history(const km_question *question); /* kinds "run" and "inverse" */
/* Definition of a run, to whose crossings km_history.crossings refers; NULL: another kind, or no result. */
KM_API const km_history_def *km_question_run_def(const km_question *question);
KM_API const km_mobility_sweep *km_question_mobility(const km_question *question);
KM_API const km_sweep_redundancies *km_question_redundancies(const km_question *question); /* kind "mobility" */
KM_API const km_advantage_sweep *km_question_advantage(const km_question *question);
KM_API const km_statics_sweep *km_question_statics(const km_question *question);
KM_API const km_motion_sweep *km_question_velocities(const km_question *question);    /* kind "motion" */
KM_API const km_allowance_sweep *km_question_allowance(const km_question *question);  /* kind "allowance" */
KM_API const km_clearance_sweep *km_question_clearances(const km_question *question); /* kind "clearance" */
/* Return parts of a prepared request: input and output of "advantage"; forces and balance of "forces". NULL for
 * another kind. */
KM_API const km_port *km_question_end(const km_question *question, bool output);
KM_API km_forces *km_question_forces(const km_question *question);
KM_API km_statics *km_question_balance(const km_question *question);

#ifdef __cplusplus
}
#endif
#endif
