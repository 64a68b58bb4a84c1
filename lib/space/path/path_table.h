/* Tables of a path: configurations over its length, drivers over time (docs/theory.md 4.21).
 *
 *   s(τ) = L (τ − sin(2πτ) / 2π),   τ = 0 … 1: cycloidal motion, at rest at both ends, ds/dτ <= 2 L */
#ifndef KM_SPACE_PATH_TABLE_H
#define KM_SPACE_PATH_TABLE_H

#include "space/path/path_points.h"
#include "space/path/path_trees.h"

/* Creates the tables without rows. False when out of memory. */
bool km_path_table_create(const km_path_steps *steps, km_space_path *out);
/* Writes the points, their length and margins, and the motion. False when out of memory. */
bool km_path_table_write(km_path_steps *steps, const km_path_points *points, km_arena *arena, km_space_path *out);
/* Writes the configurations of both trees. False when out of memory. */
bool km_path_table_write_explored(km_path_steps *steps, const km_path_tree *tree, km_arena *arena, km_table *explored);

#endif
