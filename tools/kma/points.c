/* Points as ends of a leverage. */
#include "kma/kma.h"

bool kma_place_points(const kt_common *common, kt_question *asked, const kt_texts *points) {
  kt_texts *input = kt_question_texts(asked, "input"), *output = kt_question_texts(asked, "output");
  for (int i = points->count; i-- > 0;) {
    if (!kt_direction(points->items[i])) {
      kt_usage(common, "--point", points->items[i], "BODY/FRAME:DX,DY,DZ, a point of a body and a direction");
      return false;
    }
    bool free_output = output->count == 0;
    kt_texts *end = free_output ? output : input;
    if (end->count > 0) {
      kt_usage(common, "--point", points->items[i], "one point for each end that --input and --output leave open");
      return false;
    }
    end->items[end->count++] = points->items[i];
    kt_question_call(asked, free_output ? "output" : "input", "--point");
  }
  return true;
}
