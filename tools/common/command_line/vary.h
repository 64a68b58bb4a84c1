/* --vary: the variants of a model, all combinations of the values that its numbers are given. */
#ifndef KT_COMMON_COMMAND_LINE_VARY_H
#define KT_COMMON_COMMAND_LINE_VARY_H

#include "common/common.h"

#define KT_VARY(TARGET)                                                                                                  \
  {                                                                                                                      \
    "vary", 0, "PATH=FROM:TO:N",                                                                                         \
        "Compare variants: give a parameter, or a number by its path such as crank.tip.x, N values from FROM to TO, or " \
        "PATH=A,B,C these (repeatable: all combinations)",                                                               \
        KT_TEXTS, TARGET, KT_ABOUT_MODEL                                                                                 \
  }

enum { KT_MOST_VARIED = 8, KT_VARIANT_NAME = 256 };

/* One number and the values that it takes. */
typedef struct kt_varied {
  char *path;
  double *values;
  int count;
  int digits; /* digits of its values in names: 6, or as many as distinguish them */
} kt_varied;

/* Variants of --vary. Variant k of `count` has one value of each number; the last number changes fastest. */
typedef struct kt_variants {
  kt_varied numbers[KT_MOST_VARIED];
  int number_count;
  int count; /* number of variants; 1 without --vary */
} kt_variants;

/* Reads the options. KT_USAGE with a message: more than `most` variants, a faulty option. Free in any case. */
kt_exit kt_variants_read(const kt_common *common, const kt_texts *texts, int most, kt_variants *out);
void kt_variants_free(kt_variants *variants);

/* The values of a variant: out[number_count], and its name: "rise=40, crank.tip.x=5". */
void kt_variant(const kt_variants *variants, int index, km_assignment *out, char name[KT_VARIANT_NAME]);

#endif
