/* Parts of a map's search whose results a store keeps (docs/theory.md 4.19): after the modes, one piece for each. */
#ifndef KM_SPACE_MAP_STORE_H
#define KM_SPACE_MAP_STORE_H

#include "space/map/map_search.h"

/* A part of the search that begins at a grid point of the queue or at a point of a curve, number `first`. It changes
 * the queue with the grid points in it, curves and choices of rows only. */
typedef km_status (*km_map_work)(km_map_search *search, size_t first, km_error *error);

/* Does a part of the search, or takes its results from the store. */
km_status km_map_do(km_map_search *search, km_map_work work, size_t first, km_error *error);
/* As km_map_modes_find for the drivers and the seed of an open store: the modes are taken from it, or found and kept.
 * The store keeps no modes of a search that `progress` ended. Errors also of the store. */
km_status km_map_store_modes(km_map_store *store, const km_mechanism *m, const km_state *s, km_progress progress,
                             void *context, km_all_modes *out, km_error *error);
/* Checks that the store's modes are those of the map, and keeps them if it has none. */
km_status km_map_check_modes(km_map_search *search, const km_all_modes *modes, km_error *error);

#endif
