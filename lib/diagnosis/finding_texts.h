/* Findings about a pose in words. */
#ifndef KM_DIAGNOSIS_FINDING_TEXTS_H
#define KM_DIAGNOSIS_FINDING_TEXTS_H

#include "base/text.h"
#include "kmech/mobility.h"

/* One idle freedom: which bodies move in place, between which joints. */
void km_passive_freedom_statement(const km_mechanism *mechanism, const km_passive_freedom *idle, km_text *out);
/* How many are out of the plane of planar loops, of one substructure or (-1) of all. */
int km_redundancies_out_of_plane(const km_redundancies *redundancies, int substructure);
/* One redundancy: which loop, what is constrained twice, where. */
void km_redundancy_statement(const km_mechanism *mechanism, const km_redundancy *redundancy, km_text *out);

#endif
