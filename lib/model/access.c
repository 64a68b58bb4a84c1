/* What a program asks of a model by index: names, owners, limits. */
#include "model/model.h"

#include <math.h>
#include <string.h>

static bool has_frame(const km_model *model, int frame) {
  return model && frame >= 0 && frame < model->frame_count;
}

int km_model_frame_count(const km_model *model) {
  return model ? model->frame_count : 0;
}

const char *km_model_frame_name(const km_model *model, int frame) {
  return has_frame(model, frame) ? model->frames[frame].name : "";
}

int km_model_frame_body(const km_model *model, int frame) {
  return has_frame(model, frame) ? model->frames[frame].body : -1;
}

int km_model_coordinate_joint(const km_model *model, int coordinate) {
  bool known = model && coordinate >= 0 && coordinate < model->coordinate_count;
  return known ? model->coordinates[coordinate].joint : -1;
}

bool km_model_coordinate_limits(const km_model *model, int coordinate, double *low, double *high) {
  if (!low || !high)
    return false;
  *low = *high = nan("");
  if (!model || coordinate < 0 || coordinate >= model->coordinate_count)
    return false;
  *low = model->coordinates[coordinate].low;
  *high = model->coordinates[coordinate].high;
  return isfinite(*low) || isfinite(*high);
}
