/* Uncertainty of a mean if designs share parameters within rows. Private to study/. */
#ifndef KM_STUDY_STATISTICS_MEAN_UNCERTAINTY_H
#define KM_STUDY_STATISTICS_MEAN_UNCERTAINTY_H

/* Sums over the rows of Saltelli's scheme. Designs share parameters within a row only. */
typedef struct km_rows {
  double width;        /* designs of a row */
  double from;         /* first value, which is subtracted from all */
  double n, x;         /* this row: designs with a value, sum of their values */
  double rows;         /* rows with a value */
  double nn, nx, xx;   /* sums over the rows of n², n x, x² */
  double count, total; /* all designs with a value, sum of their values */
} km_rows;

void km_rows_add(km_rows *rows, double value);
/* Multiplies the values so far by a factor. */
void km_rows_scale(km_rows *rows, double factor);
/* Begins another row. */
void km_rows_next(km_rows *rows);

/* Kish's design effect: variance of the mean over that of as many independent designs (L. Kish 1965). `squares` is
 * the sum of squared deviations from the mean. Covariances within a row are between 0 and the variance, so the
 * effect is between 1 and the width of a row. */
double km_rows_effect(const km_rows *rows, double squares);

#endif
