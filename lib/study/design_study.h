/* A study that is open, and what its parts share. Private to study/. */
#ifndef KM_STUDY_DESIGN_STUDY_H
#define KM_STUDY_DESIGN_STUDY_H

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "continuation/batch/batch.h"
#include "kmech/study.h"

typedef struct km_entry_store km_entry_store;
typedef struct km_sampler km_sampler;

/* Where a parameter's number goes in a model that is read already: the places of km_model_numbers_list. */
typedef struct km_patch_places {
  int *places;
  int count;
} km_patch_places;

/* How a design's numbers get into a model without reading the file again. */
typedef struct km_patch {
  bool works; /* false: some parameter needs the whole reader */
  km_patch_places *parameters;
  size_t number_count; /* of the model */
} km_patch;

/* Designs that an optimisation has asked for, start by start. */
typedef struct km_trail {
  double *values; /* [count × parameters] */
  int *starts;    /* [count] */
  int count;
  size_t value_room, start_room;
} km_trail;

typedef struct km_collected km_collected; /* statistics.c */
typedef struct km_ranking km_ranking;     /* sensitivity.c */

struct km_design_study {
  const km_design_study_def *def;
  km_arena arena;
  const char *bytes; /* the model's text */
  size_t size;
  double *base;       /* [parameter] the file's own values */
  double *reference;  /* [parameter] the design whose characteristic length serves all */
  double length;      /* that length, in the model's unit */
  const char *meshes; /* what they weigh in it, as text; "" */
  km_patch patch;
  int figure_count, first_figure[KM_MAX_DESIGN_QUESTIONS + 1];
  const km_design_figure *figures[KM_MAX_DESIGN_FIGURES];
  const char *units[KM_MAX_DESIGN_FIGURES]; /* by the reference design's answers; "" */
  int band_rows[KM_MAX_DESIGN_QUESTIONS];   /* rows that are kept of each band */
  int question_ids[KM_MAX_DESIGN_QUESTIONS];
  km_entry_store *store;
  km_sampler *sampler; /* of a sample; NULL: none */
  km_trail trail;
  km_collected *collected; /* what the results come to; NULL: not looked at since the last run */
  km_ranking *ranking;     /* and the designs' ranks; NULL: not asked for since then */
  int computed, found;
  bool ended_early; /* an optimisation was recalled as far as the store has answers, and no further */
  int stopped_at;   /* designs of a sample whose accuracy was reached; 0: it wasn't */
};

/* What one question said of a design. */
typedef struct km_design_answer {
  km_design_outcome outcome;
  char reason[KM_DESIGN_REASON];
  double *figures; /* [figures of the question] */
  double *bands;   /* [bands × rows] NaN where the motion doesn't come; NULL: none */
} km_design_answer;

/* definition_check.c: is the definition one that can be opened? KM_USAGE with the place. */
km_status km_design_check(const km_design_study_def *def, km_error *error);
/* Index of a figure by its name among all questions'; -1: none. */
int km_design_find_figure(const km_design_study_def *def, const char *name);

/* designs.c: how many there are without those of an optimisation, and the values of one. */
int km_designs_planned(const km_design_study *study);
void km_design_values(const km_design_study *study, int design, double *values);

/* The k-th of so many designs that stand for all: the first ones of a sample that is drawn, which is as good a sample; of others,
 * which may have an order, one of each of so many pieces. */
int km_design_drawn(const km_design_study *study, int k, int count);

/* parameter_bounds.c: are all designs within the bounds that the model states for its parameters (of a normal distribution its mean)?
 * KM_USAGE where they aren't, KM_MEMORY. */
km_status km_design_check_bounds(const km_design_study *study, km_error *error);

/* model_patch.c: finds where the parameters go, by reading the model with other values of each and comparing, and tries the
 * answer on several designs at once. KM_MEMORY, KM_MODEL. */
km_status km_patch_find(km_design_study *study, km_error *error);

/* options.c: gives a question the options of its definition. */
km_status km_design_set_options(const km_design_study_def *study, const km_design_question *def, const km_model *model,
                                km_question *question, km_error *error);
/* The file that an option names, seen from where the program runs. NULL: it names none, or out of memory. */
const char *km_design_file(const km_design_study_def *study, const km_design_question *def,
                           const km_design_option *option, km_arena *arena);
/* Holds or sets by labels, behind those that `out` has already. */
km_status km_design_settings(const km_model *model, const km_design_setting *settings, int count, const char *what,
                             km_hold *out, int *out_count, km_error *error);

/* figures.c: the figures of an answered question, and its bands. */
void km_design_take_figures(const km_design_question *def, const km_question *question, double *figures);
/* Why a figure that is NaN is; "" where none is. */
void km_design_tell_missing(const km_design_question *def, const km_question *question, const double *figures,
                            char reason[KM_DESIGN_REASON]);
void km_design_take_bands(const km_design_question *def, const km_question *question, int rows, double *bands);
/* Are the columns there? KM_USAGE with the nearest names; units[figures of the question]. */
km_status km_design_check_figures(const km_design_question *def, const km_question *question, const char **units,
                                  km_arena *arena, km_error *error);

/* One design to be answered by a worker. */
typedef struct km_design_task {
  const double *values;      /* [parameters] */
  const bool *wanted;        /* [questions] NULL: all */
  km_design_answer *answers; /* [questions] */
  km_status status;          /* KM_MEMORY; whatever else goes wrong is an outcome */
  km_error *error;
} km_design_task;

/* study_worker.c: one thread's models, mechanisms and states, which answer several designs side by side, each with the bits that it
 * has alone. */
typedef struct km_design_worker km_design_worker;
km_status km_design_worker_create(const km_design_study *study, km_design_worker **out, km_error *error);
void km_design_worker_free(km_design_worker *worker);
/* Answers the questions of up to KM_BATCH_LANES tasks. */
void km_design_worker_answer(km_design_worker *worker, km_design_task *tasks, int count);

/* model.c: the model of a design by the whole reader, with the length that serves all. */
km_status km_design_read_model(const km_design_study *study, const double *values, km_model **out, km_error *error);
/* Does the design's own characteristic length serve all? */
bool km_design_is_reference(const km_design_study *study, const double *values);
/* Brings a design to where a question starts: its holds and sets beside the model's own. */
km_status km_design_bring(const km_model *model, const km_design_question *question, km_mechanism **mechanism,
                          km_state **state, km_error *error);

/* The same with a mechanism that holds nothing and has the design's numbers: see km_mechanism_recompile_at. *held stays NULL where
 * nothing is held. */
km_status km_design_bring_again(const km_mechanism *free, km_state *there, const km_design_question *question,
                                km_mechanism **held, km_state **at, km_error *error);

/* statistics.c: with the ranks. */
void km_design_forget_statistics(km_design_study *study);
void km_design_forget_ranking(km_ranking *ranking);
/* The values of sorted[count] at the probabilities of km_design_quantile, by linear interpolation. */
void km_quantiles_of(const double *sorted, int count, double out[KM_DESIGN_QUANTILES]);
int km_compare_numbers(const void *a, const void *b);

/* run.c: makes room for the answers to all questions of a design in the arena. */
km_design_answer *km_design_answers(const km_design_study *study, km_arena *arena);
/* Values in the order of the definition's parameters, all as the model has them. */
void km_design_clear(const km_design_study *study, double *values);

#endif
