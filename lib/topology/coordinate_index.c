/* Queries of a coordinate: its substructure, and whether it is held. */
#include "kmech/inspect.h"
#include "topology/mechanism.h"

static bool is_valid(const km_mechanism *m, int coordinate) {
  return m && coordinate >= 0 && coordinate < m->coordinate_count;
}

int km_coordinate_substructure(const km_mechanism *m, int coordinate) {
  return is_valid(m, coordinate) ? m->substructure_of[coordinate] : -1;
}

bool km_coordinate_is_held(const km_mechanism *m, int coordinate) {
  return is_valid(m, coordinate) && m->held[coordinate];
}
