/* How well a mean is known where designs share parameters. Private to study/. */
#ifndef KM_STUDY_STATISTICS_MEAN_UNCERTAINTY_H
#define KM_STUDY_STATISTICS_MEAN_UNCERTAINTY_H

/* Sums over the rows of Saltelli's scheme, whose designs share parameters with each other, but with no other row's. */
typedef struct km_rows {
  double width;        /* designs of a row */
  double from;         /* values count from the first one */
  double n, x;         /* designs with a value, and the sum of their values, in this row */
  double rows;         /* rows with a value, */
  double nn, nx, xx;   /* and sums over them of n², n x, x² */
  double count, total; /* all designs with a value, and their sum */
} km_rows;

void km_rows_add(km_rows *rows, double value);
/* The values so far are multiplied by a factor. */
void km_rows_scale(km_rows *rows, double factor);
/* What comes now belongs to another row. */
void km_rows_next(km_rows *rows);

/* Kish's design effect: how many times the variance of the mean is that of as many independent designs (L. Kish, Survey
 * Sampling, 1965). `squares` is the sum of the squared deviations from the mean. Covariances of designs that share
 * parameters are between 0 and the variance, so that it is between 1 and the width of a row. */
double km_rows_effect(const km_rows *rows, double squares);

#endif
