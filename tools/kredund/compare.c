#include "kredund/kredund.h"
kt_exit kredund_compare(int argc, char **argv) {
  (void)argc;
  (void)argv;
  return KT_USAGE;
}
