/* Measurements of a test for the page of evidence (scripts/evidence). */
#ifndef KM_TESTS_EVIDENCE_H
#define KM_TESTS_EVIDENCE_H

/* A law or a published answer that a test holds, and where its tolerance comes from. While the test runs, the
 * comparisons of assert_near and assert_at_most are the claim's; the one that comes nearest to its tolerance is
 * written to the file that the environment's KMECH_EVIDENCE names, where it names one. */
typedef struct evidence_claim {
  const char *claim, *because;
} evidence_claim;

/* A line of the table of tests in main: a test that holds a claim. */
#define claim_test(test, words, tolerance)                                                                             \
  {                                                                                                                    \
#test, test, evidence_begin, evidence_end, &(evidence_claim) {                                                     \
      words, tolerance                                                                                                 \
    }                                                                                                                  \
  }

int evidence_begin(void **claim); /* the claim comes as the test's first state */
int evidence_end(void **claim);

/* Records a comparison of assert_near, successful or not. */
void evidence_compare(double ours, double reference, double tolerance);

#endif
