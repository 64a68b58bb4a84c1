/* Studies of designs: one model with many values of its parameters, the same questions asked of each, and what their
 * figures of merit tell: variants side by side, spreads by tolerances, the best design. Results go to a store, one file,
 * as they come: a study that is opened again on its store asks only what is missing.
 *
 *   km_design_study_def def = km_design_study_default();   (or km_design_study_read from JSON)
 *   …
 *   km_design_study_open(&def, "crank.study.sqlite", false, &study, &error);
 *   km_design_study_run(study, 4, NULL, NULL, &error);
 *   km_design_study_statistics(study, 0, &statistics, &error);
 *   km_design_study_free(study);
 *
 * A design's results depend on its values alone: not on its place, the number of threads or ranks, or what was asked
 * before. */
#ifndef KMECH_STUDY_H
#define KMECH_STUDY_H

#include "kmech/base.h"
#include "kmech/model.h"
#include "kmech/question.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  KM_MAX_DESIGN_PARAMETERS = 32, /* of one study */
  KM_MAX_DESIGN_FIGURES = 64,    /* of all its questions together */
  KM_MAX_DESIGN_QUESTIONS = 16   /* of one study */
};

/* A number that differs from design to design. */
typedef struct km_design_parameter {
  const char *name;
  const char *path; /* a parameter of the model, or any number of it, as km_model_read_varied takes it */
} km_design_parameter;

/* Values of all parameters under a name; NaN: as the model has it. */
typedef struct km_design_variant {
  const char *name;
  const double *values; /* [parameter_count] */
} km_design_variant;

/* The values that one parameter takes in a grid of all combinations, the last axis changing fastest. */
typedef struct km_design_axis {
  int parameter, count; /* which; how many values */
  const double *values; /* [count] */
} km_design_axis;

/* How a number is spread. */
typedef enum km_distribution {
  KM_UNIFORM,         /* between low and high */
  KM_NORMAL,          /* mean and deviation */
  KM_TRUNCATED_NORMAL /* the same, and nothing outside low to high */
} km_distribution;

/* How a parameter spreads. All in the file's units. */
typedef struct km_design_spread {
  int parameter;                     /* which */
  km_distribution distribution;      /* which of the numbers count */
  double low, high, mean, deviation; /* bounds; of a normal distribution mean and standard deviation */
} km_design_spread;

/* How a sample is drawn. */
typedef enum km_sampling {
  KM_SAMPLING_SOBOL, /* low-discrepancy sequence (Sobol; Antonov and Saleev), shifted modulo 1 by numbers from the seed */
  KM_SAMPLING_LATIN,  /* Latin hypercube: each of `count` slices of every parameter has one design */
  KM_SAMPLING_RANDOM, /* independent pseudo-random numbers */
  KM_SAMPLING_LIST    /* the values that are given */
} km_sampling;

/* A sample. Design i follows from (method, seed, i) alone, of a Latin hypercube from the count too. */
typedef struct km_design_sample {
  km_sampling method;              /* how it is drawn */
  int count;                       /* designs, at most */
  unsigned long seed;              /* of what is random */
  const km_design_spread *spreads; /* of parameters that aren't among them the model's own value counts */
  int spread_count;
  const double *list; /* [count × parameter_count] of KM_SAMPLING_LIST */
  bool indices;       /* Saltelli's scheme: `count` rows of two matrices and their exchanges, count · (spreads + 2)
                       * designs, from which Sobol's indices of sensitivity follow */
  const char *accuracy_figure; /* stops as soon as the mean of this figure is known well enough; NULL: at `count` */
  double accuracy;             /* half width of its 95 % confidence interval */
} km_design_sample;

/* A variable of an optimisation, within bounds. */
typedef struct km_design_variable {
  int parameter;    /* which */
  double low, high; /* its bounds */
  double start;     /* NaN: the model's own value where it is known and within the bounds, else the middle */
} km_design_variable;

/* What an optimisation makes as small or as large as it can. */
typedef struct km_design_goal {
  const char *figure; /* by its name */
  bool largest;       /* else the smallest is best */
} km_design_goal;

/* An optimisation. The limits of figures are its constraints. With two goals: the front of what can't be bettered in
 * both. */
typedef struct km_design_optimise {
  const km_design_variable *variables; /* what it may change */
  int variable_count;
  km_design_goal goals[2]; /* one, or two that compete */
  int goal_count;
  const char *algorithm; /* km_design_algorithm lists them */
  int evaluations;       /* most designs of each start */
  double tolerance;      /* of the variables, over the width of their bounds */
  int starts;            /* the first at the variables' starts, the others spread over the bounds by the seed; of two
                          * goals: points of the front that are looked for */
  unsigned long seed;    /* of starts, and of algorithms with chance */
} km_design_optimise;

/* What of an answer's column is the figure. */
typedef enum km_design_figure_kind {
  KM_DESIGN_MIN,       /* the least value over the rows */
  KM_DESIGN_MAX,       /* the greatest */
  KM_DESIGN_SPAN,      /* greatest − least */
  KM_DESIGN_MEAN,      /* over the driver, by the trapezoidal rule */
  KM_DESIGN_AT,        /* at a value of the driver */
  KM_DESIGN_WHERE_MIN, /* the driver's value at the least value */
  KM_DESIGN_WHERE_MAX, /* that at the greatest value */
  KM_DESIGN_REACHED,   /* how much of the driver's range is reached: |last s − first s| */
  KM_DESIGN_TOGGLES, /* how many dead points lie in it: of any joint; of an advantage's input and output; of forces' actuators */
  KM_DESIGN_DISTANCE, /* root mean square of the distances of given points from the path of `column`, a point that the
                       * question traces: path synthesis */
  KM_DESIGN_FIGURE_KINDS /* how many there are */
} km_design_figure_kind;

/* A figure of merit: one number from an answer. */
typedef struct km_design_figure {
  const char *name;
  km_design_figure_kind kind; /* what it takes from the rows */
  const char *column;         /* of the answer's table; "body/frame" of KM_DESIGN_DISTANCE */
  double at;                  /* the s of KM_DESIGN_AT */
  const double *points;       /* [3 × point_count] of KM_DESIGN_DISTANCE, inertial axes, model's length unit */
  int point_count;
  double low, high; /* what is good enough; ∓infinity: any */
  int better;       /* +1: larger ones are, −1: smaller ones, 0: neither */
} km_design_figure;

/* An option of a question (km_question_option): what its type takes, with joints by labels and frames by their paths. */
typedef struct km_design_option {
  const char *name;
  bool flag;             /* of an option without an argument */
  const double *numbers; /* of one that takes numbers */
  int number_count;
  const char *const *texts; /* labels, words, "body/frame", "body/frame:dx,dy,dz" */
  int text_count;
} km_design_option;

/* A joint's coordinate, by its label, and a value. */
typedef struct km_design_setting {
  const char *coordinate; /* its label */
  double value;           /* in the coordinate's unit */
} km_design_setting;

/* A question that every design is asked, and its figures. */
typedef struct km_design_question {
  const char *name; /* of its files and figures */
  const char *
      kind; /* of km_question_create: "mobility", "advantage", "forces", "track"; NULL: the study's function gives the figures, in their order */
  const km_design_option *options; /* how it is asked */
  int option_count;
  const km_design_setting *holds, *sets; /* beside the model's own holds; sets: the pose that the motion starts from */
  int hold_count, set_count;
  const km_design_figure *figures; /* what its answer is reduced to */
  int figure_count;
  const char *const *bands; /* columns of which every row is kept, for quantiles along the motion */
  int band_count;
} km_design_question;

/* Figures as a function of the parameters, instead of a model: figures[those of the one question]. Called by several
 * threads at once. Any status but KM_OK: the design has no result. */
typedef km_status (*km_design_function)(void *context, const double *values, double *figures, km_error *error);

/* What a study is. Start from km_design_study_default(). All that it points to is borrowed and must outlive the study,
 * but for `memory`. Just one of variants, axes, sample and optimise says which designs there are. */
typedef struct km_design_study_def {
  const char *model;           /* file; meshes are looked for from its folder; NULL: `bytes` or `function` alone */
  const char *bytes;           /* [size] its text; NULL: read from the file */
  size_t size;                 /* bytes of the text */
  km_design_function function; /* instead of a model */
  void *context;               /* handed to `function` */
  const km_design_parameter *parameters; /* what differs between designs */
  int parameter_count;
  const km_design_variant *variants; /* designs by name */
  int variant_count;
  const km_design_axis *axes; /* all combinations of values */
  int axis_count;
  const km_design_sample *sample;      /* designs by chance, or a list; NULL: none */
  const km_design_optimise *optimise;  /* a search; NULL: none */
  const km_design_question *questions; /* what each design is asked */
  int question_count;
  const char *folder;      /* from which files that questions name are seen; NULL: where the program runs */
  const char *sample_file; /* a CSV file that the sample's list is still to be read from; NULL: none */
  struct km_arena *memory; /* of what was read, NULL: none */
} km_design_study_def;
KM_API km_design_study_def km_design_study_default(void);
KM_API km_design_figure km_design_figure_default(void); /* KM_DESIGN_MIN, no limits */

/* Reads JSON (docs/studies.md) into a definition that began as km_design_study_default. Findings go to `messages` with their place; KM_MODEL, KM_MEMORY. The
 * definition is to be freed in any case. */
KM_API km_status km_design_study_read(const char *bytes, size_t size, km_messages *messages, km_design_study_def *def,
                                      km_error *error);
KM_API void km_design_study_def_free(km_design_study_def *def);

/* A study that was opened on its store. */
typedef struct km_design_study km_design_study;

/* Checks a definition, its model and questions, and opens its store, which is made where there is none; path NULL: in
 * memory. `replace`: the results of another study there are lost. KM_USAGE: the definition is wrong, or the store holds another study; KM_IO: the store
 * can't be read or written, or another run is writing it; KM_MODEL: the model is bad. The caller frees `*out`. */
KM_API km_status km_design_study_open(const km_design_study_def *def, const char *store, bool replace,
                                      km_design_study **out, km_error *error);
KM_API void km_design_study_free(km_design_study *study);

/* Designs that the definition has; of an optimisation those in the store, in the order of their evaluation. */
KM_API int km_design_study_designs(const km_design_study *study);
/* values[parameter_count] of design i; NaN: as the model has it. KM_USAGE. */
KM_API km_status km_design_study_values(const km_design_study *study, int design, double *values, km_error *error);
/* The model's own value of a parameter; NaN where the file doesn't state it. */
KM_API double km_design_study_base(const km_design_study *study, int parameter);
/* The characteristic length that serves all designs, in the model's unit; 0: the study is about a function. */
KM_API double km_design_study_length(const km_design_study *study);

/* Asks what the store doesn't hold yet on up to `jobs` threads. KM_CANCELLED: stopped by `progress`, all that was
 * answered is stored. KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_run(km_design_study *study, int jobs, km_progress progress, void *context,
                                     km_error *error);
/* Processes that answer designs together: one leads and has the store, the others serve it, each with a study of its own
 * of the same definition. How messages travel is the caller's. */
typedef struct km_design_workers {
  void *context; /* handed to both functions */
  int size;      /* members beside the leader, 1 … size; the leader is 0 */
  /* False: the message didn't go. */
  bool (*send)(void *context, int member, const void *bytes, size_t size);
  /* The next message, whoever sent it, borrowed until the next call: its sender; -1: there is none. `wait`: until there
   * is one. */
  int (*receive)(void *context, bool wait, const void **bytes, size_t *size);
} km_design_workers;
/* km_design_study_run by the leader, with the members' help: they get pieces of work as they ask for them. Optimisations
 * go on the leader's threads alone. KM_IO: a message didn't go, or a member failed. */
KM_API km_status km_design_study_run_leader(km_design_study *study, int jobs, const km_design_workers *crew,
                                            km_progress progress, void *context, km_error *error);
/* Answers the leader's designs until it says that there are no more. KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_run_worker(km_design_study *study, int jobs, const km_design_workers *crew,
                                            km_error *error);
/* Ends the service of all members; by the leader, whatever went wrong. */
KM_API void km_design_workers_stop(const km_design_workers *crew);

/* The same without asking anything: takes what the store has, so that designs and results are those of a run that ended
 * here. */
KM_API km_status km_design_study_lookup(km_design_study *study, km_error *error);
/* Has every design of the last run or recall an answer? False too where the store can't be read. */
KM_API bool km_design_study_is_complete(km_design_study *study);
/* How many designs the last run computed, and how many it found in the store. */
KM_API int km_design_study_computed(const km_design_study *study);
KM_API int km_design_study_found(const km_design_study *study);

/* What became of a design. */
typedef enum km_design_outcome {
  KM_DESIGN_DONE,        /* answered in full */
  KM_DESIGN_SHORT,       /* the motion ends before its range does, or a part of the answer is no */
  KM_DESIGN_EMPTY,       /* no pose of the range is in reach */
  KM_DESIGN_UNASSEMBLED, /* its loops can't close, or the pose asked for isn't in reach */
  KM_DESIGN_FAULTY,      /* it isn't a model: a negative mass … */
  KM_DESIGN_MAX_STEPS,   /* an iteration gave out */
  KM_DESIGN_MISSING,     /* not asked yet */
  KM_DESIGN_OUTCOMES     /* how many there are */
} km_design_outcome;
KM_API const char *km_design_outcome_name(km_design_outcome outcome); /* "done", "stops short" … */

enum {
  KM_DESIGN_REASON = 200 /* bytes of a reason, the NUL included */
};
/* What a design answered. */
typedef struct km_design_result {
  km_design_outcome outcome;             /* the worst of its questions */
  char reason[KM_DESIGN_REASON];         /* "" when done with a value of every figure */
  double figures[KM_MAX_DESIGN_FIGURES]; /* of all questions in their order; NaN: none */
} km_design_result;
/* From the store. KM_USAGE, KM_IO. */
KM_API km_status km_design_study_result(const km_design_study *study, int design, km_design_result *out,
                                        km_error *error);

/* Is a design good enough: all questions answered in full, and every figure within its limits? A motion that stops short
 * is, where `reached` is a figure with limits or a goal, which then says how short is too short. */
KM_API bool km_design_study_accepts(const km_design_study *study, const km_design_result *result);

/* After an optimisation, or a recall: the best design that is good enough, -1: none is. Of two goals: the first design of
 * the front. */
KM_API int km_design_study_best(const km_design_study *study);
/* Of two goals: the designs that no other betters in both, by the first goal, into designs[room]; returns how many there
 * are. */
KM_API int km_design_study_front(const km_design_study *study, int *designs, int room);
/* The algorithms of an optimisation, 0 …: the word, NULL past the last one; and what it is, for people. */
KM_API const char *km_design_algorithm(int index);
KM_API const char *km_design_algorithm_about(int index);

enum {
  KM_DESIGN_QUANTILES = 7,       /* how many quantiles are told */
  KM_MAX_RANKED_DESIGNS = 200000 /* from how many designs, which stand for all, quantiles and ranks are */
};
/* 1, 5, 25, 50, 75, 95, 99 %: the probability of quantile k. */
KM_API double km_design_quantile(int k);

/* What the designs say of a figure. Designs whose motion stops short count with what they have; those without a value
 * don't. Intervals are those of 95 % confidence of random designs; of a low-discrepancy sample the errors are smaller. */
typedef struct km_design_statistics {
  int count;                    /* designs with a value */
  double mean, mean_half_width; /* t s/√n by Student's t; n counts less where designs share parameters (`indices`) */
  double deviation;             /* s, with n − 1 */
  double least, greatest;       /* extreme values */
  int least_design, greatest_design;     /* -1: none */
  double quantiles[KM_DESIGN_QUANTILES]; /* of up to KM_MAX_RANKED_DESIGNS designs */
  int good;                              /* designs within the figure's limits */
} km_design_statistics;
/* KM_USAGE, KM_IO, KM_MEMORY. The first call after a run reads all results: O(designs); the others O(1). */
KM_API km_status km_design_study_statistics(km_design_study *study, int figure, km_design_statistics *out,
                                            km_error *error);

/* What became of all designs. */
typedef struct km_design_yield {
  int count;                           /* designs that were asked */
  int outcomes[KM_DESIGN_OUTCOMES];    /* how many had each */
  int good;                            /* that km_design_study_accepts */
  double share, share_low, share_high; /* good / count, with Wilson's interval; with `indices` that of as many
                                        * independent designs as tell the same, two in a row at most */
} km_design_yield;
KM_API km_status km_design_study_yield(km_design_study *study, km_design_yield *out, km_error *error);

/* The k-th of `count` designs that stand for all of the study: the first ones of a sample that is drawn, which are as good a sample; of
 * other designs, which may have an order, one of each of `count` pieces of about one size. -1: there is none. O(1). */
KM_API int km_design_study_representative(const km_design_study *study, int k, int count);
/* Values of a figure of the designs that stand for all, at most KM_MAX_RANKED_DESIGNS, NaN where there is none: values[room], or
 * NULL. Returns how many there are. */
KM_API int km_design_study_column(km_design_study *study, int figure, double *values, int room);

/* Spearman's rank correlation of a figure with each parameter, correlation[parameter_count]; ties have their mean rank;
 * NaN where one of both doesn't change. O(n log n) a parameter. */
KM_API km_status km_design_study_ranks(km_design_study *study, int figure, double *correlation, km_error *error);

/* Sobol's indices of a sample with `indices`, of its spreads in their order: first-order (Saltelli et al. 2010) and total
 * (Jansen 1999), each [spread count], with half widths of their intervals (first_half_width, total_half_width): those of
 * quotients of two means. Rows with a design that has no value don't count. KM_USAGE: the sample isn't one with indices. */
KM_API km_status km_design_study_indices(km_design_study *study, int figure, double *first, double *first_half_width,
                                         double *total, double *total_half_width, km_error *error);

/* Quantiles of a band along the motion, of the first 10000 designs: quantiles[rows × KM_DESIGN_QUANTILES], counts[rows]
 * how many designs come there. `rows` receives their number; arrays may be NULL. KM_USAGE, KM_IO, KM_MEMORY. */
KM_API km_status km_design_study_bands(km_design_study *study, int question, int band, int *rows, double *quantiles,
                                       int *counts, km_error *error);

/* The figures of all questions, in their order; NULL past the last. Borrowed. */
KM_API int km_design_study_figures(const km_design_study *study);
KM_API const km_design_figure *km_design_study_figure(const km_design_study *study, int figure);
KM_API const char *km_design_study_figure_unit(const km_design_study *study, int figure); /* "": none or unknown */

/* The model of a design. The caller frees it. KM_USAGE: the study has none. */
KM_API km_status km_design_study_model(const km_design_study *study, int design, km_model **out, km_error *error);
/* Brings a design to its pose and asks it a question: for pictures. The caller frees all four. KM_PARTIAL, KM_NO_RESULT
 * as km_question_compute. */
typedef struct km_evaluated_design {
  km_model *model;         /* with the design's numbers */
  km_mechanism *mechanism; /* compiled from it */
  km_state *state;         /* of that mechanism, where the question left it */
  km_question *question;   /* with its answer */
} km_evaluated_design;
KM_API km_status km_design_study_evaluate(const km_design_study *study, int design, int question,
                                          km_evaluated_design *out, km_error *error);
KM_API void km_evaluated_design_free(km_evaluated_design *asked);

/* Is the figure better in `a` than in `b`? By its `better`; a number is better than none. */
KM_API bool km_design_is_better(const km_design_figure *figure, double a, double b);

#ifdef __cplusplus
}
#endif
#endif
