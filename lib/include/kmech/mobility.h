/* Mobility of a configuration: mobility numbers, null spaces, passive degrees of freedom, finite mobility, redundant
 * constraints, diagnosis. */
#ifndef KMECH_MOBILITY_H
#define KMECH_MOBILITY_H

#include "kmech/base.h"
#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A limit of computations whose cost is cubic. */
enum {
  KM_MAX_SINGULAR = 300 /* coordinates of which singular values are found */
};

/* ---- Mobility of a pose. */

/* Evidence of a substructure's rank. Pivots are relative to its Jacobian's largest entry. */
typedef struct km_substructure_mobility {
  int joints, loops, coordinates;   /* coordinates: free ones */
  int rank, mobility;               /* of its Jacobian; coordinates − rank */
  double last_pivot, first_dropped; /* 0 dropped: nothing was left */
  double tolerance;                 /* relative, below which a pivot counts as 0 */
} km_substructure_mobility;

/* Counts of freedoms at a pose, by formulas and by rank. */
typedef struct km_mobility {
  int kutzbach;          /* 6(n − 1 − j) + Σ f − couplings (270) */
  int kutzbach_extended; /* Σ f − Σ λ − couplings */
  int kutzbach_planar; /* 3(n − 1 − j) + Σ f − couplings (Grübler): the count of mechanisms that move in a plane */
  int mobility;        /* Σ (coordinates − rank) + coordinates outside loops and couplings (271) */
  int redundant_constraints; /* 6 · loops + couplings − rank */
  double residual;           /* of the worst loop, scaled (235) */
} km_mobility;

/* Searches pivots afresh at the state's pose, which must be closed, and computes every mobility number
 * m_j = Σ_k Z_jk² (278)-(279), Z the orthonormal basis of D·range(N). O(rows · columns · rank) a
 * substructure. KM_USAGE: a pointer is missing, or the state is another mechanism's; KM_MEMORY: the mobility isn't known, and all is found
 * anew by the next call. `*out` is then all 0 with a residual of NaN. */
KM_API km_status km_mobility_compute(const km_mechanism *mechanism, km_state *state, km_mobility *out);

/* How many kinematic substructures there are. */
KM_API int km_substructure_count(const km_mechanism *mechanism);
/* Rank, mobility and pivots of one, as the last km_mobility_compute found them. All 0 if there is no such substructure. */
KM_API void km_substructure_evidence(const km_mechanism *mechanism, const km_state *state, int substructure,
                                     km_substructure_mobility *out);
/* After km_mobility_compute: number of a coordinate; 0 for held ones, 1 outside loops and couplings. */
KM_API double km_mobility_number(const km_state *state, int coordinate);

/* ---- The matrices behind the mobility: J, N and Z of substructures, and all free motions together. */

/* Rows of a substructure's J: Σ λ of its loops and its couplings. Its columns are those of km_substructure_evidence. 0
 * for a substructure that doesn't exist. */
KM_API int km_substructure_rows(const km_mechanism *mechanism, int substructure);
/* The coordinate of a column, free ones only; -1 for a column that doesn't exist. A ball's three columns are the
 * angular velocity along the parent frame's axes. */
KM_API int km_substructure_coordinate(const km_mechanism *mechanism, int substructure, int column);
/* What a scaled rate of the column is multiplied by for radians and the model's length unit: 1, or the substructure's
 * size. D of theory 4 times this is what Z is orthonormal in. NaN for a column that doesn't exist. */
KM_API double km_substructure_unit(const km_mechanism *mechanism, int substructure, int column);

/* All matrices are dense, column-major, into the caller's memory, in scaled coordinates (angles as they are, lengths
 * over the substructure's size), at the state's pose after km_mobility_compute. Each: KM_USAGE where something is
 * missing or the mobility isn't known; KM_MEMORY. */

/* J[rows × columns]: the rates of the loops' errors per scaled rate, each loop's independent rows in its own motion
 * space (231). O(rows · columns). */
KM_API km_status km_substructure_jacobian(const km_mechanism *mechanism, const km_state *state, int substructure,
                                          double *J, km_error *error);
/* N[columns × mobility] with J N = 0: column k moves the k-th independent coordinate by 1, the other independent ones
 * not at all (275). Room for columns × mobility of km_substructure_evidence. O(columns · mobility · rank). */
KM_API km_status km_substructure_null(const km_mechanism *mechanism, const km_state *state, int substructure, double *N,
                                      km_error *error);
/* Z[columns × mobility], an orthonormal basis of D·range(N); m_j = Σ_k Z_jk² (278)-(279). O(columns · mobility). */
KM_API km_status km_substructure_basis(const km_mechanism *mechanism, const km_state *state, int substructure,
                                       double *Z, km_error *error);

/* Every free motion of the whole mechanism as rates of all coordinates, in radians and the model's length unit:
 * N[coordinate count × *freedom], room for coordinate count squared: per substructure D⁻¹ Z, and each coordinate
 * outside loops and couplings by itself. After km_mobility_compute. KM_USAGE: the mobility isn't known. */
KM_API km_status km_motions_basis(const km_mechanism *mechanism, const km_state *state, double *N, int *freedom,
                                  km_error *error);

/* ---- Idle freedoms: one body, or a few, can move in place while everything else stands, as the spin of a rod between two
 * ball joints. They count in the mobility, but no other joint drives or feels them. */

enum {
  KM_MAX_PASSIVE_BODIES = 4 /* of one group */
};

/* A group of bodies that hinges and slides tie together, all of whose other joints have several coordinates. */
typedef struct km_passive_freedom {
  int substructure; /* that the group lies in */
  int freedoms;     /* of the group while all other bodies stand, at the pose and a short way along the motion */
  int body_count;
  int bodies[KM_MAX_PASSIVE_BODIES]; /* of the model; 0 is the inertial frame and never in a group */
} km_passive_freedom;

/* All such groups. */
typedef struct km_passive_freedoms {
  int count, mobility;       /* groups; the sum of their freedoms */
  km_passive_freedom *items; /* [count] */
} km_passive_freedoms;

/* At an assembled pose; the state is left at it. By test: rank of the group's own joints with its neighbours fixed.
 * Cost: linear in joints. Free `*out` in any case. */
KM_API km_status km_passive_freedoms_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                          void *context, km_passive_freedoms *out, km_error *error);
/* Which coordinates belong to the joints that idle bodies turn in: marks[coordinate count]. They say nothing of the rest of
 * the mechanism. O(joints · groups). */
KM_API void km_passive_coordinates(const km_mechanism *mechanism, const km_passive_freedoms *freedoms, bool *marks);
KM_API void km_passive_freedoms_free(km_passive_freedoms *freedoms);

/* ---- Which of the motions that first order allows are real. */

/* How real a motion is that first order allows. */
typedef enum km_motion_kind {
  KM_MOTION_REGULAR,  /* every direction of the null space is one of a smooth family */
  KM_MOTION_BRANCH,   /* one of several motions that meet at the pose */
  KM_MOTION_SHAKY,    /* allowed to first order, or a few more: the structure shakes, but doesn't move */
  KM_MOTION_UNDECIDED /* the loops were closed for a part of the way, and what stopped them tells neither */
} km_motion_kind;

/* One direction of motion, and how far it was followed with the loops closed. */
typedef struct km_finite_motion {
  km_motion_kind kind;     /* how real it is */
  int substructure;        /* that moves */
  double *direction;       /* [coordinate] unit rates: radians, lengths over the characteristic length */
  double confirmed_length; /* of arc: how far the loops stayed closed; 0 for shaky ones */
} km_finite_motion;

enum {
  KM_MAX_FINITE_MOTIONS = 64 /* how many are listed */
};

/* The real motions at a pose. */
typedef struct km_finite_mobility {
  int mobility;   /* dimension of the set of real motions through the pose; the least it can be where undecided */
  bool undecided; /* some direction was neither confirmed nor refuted */
  int motion_count;
  bool truncated;                                  /* there are more motions than are listed, or may be */
  km_finite_motion motions[KM_MAX_FINITE_MOTIONS]; /* [motion_count] */
  double *store;                                   /* of the directions */
} km_finite_mobility;

/* The finite mobility at an assembled configuration (theory 5). A substructure without redundant constraints has its
 * instantaneous mobility. Else the tangents are tried: all of them, and where that fails those that satisfy the
 * second-order condition wᵀ(J̇ q̇) = 0 for every left null vector w of J; each is confirmed by following it by 0.3 rad
 * (or substructure sizes) of its fastest coordinate, ahead and back. Where the loops open as a power of the way that
 * tangent is refuted. Where none of several tangents is left although the second order allows some, closed
 * configurations are looked for all around (cusps, branches with one tangent); if there are none, the answer is
 * `undecided`, never 0. Of a substructure with more than 12 freedoms, or more than 240 equations and more than one
 * freedom, random directions are tried: two where all tangents are finite motions, which then shows by one that is
 * followed, and at a branch point up to 1200 / coordinates of them, at least two; of those only a bound of the mobility
 * comes, `undecided`. The state keeps its configuration. Free `*out` in any case. KM_MEMORY. O(a few dozen sparse
 * factorisations) for each direction. */
KM_API km_status km_finite_mobility_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                         void *context, km_finite_mobility *out, km_error *error);
/* How many motions meet at the configuration: the product over the substructures of their branches, each branch of
 * several freedoms counted once; at most 1e6. */
KM_API int km_finite_mobility_branches(const km_finite_mobility *mobility);
KM_API void km_finite_mobility_free(km_finite_mobility *mobility);
/* "regular", "branch", "shaky", "open"; "". */
KM_API const char *km_motion_kind_name(km_motion_kind kind);

/* ---- Redundant constraints, named: what is constrained twice, and which freedom would end it. */

/* A joint that would remove a redundancy with another type, the mobility staying the same. */
typedef struct km_remedy {
  int joint;       /* of the model */
  const char *to;  /* "cylindrical", "universal", "spherical" */
  int freedoms;    /* that the swap adds */
  double strength; /* how squarely the new freedom meets the redundant constraint: 0 … 1 */
} km_remedy;

enum {
  KM_MAX_REMEDIES = 8 /* how many are listed */
};

/* One redundant constraint of a loop: a wrench that the loop's other constraints carry already. */
typedef struct km_redundancy {
  int substructure, loop; /* where it is; the loop it is told of */
  bool rotation;          /* a pure couple: a rotation is constrained twice; else a force: a translation is */
  double direction[3];    /* unit vector in the inertial frame */
  double point[3];        /* on the line of the force, inertial frame, model's length unit; of a couple: unused */
  double pitch;           /* couple along the force over the force, model's length unit: 0 for a plain translation */
  int loops;              /* how many loops the redundancy spans */
  bool out_of_plane;      /* of one planar loop, across its plane: such a loop has three of them by nature */
  bool lasting;           /* also a short way along the motion, not only at this pose */
  int remedy_count;
  km_remedy remedies[KM_MAX_REMEDIES]; /* what would end it: by `freedoms`, then the strongest first */
} km_redundancy;

/* All of a pose. */
typedef struct km_redundancies {
  int count;
  km_redundancy *items; /* [count] */
} km_redundancies;

/* The redundant constraints of an assembled pose: left null vectors of the six-row Jacobian, those of single loops
 * first. Remedies are found by test: the new freedom's column must raise the rank. Their number is
 * 6 · loops + couplings − rank, less those that only couplings have part in. Free `*out` in any case. */
KM_API km_status km_redundancies_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                      void *context, km_redundancies *out, km_error *error);
KM_API void km_redundancies_free(km_redundancies *redundancies);

/* ---- What a pose has beyond its numbers, and everything about a model that is suspicious. */

/* The three answers about one pose. */
typedef struct km_diagnosis {
  km_finite_mobility finite;    /* which motions are real */
  km_redundancies redundancies; /* what is constrained twice */
  km_passive_freedoms idle;     /* what moves by itself */
} km_diagnosis;

/* All three at an assembled pose. Free `*out` in any case. KM_CANCELLED, KM_MEMORY. Cost: the sum of them. */
KM_API km_status km_diagnosis_find(const km_mechanism *mechanism, km_state *state, km_progress progress, void *context,
                                   km_diagnosis *out, km_error *error);
KM_API void km_diagnosis_free(km_diagnosis *diagnosis);

/* Adds notes to `messages` about the geometry of an assembled configuration: the ends of a planar loop that are offset
 * along its hinge axes, and overconstrained substructures that are rigid as written, but within a thousandth of their
 * size of one that moves. The state keeps its configuration. O(loops), and for each such substructure 20 compilations
 * of the model. */
KM_API void km_geometry_notes(const km_mechanism *mechanism, km_state *state, km_messages *messages);
/* Adds a warning for each substructure whose rank is doubtful: a singular value within a factor of ten of the rank
 * tolerance or, of exact data, between what rounding leaves and what geometry makes. KM_MEMORY. O(rows · columns²)
 * each. */
KM_API km_status km_rank_doubts(const km_mechanism *mechanism, km_state *state, km_messages *messages, km_error *error);

/* How much a finding matters: a fault keeps the mechanism from working as it is described, a warning is likely to be a
 * mistake, a remark tells what a mechanism of its kind has by nature. */
typedef enum km_finding_severity {
  KM_FINDING_FAULT,     /* it can't work as it is described */
  KM_FINDING_WARNING,   /* likely to be a mistake */
  KM_FINDING_HINT,      /* so by nature */
  KM_FINDING_SEVERITIES /* how many there are */
} km_finding_severity;
KM_API const char *km_finding_severity_name(km_finding_severity severity); /* "fault", "warning", "remark" */

/* One finding: a word for programs, what was found, what to do. */
typedef struct km_finding {
  km_finding_severity severity; /* how much it matters */
  const char *kind; /* "redundant", "shaky", "undecided", "branch", "doubtful-rank", "units", "angles", "massless-loop",
                     * "unused-frame", "idle", "limits", "start", "damping", "stop", "friction", "geometry", "reader" */
  const char *statement, *advice; /* what was found; what to do */
} km_finding;

/* All findings about a model. */
typedef struct km_findings {
  km_finding *items; /* in the order in which they were found */
  size_t count;
  size_t counts[KM_FINDING_SEVERITIES]; /* of each severity */
  struct km_findings_store *store;      /* of the texts */
} km_findings;

/* Examines an assembled pose. `messages` are the reader's, whose warnings and notes count; NULL: none. Free `*out` in
 * any case. KM_CANCELLED, KM_MEMORY. */
KM_API km_status km_check(const km_mechanism *mechanism, km_state *state, const km_messages *messages,
                          km_progress progress, void *context, km_findings *out, km_error *error);
/* Leaves out those of a kind: who has moved the mechanism himself, for instance, isn't told that it starts elsewhere
 * ("start"). */
KM_API void km_findings_leave_out(km_findings *findings, const char *kind);
KM_API void km_findings_free(km_findings *findings);

#ifdef __cplusplus
}
#endif
#endif
