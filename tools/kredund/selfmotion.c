#include "kredund/kredund.h"
kt_exit kredund_selfmotion(int argc, char **argv) {
  (void)argc;
  (void)argv;
  return KT_USAGE;
}
