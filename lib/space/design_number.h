/* A number of a design in a compiled mechanism (docs/theory.md 4.20).
 *
 *   p -> mechanism(p):   the model's file is read with the number p, and its numbers replace those of the mechanism
 *
 * The mechanism keeps its structure, so that Jacobians at two values of p can be compared entry by entry. */
#ifndef KM_SPACE_DESIGN_NUMBER_H
#define KM_SPACE_DESIGN_NUMBER_H

#include "kinematics/state.h"
#include "model/model_numbers.h"

enum { KM_READ_NUMBERS = 4 }; /* values whose numbers are kept: those of a central difference, and the last one */

/* The numbers of the model at one value. */
typedef struct km_read_numbers {
  double value;    /* NaN: none */
  double *numbers; /* [count of the model's numbers] */
} km_read_numbers;

typedef struct km_design_number {
  km_model *model;
  km_mechanism *m;
  km_state *s;
  double value;
  const char *path;
  km_text bytes;            /* the file */
  const char *file;         /* its name */
  km_model_numbers numbers; /* all numbers of `model` */
  km_read_numbers read[KM_READ_NUMBERS];
  int oldest;    /* index of the one to replace next */
  double *saved; /* [KM_SAVED_PER_COLUMN × columns] of `substructure` */
  double *q;     /* [coordinate] workspace */
  int substructure;
  km_status status; /* status of the last km_design_number_set */
} km_design_number;

/* Reads the model's file and compiles it with the held joints of `like`. The state has the configuration of `at`.
 * KM_IO, KM_MODEL, KM_USAGE: the path is no number; KM_MEMORY. Close in any case. */
km_status km_design_number_open(const km_mechanism *like, const km_state *at, int substructure, const char *file,
                                const char *path, km_design_number *out, km_error *error);
void km_design_number_close(km_design_number *number);
/* Changes the number; the substructure keeps its coordinates. False where no model has this number, or its structure is
 * another. */
bool km_design_number_set(km_design_number *number, double value);

#endif
