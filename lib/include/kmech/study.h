/* Studies of designs: one model with many values of its parameters, the same requests for each design, and statistics
 * of their figures of merit: comparison of variants, tolerances, sensitivities, optimisation (docs/theory.md 13).
 * Results are stored in one file as they are computed; a study that is opened again on its store computes only missing
 * results.
 *
 *   km_design_study_def def = km_design_study_default();   (or km_design_study_read from JSON)
 *   …
 *   km_design_study_open(&def, "crank.study.sqlite", false, &study, &error);
 *   km_design_study_run(study, 4, NULL, NULL, &error);
 *   km_design_study_statistics(study, 0, &statistics, &error);
 *   km_design_study_free(study);
 *
 * A design's results depend on its values only: not on its number, the number of threads or processes, or earlier
 * requests. */
#ifndef KMECH_STUDY_H
#define KMECH_STUDY_H

#include "kmech/base.h"
#include "kmech/model.h"
#include "kmech/question.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  KM_MAX_DESIGN_PARAMETERS = 32, /* largest number of parameters */
  KM_MAX_DESIGN_FIGURES = 64,    /* largest number of figures */
  KM_MAX_DESIGN_QUESTIONS = 16   /* largest number of requests */
};

/* A number that differs between designs. */
typedef struct km_design_parameter {
  const char *name;
  const char *path; /* parameter or number of the model, as in km_model_read_varied */
} km_design_parameter;

/* A named design: values of all parameters; NaN: the model's value. */
typedef struct km_design_variant {
  const char *name;
  const double *values; /* [parameter_count] */
} km_design_variant;

/* Values of one parameter in a grid of all combinations; the last axis changes fastest. */
typedef struct km_design_axis {
  int parameter, count; /* parameter; number of values */
  const double *values; /* [count] */
} km_design_axis;

/* Distribution of a parameter. */
typedef enum km_distribution {
  KM_UNIFORM,         /* uniform between low and high */
  KM_NORMAL,          /* normal: mean and standard deviation */
  KM_TRUNCATED_NORMAL /* normal, truncated to low … high */
} km_distribution;

/* Distribution of one parameter; the file's units. */
typedef struct km_design_spread {
  int parameter;                     /* parameter */
  km_distribution distribution;      /* distribution; it determines the numbers in use */
  double low, high, mean, deviation; /* bounds; mean and standard deviation of a normal distribution */
} km_design_spread;

/* Sampling method (docs/theory.md 13.2). */
typedef enum km_sampling {
  KM_SAMPLING_SOBOL,  /* Sobol sequence (I. Antonov and V. Saleev 1979), shifted modulo 1 by numbers from the seed */
  KM_SAMPLING_LATIN,  /* Latin hypercube: one design in each of `count` intervals of every parameter */
  KM_SAMPLING_RANDOM, /* independent pseudo-random numbers */
  KM_SAMPLING_LIST    /* stated values */
} km_sampling;

/* A sample. Design i depends on (method, seed, i) only; a Latin hypercube also on the count. */
typedef struct km_design_sample {
  km_sampling method;              /* sampling method */
  int count;                       /* largest number of designs */
  unsigned long seed;              /* seed of random numbers */
  const km_design_spread *spreads; /* distributions; other parameters have the model's value */
  int spread_count;
  const double *list; /* KM_SAMPLING_LIST: [count × parameter_count] values */
  bool indices;       /* Saltelli's scheme for Sobol indices: `count` rows of two matrices and their exchanges, count
                       * · (spreads + 2) designs */
  const char *accuracy_figure; /* the run stops when the mean of this figure meets `accuracy`; NULL: at `count` */
  double accuracy;             /* half width of its 95 % confidence interval */
} km_design_sample;

/* A variable of an optimisation, within bounds. */
typedef struct km_design_variable {
  int parameter;    /* parameter */
  double low, high; /* bounds */
  double start;     /* start value; NaN: the model's value if known and within the bounds, else the middle */
} km_design_variable;

/* Goal of an optimisation: a figure to minimise or maximise. */
typedef struct km_design_goal {
  const char *figure; /* name of the figure */
  bool largest;       /* true: maximise; false: minimise */
} km_design_goal;

/* An optimisation (docs/theory.md 13.6). Limits of figures are its constraints. Two goals: their front of
 * non-dominated designs. */
typedef struct km_design_optimise {
  const km_design_variable *variables; /* variables */
  int variable_count;
  km_design_goal goals[2]; /* one or two goals */
  int goal_count;
  const char *algorithm; /* name of the algorithm, see km_design_algorithm */
  int evaluations;       /* largest number of designs of each start */
  double tolerance;      /* tolerance of the variables, relative to the width of their bounds */
  int starts;            /* number of starts: the first at the variables' starts, others random within the bounds;
                          * two goals: number of points of the front */
  unsigned long seed;    /* seed of starts and of stochastic algorithms */
} km_design_optimise;

/* Kind of a figure: reduction of a column of the answer's table. */
typedef enum km_design_figure_kind {
  KM_DESIGN_MIN,         /* minimum over the rows */
  KM_DESIGN_MAX,         /* maximum over the rows */
  KM_DESIGN_SPAN,        /* maximum − minimum */
  KM_DESIGN_MEAN,        /* mean over the driver, by the trapezoidal rule */
  KM_DESIGN_AT,          /* value at a value of the driver */
  KM_DESIGN_WHERE_MIN,   /* value of the driver at the minimum */
  KM_DESIGN_WHERE_MAX,   /* value of the driver at the maximum */
  KM_DESIGN_REACHED,     /* reached part of the driver's range, or of the time: |last s − first s| */
  KM_DESIGN_TOGGLES,     /* number of dead points: of any joint; of input and output of a mechanical advantage; of
                      * actuators */
  KM_DESIGN_DISTANCE,    /* root mean square distance of stated points from the path of the traced point `column`: path
                       * synthesis */
  KM_DESIGN_RMS,         /* root mean square over the driver or time */
  KM_DESIGN_PEAK,        /* largest magnitude */
  KM_DESIGN_WHERE_PEAK,  /* value of the driver, or time, of the largest magnitude */
  KM_DESIGN_LAST,        /* value of the last row: where a sweep or a run ends */
  KM_DESIGN_SETTLING,    /* time from which on the column stays within `at` times its largest distance from its last
                          * value */
  KM_DESIGN_FORMULA,     /* expression `column` of figures of the same question before it */
  KM_DESIGN_FIGURE_KINDS /* number of enumerators */
} km_design_figure_kind;

/* Figure of merit: one number of an answer. */
typedef struct km_design_figure {
  const char *name;
  km_design_figure_kind kind; /* reduction of the rows */
  /* Column of the answer's table; "body/frame" of KM_DESIGN_DISTANCE; expression of KM_DESIGN_FORMULA. */
  const char *column;
  double at;            /* KM_DESIGN_AT: value of s; KM_DESIGN_SETTLING: fraction, 0.02: to 2 % */
  const double *points; /* KM_DESIGN_DISTANCE: [3 × point_count] points, inertial axes, model's length unit */
  int point_count;
  double low, high; /* limits of accepted values; ∓infinity: none */
  int better;       /* +1: larger is better, −1: smaller is better, 0: neither */
} km_design_figure;

/* Option of a request (km_question_option), with joints by labels and frames by paths. */
typedef struct km_design_option {
  const char *name;
  bool flag;             /* value of an option without an argument */
  const double *numbers; /* numbers of the option */
  int number_count;
  const char *const *texts; /* labels, words, "body/frame", "body/frame:dx,dy,dz" */
  int text_count;
} km_design_option;

/* A coordinate, by its label, and its value. */
typedef struct km_design_setting {
  const char *coordinate; /* label of the coordinate */
  double value;           /* value in the coordinate's unit */
} km_design_setting;

/* A request that is computed for every design, with its figures. */
typedef struct km_design_question {
  const char *name; /* name, used by its files and figures */
  /* Kind as in km_question_create; NULL: the study's function computes the figures in order. */
  const char *kind;
  const km_design_option *options; /* options of the request */
  int option_count;
  const km_design_setting *holds, *sets; /* held coordinates, in addition to the model's; coordinates set at the
                                          * start of the motion */
  int hold_count, set_count;
  const km_design_figure *figures; /* figures of the answer */
  int figure_count;
  const char *const *bands; /* columns whose rows are stored, for quantiles along the motion */
  int band_count;
} km_design_question;

/* Function that computes figures[figures of the one request] from the parameters, in place of a model. Called by
 * several threads at once. Any status except KM_OK: the design has no result. */
typedef km_status (*km_design_function)(void *context, const double *values, double *figures, km_error *error);

/* Definition of a study. Start from km_design_study_default(). All pointers except `memory` are borrowed and must
 * outlive the study. Exactly one of variants, axes, sample and optimise defines the designs. */
typedef struct km_design_study_def {
  const char *model;           /* model file; meshes are relative to its folder; NULL: `bytes` or `function` only */
  const char *bytes;           /* [size] text of the model; NULL: read from the file */
  size_t size;                 /* bytes of the text */
  km_design_function function; /* function that replaces a model */
  void *context;               /* argument of `function` */
  const km_design_parameter *parameters; /* parameters */
  int parameter_count;
  const km_design_variant *variants; /* named designs */
  int variant_count;
  const km_design_axis *axes; /* axes of a grid */
  int axis_count;
  const km_design_sample *sample;      /* random designs or a list; NULL: none */
  const km_design_optimise *optimise;  /* optimisation; NULL: none */
  const km_design_question *questions; /* requests of each design */
  int question_count;
  const char *folder;      /* folder to which files of requests are relative; NULL: the working folder */
  const char *sample_file; /* CSV file of the sample's list, not yet read; NULL: none */
  struct km_arena *memory; /* memory of a definition that was read; NULL: none */
} km_design_study_def;
KM_API km_design_study_def km_design_study_default(void);
KM_API km_design_figure km_design_figure_default(void); /* default figure: KM_DESIGN_MIN, no limits */

/* Reads JSON (docs/studies.md) into a definition initialised by km_design_study_default. Findings go to `messages`
 * with their place. KM_MODEL, KM_MEMORY. Free the definition in any case. */
KM_API km_status km_design_study_read(const char *bytes, size_t size, km_messages *messages, km_design_study_def *def,
                                      km_error *error);
KM_API void km_design_study_def_free(km_design_study_def *def);

/* An open study with its store. */
typedef struct km_design_study km_design_study;

/* Checks a definition, its model and requests, and opens or creates its store; path NULL: in memory. `replace`: the
 * results of another study in the store are deleted. KM_USAGE: invalid definition, or the store of another study;
 * KM_IO: the store can't be read or written, or is in use by another run; KM_MODEL: invalid model. The caller frees
 * `*out`. */
KM_API km_status km_design_study_open(const km_design_study_def *def, const char *store, bool replace,
                                      km_design_study **out, km_error *error);
KM_API void km_design_study_free(km_design_study *study);

/* Number of designs of the definition; for an optimisation, of the evaluated designs in their order. */
KM_API int km_design_study_designs(const km_design_study *study);
/* Gets values[parameter_count] of a design; NaN: the model's value. KM_USAGE. */
KM_API km_status km_design_study_values(const km_design_study *study, int design, double *values, km_error *error);
/* The model's value of a parameter; NaN if the file doesn't state it. */
KM_API double km_design_study_base(const km_design_study *study, int parameter);
/* Characteristic length used for all designs, in the model's unit; 0: the study has a function. */
KM_API double km_design_study_length(const km_design_study *study);

/* Computes all answers that the store lacks, on up to `jobs` threads. KM_CANCELLED: stopped by `progress`; all
 * computed answers are stored. KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_run(km_design_study *study, int jobs, km_progress progress, void *context,
                                     km_error *error);
/* Worker processes that evaluate designs together: a leader with the store and members, each with its own study of
 * the same definition. The caller provides the transport of messages. */
typedef struct km_design_workers {
  void *context; /* argument of both functions */
  int size;      /* number of members, 1 … size; the leader is 0 */
  /* Sends a message; false: it failed. */
  bool (*send)(void *context, int member, const void *bytes, size_t size);
  /* Receives the next message, borrowed until the next call; returns its sender, −1: none. `wait`: waits for one. */
  int (*receive)(void *context, bool wait, const void **bytes, size_t *size);
} km_design_workers;
/* Runs a study as the leader; idle members get pieces of work. Optimisations use the leader's threads only. KM_IO: a
 * message failed, or a member failed. */
KM_API km_status km_design_study_run_leader(km_design_study *study, int jobs, const km_design_workers *workers,
                                            km_progress progress, void *context, km_error *error);
/* Runs a member: evaluates the leader's designs until the leader ends the service. KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_run_worker(km_design_study *study, int jobs, const km_design_workers *workers,
                                            km_error *error);
/* Ends the service of all members; the leader calls it in any case. */
KM_API void km_design_workers_stop(const km_design_workers *workers);

/* Takes only the answers in the store, without computing; designs and results are those of a run that ended there. */
KM_API km_status km_design_study_lookup(km_design_study *study, km_error *error);
/* True if every design of the last run or lookup has an answer; false also if the store can't be read. */
KM_API bool km_design_study_is_complete(km_design_study *study);
/* Number of designs that the last run computed; km_design_study_found: that it found in the store. */
KM_API int km_design_study_computed(const km_design_study *study);
KM_API int km_design_study_found(const km_design_study *study);

/* Outcome of a design. */
typedef enum km_design_outcome {
  KM_DESIGN_DONE,        /* complete answers */
  KM_DESIGN_SHORT,       /* the motion ends before its range, or a part of the answer is missing */
  KM_DESIGN_EMPTY,       /* no configuration of the range is reachable */
  KM_DESIGN_UNASSEMBLED, /* its loops can't be closed, or the requested configuration isn't reachable */
  KM_DESIGN_FAULTY,      /* invalid model, for example a negative mass */
  KM_DESIGN_MAX_STEPS,   /* an iteration didn't converge */
  KM_DESIGN_MISSING,     /* not computed yet */
  KM_DESIGN_OUTCOMES     /* number of enumerators */
} km_design_outcome;
KM_API const char *km_design_outcome_name(km_design_outcome outcome); /* name, as "done", "stops short" */

enum {
  KM_DESIGN_REASON = 200 /* bytes of a reason, including the NUL */
};
/* Result of a design. */
typedef struct km_design_result {
  km_design_outcome outcome;             /* worst outcome of its requests */
  char reason[KM_DESIGN_REASON];         /* reason; "" if complete with a value of every figure */
  double figures[KM_MAX_DESIGN_FIGURES]; /* figures of all requests in order; NaN: no value */
} km_design_result;
/* Reads a result from the store. KM_USAGE, KM_IO. */
KM_API km_status km_design_study_result(const km_design_study *study, int design, km_design_result *out,
                                        km_error *error);

/* True if a design is accepted: all requests complete and all figures within their limits. A motion that ends early
 * is acceptable if a figure `reached` has limits or is a goal. */
KM_API bool km_design_study_accepts(const km_design_study *study, const km_design_result *result);

/* Best accepted design of an optimisation; −1: none. Two goals: the first design of the front. */
KM_API int km_design_study_best(const km_design_study *study);
/* Front of two goals: writes the non-dominated designs, sorted by the first goal, to `designs[room]`; returns their
 * number. */
KM_API int km_design_study_front(const km_design_study *study, int *designs, int room);
/* Name of optimisation algorithm `index`, NULL past the last one; km_design_algorithm_about: its description. */
KM_API const char *km_design_algorithm(int index);
KM_API const char *km_design_algorithm_about(int index);

enum {
  KM_DESIGN_QUANTILES = 7,       /* number of quantiles */
  KM_MAX_RANKED_DESIGNS = 200000 /* largest number of representative designs for quantiles and ranks */
};
/* Probability of quantile k: 1, 5, 25, 50, 75, 95, 99 %. */
KM_API double km_design_quantile(int k);

/* Statistics of a figure (docs/theory.md 13.3). Designs whose motion ends early are included with their values;
 * designs without a value aren't. Intervals have 95 % confidence for random designs; errors of a low-discrepancy
 * sample are smaller. */
typedef struct km_design_statistics {
  int count;                    /* designs with a value */
  double mean, mean_half_width; /* mean; half width t s/√n by Student's t, with n reduced if designs share parameters
                                 * (`indices`) */
  double deviation;             /* standard deviation s, with n − 1 */
  double least, greatest;       /* minimum and maximum */
  int least_design, greatest_design;     /* designs of the extreme values; −1: none */
  double quantiles[KM_DESIGN_QUANTILES]; /* quantiles of up to KM_MAX_RANKED_DESIGNS designs */
  int good;                              /* designs within the figure's limits */
} km_design_statistics;
/* Computes the statistics of a figure. KM_USAGE, KM_IO, KM_MEMORY. The first call after a run reads all results,
 * O(designs); further calls O(1). */
KM_API km_status km_design_study_statistics(km_design_study *study, int figure, km_design_statistics *out,
                                            km_error *error);

/* Outcomes of all designs. */
typedef struct km_design_yield {
  int count;                           /* computed designs */
  int outcomes[KM_DESIGN_OUTCOMES];    /* number of designs per outcome */
  int good;                            /* accepted designs */
  double share, share_low, share_high; /* yield good/count with Wilson's interval; with `indices`, for the effective
                                        * number of independent designs, at most two per row */
} km_design_yield;
KM_API km_status km_design_study_yield(km_design_study *study, km_design_yield *out, km_error *error);

/* k-th of `count` representative designs: the first ones of a random sample; else one of each of `count` consecutive
 * pieces of about equal size (stratified). −1: none. O(1). */
KM_API int km_design_study_representative(const km_design_study *study, int k, int count);
/* Values of a figure of the representative designs, at most KM_MAX_RANKED_DESIGNS: `values[room]` or NULL; NaN: no
 * value. Returns their number. */
KM_API int km_design_study_column(km_design_study *study, int figure, double *values, int room);

/* Spearman's rank correlation of a figure with each parameter, correlation[parameter_count] (docs/theory.md 13.4).
 * Ties have their mean rank. NaN: one of both doesn't vary. O(n log n) per parameter. */
KM_API km_status km_design_study_ranks(km_design_study *study, int figure, double *correlation, km_error *error);

/* Sobol indices of a sample with `indices`, for its spreads in order: `first` (first-order indices, A. Saltelli and
 * others 2010) and `total` (M. Jansen 1999), each [spread count], with `first_half_width` and `total_half_width` of
 * their intervals (ratio of two means; docs/theory.md 13.5). Rows with a design without a value are skipped.
 * KM_USAGE: the sample has no indices. */
KM_API km_status km_design_study_indices(km_design_study *study, int figure, double *first, double *first_half_width,
                                         double *total, double *total_half_width, km_error *error);

/* Quantiles of a band along the motion, of the first 10000 designs: quantiles[rows × KM_DESIGN_QUANTILES],
 * counts[rows] designs that reach the row. *rows is set; arrays may be NULL. KM_USAGE, KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_bands(km_design_study *study, int question, int band, int *rows, double *quantiles,
                                       int *counts, km_error *error);

/* Number of figures of all requests. km_design_study_figure returns one in order, NULL past the last; borrowed. */
KM_API int km_design_study_figures(const km_design_study *study);
KM_API const km_design_figure *km_design_study_figure(const km_design_study *study, int figure);
KM_API const char *km_design_study_figure_unit(const km_design_study *study, int figure); /* unit; "": none or
                                                                                           * unknown */

/* Reads the model of a design. The caller frees it. KM_USAGE: the study has none. */
KM_API km_status km_design_study_model(const km_design_study *study, int design, km_model **out, km_error *error);
/* Evaluated design, for pictures: all objects of one request. Free it by km_evaluated_design_free. */
typedef struct km_evaluated_design {
  km_model *model;         /* model with the design's values */
  km_mechanism *mechanism; /* mechanism compiled from it */
  km_state *state;         /* state of that mechanism after the request */
  km_question *question;   /* request with its answer */
} km_evaluated_design;
/* Compiles a design and computes a request. KM_PARTIAL, KM_NO_RESULT as km_question_compute. */
KM_API km_status km_design_study_evaluate(const km_design_study *study, int design, int question,
                                          km_evaluated_design *out, km_error *error);
KM_API void km_evaluated_design_free(km_evaluated_design *evaluated);

/* True if value `a` of a figure is better than `b`, by its `better`; a number is better than NaN. */
KM_API bool km_design_is_better(const km_design_figure *figure, double a, double b);

#ifdef __cplusplus
}
#endif
#endif
