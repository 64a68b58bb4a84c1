/* Notes about geometry by kind (km_geometry_notes has all). */
#ifndef KM_MOBILITY_GEOMETRY_NOTES_H
#define KM_MOBILITY_GEOMETRY_NOTES_H

#include "kmech/mobility.h"

/* Loops whose ends are offset along their hinge axes. */
void km_pin_offset_notes(const km_mechanism *mechanism, km_messages *messages);
/* Substructures that are rigid as written, and within a thousandth of their size of ones that move. */
void km_nearly_movable_notes(const km_mechanism *mechanism, km_state *state, km_messages *messages);

#endif
