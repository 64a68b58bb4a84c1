/* Words about the size of a workspace (kmech/report.h). */
#include "kmech/report.h"

#include <math.h>

void km_space_volume_text(const km_space_volume *v, km_text *out) {
  if (!v || !v->points || !out)
    return;
  const char *unit = km_table_unit(v->points, 0), *power = v->dimension == 3 ? "³" : "²";
  km_text_format(out, "%s %.6g %s%s", v->dimension == 3 ? "volume" : "area", v->volume, unit, power);
  if (v->undecided > 0)
    km_text_format(out, " without %d undecided sample%s", v->undecided, v->undecided == 1 ? "" : "s");
  km_text_format(out, ", 95 %% interval %.6g to %.6g %s%s", v->low, v->high, unit, power);
}

void km_space_volume_axis_text(const km_space_volume *v, int axis, km_text *out) {
  if (!v || axis < 0 || axis >= v->dimension || !out)
    return;
  const double *a = v->axis[axis];
  int along = 0;
  while (along < 3 && a[along] != 1.0)
    ++along;
  if (along < 3)
    km_text_format(out, "%c", "xyz"[along]);
  else
    km_text_format(out, "along (%.6g, %.6g, %.6g)", a[0], a[1], a[2]);
}
