/* Where a coordinate stands in a mechanism. */
#include "kmech/inspect.h"
#include "topology/mechanism.h"

static bool has(const km_mechanism *m, int coordinate) {
  return m && coordinate >= 0 && coordinate < m->coordinate_count;
}

int km_coordinate_substructure(const km_mechanism *m, int coordinate) {
  return has(m, coordinate) ? m->substructure_of[coordinate] : -1;
}

bool km_coordinate_is_held(const km_mechanism *m, int coordinate) {
  return has(m, coordinate) && m->held[coordinate];
}
