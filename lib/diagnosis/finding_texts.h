/* Texts of findings about a configuration. */
#ifndef KM_DIAGNOSIS_FINDING_TEXTS_H
#define KM_DIAGNOSIS_FINDING_TEXTS_H

#include "base/text.h"
#include "kmech/mobility.h"

/* Describes a passive freedom by the bodies that move. */
void km_passive_freedom_statement(const km_mechanism *mechanism, const km_passive_freedom *passive, km_text *out);
/* Returns the number of redundancies out of the plane of planar loops in one substructure or (-1) in all. */
int km_redundancies_out_of_plane(const km_redundancies *redundancies, int substructure);
/* Describes a redundancy: loop, kind of motion, position. */
void km_redundancy_statement(const km_mechanism *mechanism, const km_redundancy *redundancy, km_text *out);

#endif
