/* Assembly modes from which a map begins: those of the parts that its drivers move, in all combinations. */
#include "base/arguments.h"
#include "kmech/mechanism.h"
#include "kmech/space.h"
#include "topology/mechanism.h"

#include <string.h>

/* True if the driver's part has loops. */
static bool has_loops(const km_mechanism *m, int driver) {
  int own = m->substructure_of[driver];
  return own >= 0 && m->substructures[own].loop_count > 0;
}

/* Combines the coordinates of two lists: those of `second` in its part, others of `first`. */
static km_status combine(const km_mechanism *m, const km_all_modes *first, const km_all_modes *second, int part,
                         km_all_modes *out, km_error *error) {
  size_t n = (size_t)m->coordinate_count;
  out->coordinates = KM_NEW(double, (size_t)first->count *(size_t)second->count *n + 1);
  if (!out->coordinates)
    return km_fail(error, KM_MEMORY, "out of memory for the modes of the map");
  for (int i = 0; i < first->count; ++i)
    for (int k = 0; k < second->count; ++k) {
      double *to = out->coordinates + (size_t)out->count++ * n;
      memcpy(to, first->coordinates + (size_t)i * n, n * sizeof *to);
      for (size_t c = 0; c < n; ++c)
        if (m->substructure_of[c] == part)
          to[c] = second->coordinates[(size_t)k * n + c];
    }
  out->is_complete = first->is_complete && second->is_complete;
  out->gap = first->is_complete ? second->gap : first->gap;
  return KM_OK;
}

/* The state's own configuration as the only mode. */
static km_status own_mode(const km_mechanism *m, const km_state *s, km_all_modes *out, km_error *error) {
  out->coordinates = KM_NEW(double, (size_t)m->coordinate_count + 1);
  if (!out->coordinates)
    return km_fail(error, KM_MEMORY, "out of memory for the modes of the map");
  out->count = 1;
  out->is_complete = true;
  return km_state_coordinates(m, s, out->coordinates, error);
}

km_status km_map_modes_find(const km_mechanism *m, const km_state *s, int first, int second, unsigned long seed,
                            km_progress progress, void *context, km_all_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the modes", error);
  *out = (km_all_modes){0};
  const int drivers[2] = {first, second};
  km_status status = km_check_given(m && s, "mechanism or state", error);
  for (int d = 0; !status && d < 2; ++d)
    status = km_check_index(drivers[d], m->coordinate_count, "coordinate", error);
  if (!status && first == second)
    status = km_fail(error, KM_USAGE, "both drivers of a map are the same joint; expected two");
  if (status)
    return status;
  int part[2] = {m->substructure_of[first], m->substructure_of[second]};
  bool is_one_list = part[0] == part[1] && has_loops(m, first);
  km_all_modes_def def = {.locked_count = is_one_list ? 2 : 1, .seed = seed};
  km_all_modes of[2] = {{0}, {0}};
  int lists = is_one_list ? 1 : 2;
  km_progress_stage stage = {.progress = progress, .context = context};
  for (int d = 0; !status && d < lists; ++d) {
    def.locked = drivers + d;
    km_progress_stage_next(&stage, (d + 1.0) / lists);
    status = has_loops(m, drivers[d]) ? km_all_modes_find(m, s, &def, km_progress_stage_report, &stage, &of[d], error)
                                      : own_mode(m, s, &of[d], error);
  }
  if (!status && is_one_list) {
    *out = of[0];
    return KM_OK;
  }
  if (!status)
    status = combine(m, &of[0], &of[1], part[1], out, error);
  km_all_modes_free(&of[0]);
  km_all_modes_free(&of[1]);
  return status;
}
