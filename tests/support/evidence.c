/* Keeps the comparison of a claim that comes nearest to its tolerance, and writes it down when the test is over. */
#include "support/evidence.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

static struct {
  bool open;
  long comparisons;
  double share, ours, reference, tolerance; /* worst comparison: difference over tolerance */
} kept;

int evidence_begin(void **claim) {
  (void)claim;
  kept.open = true;
  kept.comparisons = 0;
  kept.share = -1.0;
  return 0;
}

void evidence_compare(double ours, double reference, double tolerance) {
  double apart = fabs(ours - reference), share = apart == 0.0 ? 0.0 : apart / tolerance;
  if (!kept.open)
    return;
  ++kept.comparisons;
  if (share <= kept.share)
    return;
  kept.share = share;
  kept.ours = ours;
  kept.reference = reference;
  kept.tolerance = tolerance;
}

/* One line: the claim, why, how many comparisons, and the worst one's three numbers, with tabulators between. */
int evidence_end(void **claim) {
  const evidence_claim *c = *claim;
  const char *path = getenv("KMECH_EVIDENCE");
  FILE *file = path ? fopen(path, "a") : NULL;
  kept.open = false;
  if (!file)
    return path ? -1 : 0;
  fprintf(file, "%s\t%s\t%ld\t%.17g\t%.17g\t%.17g\n", c->claim, c->because, kept.comparisons, kept.ours, kept.reference,
          kept.tolerance);
  return fclose(file);
}
