/* An open study, and the functions that its parts share. Private to study/. */
#ifndef KM_STUDY_DESIGN_STUDY_H
#define KM_STUDY_DESIGN_STUDY_H

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "continuation/batch/batch.h"
#include "kmech/study.h"

typedef struct km_entry_store km_entry_store;
typedef struct km_sampler km_sampler;

/* Numbers of a compiled model that a parameter sets: indices of km_model_numbers_list. */
typedef struct km_patch_places {
  int *places;
  int count;
} km_patch_places;

/* Patch: sets a design's parameters in a model without reading the file. */
typedef struct km_patch {
  bool is_valid; /* false: a parameter needs the reader */
  km_patch_places *parameters;
  size_t number_count; /* numbers of the model */
} km_patch;

/* Designs of an optimisation, by start. */
typedef struct km_trail {
  double *values; /* [count × parameters] */
  int *starts;    /* [count] */
  int count;
  size_t value_capacity, start_capacity;
} km_trail;

typedef struct km_statistics_cache km_statistics_cache; /* statistics.c */
typedef struct km_ranking km_ranking;                   /* sensitivity.c */

struct km_design_study {
  const km_design_study_def *def;
  km_arena arena;
  const char *bytes; /* text of the model */
  size_t size;
  double *base;       /* [parameter] values of the file */
  double *reference;  /* [parameter] reference design, whose characteristic length is used for all */
  double length;      /* characteristic length, in the model's unit */
  const char *meshes; /* hashes of the meshes of its model, as text; "": none */
  km_patch patch;
  int figure_count, first_figure[KM_MAX_DESIGN_QUESTIONS + 1];
  const km_design_figure *figures[KM_MAX_DESIGN_FIGURES];
  const char *units[KM_MAX_DESIGN_FIGURES]; /* units of the figures, from the reference design; "": none */
  int band_rows[KM_MAX_DESIGN_QUESTIONS];   /* rows of each band */
  int question_ids[KM_MAX_DESIGN_QUESTIONS];
  km_entry_store *store;
  km_sampler *sampler; /* sampler of a sample; NULL: none */
  km_trail trail;
  km_statistics_cache *collected; /* cached statistics; NULL: not computed since the last run */
  km_ranking *ranking;            /* cached ranks; NULL: not computed since then */
  int computed, found;
  bool ended_early; /* a lookup of an optimisation ended where the store has no answers */
  int stopped_at;   /* number of designs at which a sample reached its accuracy; 0: not reached */
};

/* Answer of one request for a design. */
typedef struct km_design_answer {
  km_design_outcome outcome;
  char reason[KM_DESIGN_REASON];
  double *figures; /* [figures of the request] */
  double *bands;   /* [bands × rows] NaN: not reached by the motion; NULL: none */
} km_design_answer;

/* definition_check.c: checks a definition. KM_USAGE with the place. */
km_status km_design_check(const km_design_study_def *def, km_error *error);
/* Index of a figure by its name among the figures of all requests; −1: none. */
int km_design_find_figure(const km_design_study_def *def, const char *name);

/* design_list.c: number of designs, without those of an optimisation, and the values of one. */
int km_designs_planned(const km_design_study *study);
void km_design_values(const km_design_study *study, int design, double *values);

/* k-th of `count` representative designs: the first ones of a random sample, which are a sample themselves; else one
 * random design from each of `count` consecutive pieces (stratified), because the designs can be ordered. */
int km_design_representative(const km_design_study *study, int k, int count);

/* parameter_bounds.c: checks that all designs are within the bounds of the model's parameters (normal distribution:
 * its mean). KM_USAGE: they aren't; KM_MEMORY. */
km_status km_design_check_bounds(const km_design_study *study, km_error *error);

/* model_patch.c: finds the numbers that the parameters set, by reading the model with other values and comparing,
 * and verifies them. KM_MEMORY, KM_MODEL. */
km_status km_patch_find(km_design_study *study, km_error *error);

/* question_options.c: sets the options of a request from its definition. */
km_status km_design_set_options(const km_design_study_def *study, const km_design_question *def, const km_model *model,
                                km_question *question, km_error *error);
/* Path of the file that an option names, relative to the working folder. NULL: none, or out of memory. */
const char *km_design_file(const km_design_study_def *study, const km_design_question *def,
                           const km_design_option *option, km_arena *arena);
/* Appends held or set coordinates, found by labels, to `out`. */
km_status km_design_settings(const km_model *model, const km_design_setting *settings, int count, const char *what,
                             km_hold *out, int *out_count, km_error *error);

/* figures.c: figures of a computed request; km_design_copy_bands its bands. */
void km_design_copy_figures(const km_design_question *def, const km_question *question, double *figures);
/* Reason why a figure is NaN; "": none is. */
void km_design_missing_reason(const km_design_question *def, const km_question *question, const double *figures,
                              char reason[KM_DESIGN_REASON]);
void km_design_copy_bands(const km_design_question *def, const km_question *question, int rows, double *bands);
/* Checks that the columns exist, and finds units[figures of the request]. KM_USAGE with the closest names. */
km_status km_design_check_figures(const km_design_question *def, const km_question *question, const char **units,
                                  km_arena *arena, km_error *error);

/* Design to be evaluated by a worker. */
typedef struct km_design_task {
  const double *values;      /* [parameters] */
  const bool *wanted;        /* [requests] true: to be computed; NULL: all */
  km_design_answer *answers; /* [requests] */
  km_status status;          /* KM_MEMORY; all other failures are outcomes */
  km_error *error;
} km_design_task;

/* study_worker.c: models, mechanisms and states of one thread, which evaluates designs in batches with the bits of
 * single evaluations. */
typedef struct km_design_worker km_design_worker;
km_status km_design_worker_create(const km_design_study *study, km_design_worker **out, km_error *error);
void km_design_worker_free(km_design_worker *worker);
/* Computes the requests of up to KM_BATCH_LANES tasks. */
void km_design_worker_answer(km_design_worker *worker, km_design_task *tasks, int count);

/* design_model.c: reads the model of a design, with the common characteristic length. */
km_status km_design_read_model(const km_design_study *study, const double *values, km_model **out, km_error *error);
/* True if the design is the reference design. */
bool km_design_is_reference(const km_design_study *study, const double *values);
/* Compiles a design and moves it to the start of a request: the request's held and set coordinates in addition to
 * the model's. */
km_status km_design_compile_at(const km_model *model, const km_design_question *question, km_mechanism **mechanism,
                               km_state **state, km_error *error);

/* As km_design_compile_at, from a mechanism without held joints that has the design's numbers
 * (km_mechanism_recompile_at). *held remains NULL if nothing is held. */
km_status km_design_recompile_at(const km_mechanism *free, km_state *there, const km_design_question *question,
                                 km_mechanism **held, km_state **at, km_error *error);

/* statistics.c: frees cached statistics and ranks. */
void km_design_free_statistics(km_design_study *study);
void km_ranking_free(km_ranking *ranking);
/* Quantiles of sorted[count] at the probabilities of km_design_quantile, by linear interpolation. */
void km_quantiles_of(const double *sorted, int count, double out[KM_DESIGN_QUANTILES]);
int km_compare_numbers(const void *a, const void *b);

/* design_evaluation.c: allocates the answers to all requests of a design in the arena. */
km_design_answer *km_design_answers(const km_design_study *study, km_arena *arena);
/* Sets all values to NaN: the value of the model. */
void km_design_clear(const km_design_study *study, double *values);

#endif
