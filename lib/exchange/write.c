/* Models as the text of files. */
#include "kmech/write.h"

#include "base/check.h"
#include "exchange/json/convert.h"
#include "exchange/json/json.h"

#include <math.h>

km_status km_model_write(const km_model *model, const double *q, km_bytes *out, km_error *error) {
  km_arena arena = {0};
  km_text text = {0};
  const km_value *value = NULL;
  km_status status = km_check_given(out != NULL, "place for the result", error);
  if (status)
    return status;
  *out = (km_bytes){0};
  status = km_check_given(model != NULL, "model", error);
  for (int c = 0; q && !status && c < model->coordinate_count; ++c)
    if (!isfinite(q[c]))
      status = km_fail(error, KM_USAGE, "found a displacement that is not finite");
  if (!status)
    status = km_model_convert(model, &model->units, q, false, &arena, &value, error);
  if (!status) {
    km_json_write(value, &text);
    status = km_text_give(&text, out, error);
  }
  km_arena_free(&arena);
  return status;
}
