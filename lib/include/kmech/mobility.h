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

/* Largest size for computations of cubic cost. */
enum {
  KM_MAX_SINGULAR = 300 /* rows and columns of a Jacobian whose singular values are computed */
};

/* ---- Mobility of a configuration (theory 6). */

/* Evidence of a substructure's rank. Pivots are relative to its Jacobian's largest entry. */
typedef struct km_substructure_mobility {
  int joints, loops, coordinates;   /* free coordinates only */
  int rank, mobility;               /* rank of its Jacobian; coordinates − rank */
  double last_pivot, first_dropped; /* smallest kept and largest dropped pivot; dropped 0: none */
  double tolerance;                 /* relative pivot that counts as 0 */
} km_substructure_mobility;

/* Counts of freedoms at a configuration, by formulas and by rank. */
typedef struct km_mobility {
  int kutzbach;          /* 6(n − 1 − j) + Σ f − couplings (theory 6.1) */
  int kutzbach_extended; /* Σ f − Σ λ − couplings */
  int kutzbach_planar; /* 3(n − 1 − j) + Σ f − couplings (Grübler): the count of mechanisms that move in a plane */
  int mobility;        /* Σ (coordinates − rank) + coordinates outside loops and couplings (theory 6.2) */
  int redundant_constraints; /* 6 · loops + couplings − rank */
  double residual;           /* residual of the worst loop, scaled (theory 2.3) */
} km_mobility;

/* Searches new pivots at the state's configuration, which must be closed, and computes all mobility numbers m_j = Σ_k
 * Z_jk², Z the orthonormal basis of D·range(N) (theory 6.3). O(rows · columns · rank) per substructure. KM_USAGE: a
 * pointer is missing, or the state belongs to another mechanism; KM_MEMORY: the mobility is unknown and computed
 * again by the next call. `*out` is then all 0 with a residual of NaN. */
KM_API km_status km_mobility_compute(const km_mechanism *mechanism, km_state *state, km_mobility *out);

/* Returns the number of kinematic substructures. */
KM_API int km_substructure_count(const km_mechanism *mechanism);
/* Returns rank, mobility and pivots of a substructure from the last km_mobility_compute; all 0 if it does not exist. */
KM_API void km_substructure_evidence(const km_mechanism *mechanism, const km_state *state, int substructure,
                                     km_substructure_mobility *out);
/* Returns a coordinate's mobility number after km_mobility_compute: 0 for held ones, 1 outside loops and couplings. */
KM_API double km_mobility_number(const km_state *state, int coordinate);

/* ---- Matrices of a substructure: J, N and Z; and the basis of all free motions. */

/* Returns the rows of a substructure's J: Σ λ of its loops and its couplings; 0 for a substructure that does not
 * exist. Its columns are those of km_substructure_evidence. */
KM_API int km_substructure_rows(const km_mechanism *mechanism, int substructure);
/* Returns the coordinate of a column (free ones only); -1 for a column that does not exist. A ball joint's three
 * columns are the angular velocity along the parent frame's axes. */
KM_API int km_substructure_coordinate(const km_mechanism *mechanism, int substructure, int column);
/* Returns the factor from a column's scaled rate to radians and the model's length unit: 1, or the substructure's
 * size. Z is orthonormal in D (theory 1.4) times this factor. NaN for a column that does not exist. */
KM_API double km_substructure_unit(const km_mechanism *mechanism, int substructure, int column);

/* Matrices are dense and column-major, in the caller's memory, in scaled coordinates (angles in radians, lengths over
 * the substructure's size), at the state's configuration after km_mobility_compute. Errors of each function: KM_USAGE
 * if a pointer is missing or the mobility is unknown; KM_MEMORY. */

/* Computes J[rows × columns]: rates of the closure errors per scaled rate, in the independent rows of each loop's
 * motion space (theory 2.3). O(rows · columns). */
KM_API km_status km_substructure_jacobian(const km_mechanism *mechanism, const km_state *state, int substructure,
                                          double *J, km_error *error);
/* Computes N[columns × mobility], J N = 0: column k moves the k-th independent coordinate by 1 and the other
 * independent ones not at all (theory 3.4). O(columns · mobility · rank). */
KM_API km_status km_substructure_null(const km_mechanism *mechanism, const km_state *state, int substructure, double *N,
                                      km_error *error);
/* Computes Z[columns × mobility], an orthonormal basis of D·range(N); m_j = Σ_k Z_jk² (theory 3.4). O(columns ·
 * mobility). */
KM_API km_status km_substructure_basis(const km_mechanism *mechanism, const km_state *state, int substructure,
                                       double *Z, km_error *error);

/* Computes a basis of all free motions as rates of all coordinates in radians and the model's length unit:
 * N[coordinate count × *freedom], array of coordinate count squared: per substructure D⁻¹ Z, and each free coordinate
 * outside loops and couplings. After km_mobility_compute. KM_USAGE: the mobility is unknown. */
KM_API km_status km_motions_basis(const km_mechanism *mechanism, const km_state *state, double *N, int *freedom,
                                  km_error *error);

/* ---- Passive (idle) degrees of freedom: motions of one body, or a few, with all other bodies at rest, such as the
 * spin of a rod between two ball joints (theory 6.6). They count in the mobility, but no other joint drives or
 * transmits them. */

enum {
  KM_MAX_PASSIVE_BODIES = 4 /* bodies of one group */
};

/* A passive freedom: a group of bodies joined by hinges and slides, all of whose other joints have several
 * coordinates. */
typedef struct km_passive_freedom {
  int substructure; /* substructure of the group */
  int freedoms;     /* freedoms with all other bodies at rest, at the configuration and at a neighbouring one */
  int body_count;
  int bodies[KM_MAX_PASSIVE_BODIES]; /* indices in the model; never 0, the inertial frame */
} km_passive_freedom;

/* All passive freedoms of a configuration. */
typedef struct km_passive_freedoms {
  int count, mobility;       /* number of groups; sum of their freedoms */
  km_passive_freedom *items; /* [count] */
} km_passive_freedoms;

/* Finds the passive freedoms of an assembled configuration, which the state keeps: rank of the group's own joints
 * with all others at rest. O(joints · groups). Free `*out` in any case. KM_CANCELLED, KM_MEMORY. */
KM_API km_status km_passive_freedoms_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                          void *context, km_passive_freedoms *out, km_error *error);
/* Marks the coordinates of the joints in which passive groups move: marks[coordinate count]. These coordinates do not
 * describe the motion of the rest of the mechanism. O(joints · groups). */
KM_API void km_passive_coordinates(const km_mechanism *mechanism, const km_passive_freedoms *freedoms, bool *marks);
KM_API void km_passive_freedoms_free(km_passive_freedoms *freedoms);

/* ---- Finite mobility: which first-order motions are finite motions. */

/* Kinds of first-order motions. */
typedef enum km_motion_kind {
  KM_MOTION_REGULAR,  /* every tangent belongs to one smooth family */
  KM_MOTION_BRANCH,   /* one of several branches that meet at the configuration */
  KM_MOTION_SHAKY,    /* infinitesimally mobile: allowed to first order, or a few more, but no finite motion */
  KM_MOTION_UNDECIDED /* the loops closed over a part of the length only, and the cause decides neither */
} km_motion_kind;

/* A direction of motion, and the length over which it was followed with closed loops. */
typedef struct km_finite_motion {
  km_motion_kind kind;     /* kind of the motion */
  int substructure;        /* substructure that moves */
  double *direction;       /* [coordinate] unit rates: radians, lengths over the characteristic length */
  double confirmed_length; /* arc length over which the loops stayed closed; 0 for shaky motions */
} km_finite_motion;

enum {
  KM_MAX_FINITE_MOTIONS = 64 /* capacity of the list */
};

/* The finite motions of a configuration. */
typedef struct km_finite_mobility {
  int mobility;   /* dimension of the set of closed configurations through it; a lower bound if undecided */
  bool undecided; /* a direction that could raise it was neither confirmed nor refuted */
  int motion_count;
  bool truncated;                                  /* there are, or may be, more motions than listed */
  km_finite_motion motions[KM_MAX_FINITE_MOTIONS]; /* [motion_count] */
  double *store;                                   /* memory of the directions */
} km_finite_mobility;

/* Finds the finite mobility of an assembled configuration (theory 5, 6.4). A substructure without redundant
 * constraints has its instantaneous mobility. Else tangents are tried: all, and if some are refuted those that
 * satisfy the second-order condition wᵀ(J̇ q̇) = 0 for every left null vector w of J. Each is confirmed by following
 * it ahead and back by 0.3 rad (or substructure sizes) of its fastest coordinate. A tangent along which the misfit
 * grows as a power of the length is refuted. If no tangent is confirmed although second order allows some, closed
 * configurations are searched all around (cusps, branches with a common tangent); if none is found, the result is
 * `undecided`, or 0 if the search covers all directions. A substructure with more than 12 freedoms, or more than 240
 * equations and more than one freedom, is sampled by random directions: one if all tangents are finite motions, which
 * it then shows; at a branch point up to 1200 / coordinates, at least two. They yield a lower bound, `undecided`. The
 * state keeps its configuration. Free `*out` in any case. KM_CANCELLED, KM_MEMORY. Some dozens of sparse factorisations
 * per direction. */
KM_API km_status km_finite_mobility_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                         void *context, km_finite_mobility *out, km_error *error);
/* Returns the number of motions that meet at the configuration: the product over the substructures of their branches,
 * a branch of several freedoms counted once; at most 1e6. */
KM_API int km_finite_mobility_branches(const km_finite_mobility *mobility);
KM_API void km_finite_mobility_free(km_finite_mobility *mobility);
/* Returns "regular", "branch", "shaky", "undecided"; "" for another value. */
KM_API const char *km_motion_kind_name(km_motion_kind kind);

/* ---- Redundant constraints (theory 7): their wrenches, and the joint types that remove them. */

/* A change of a joint's type that removes a redundancy without changing the mobility. */
typedef struct km_remedy {
  int joint;       /* index in the model */
  const char *to;  /* "cylindrical", "universal", "spherical" */
  int freedoms;    /* number of freedoms that it adds */
  double strength; /* wᵀh|/(|w| |h|) of the new freedom h and the redundant wrench w: 0 … 1 */
} km_remedy;

enum {
  KM_MAX_REMEDIES = 8 /* capacity of the list */
};

/* One redundant constraint: a wrench that the other constraints of its loops imply. */
typedef struct km_redundancy {
  int substructure, loop; /* substructure; the loop with its largest part */
  bool rotation;          /* a pure moment: a rotation is redundantly constrained; else a force: a translation is */
  double direction[3];    /* unit vector in the inertial frame */
  /* point on the line of the force, inertial frame, model's length unit; unused for a moment */
  double point[3];
  double pitch;      /* moment along the force over the force, model's length unit: 0 for a plain translation */
  int loops;         /* number of loops that the redundancy spans */
  bool out_of_plane; /* out of the plane of one planar loop, which has three of them by nature */
  bool persistent;   /* it is present at a neighbouring configuration too */
  int remedy_count;
  km_remedy remedies[KM_MAX_REMEDIES]; /* remedies, ordered by `freedoms`, then by descending strength */
} km_redundancy;

/* All redundant constraints of a configuration. */
typedef struct km_redundancies {
  int count;
  km_redundancy *items; /* [count] */
} km_redundancies;

/* Finds the redundant constraints of an assembled configuration: left null vectors of the six-row Jacobian, those of
 * single loops first. A remedy's new column must raise the rank. Their number is 6 · loops + couplings − rank, less
 * those in which only couplings take part. Free `*out` in any case. KM_CANCELLED, KM_MEMORY, KM_IO (the sparse QR
 * library is missing). */
KM_API km_status km_redundancies_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                      void *context, km_redundancies *out, km_error *error);
KM_API void km_redundancies_free(km_redundancies *redundancies);

/* ---- Remedies as one set (theory 7.5): changes of joints that together end all redundant constraints. */

enum {
  /* largest product of redundant constraints and joints of a substructure for which a set is searched */
  KM_MAX_SET_SIZE = 1000000
};

/* Another type of one joint. */
typedef struct km_joint_change {
  int joint; /* index in the model */
  /* "cylindrical", "universal", "spherical", "planar"; or a series of slides and a hinge or ball joint: "pin-in-slot",
   * "sphere-cylinder" (a ball in a cylinder), "sphere-plane" (a ball between planes) */
  const char *to;
  int freedoms; /* number of freedoms that it adds */
  int motions;  /* these freedoms as bits: 1 2 4 translations along x y z of the joint's parent frame, 8 16 32 rotations
                 * about them */
} km_joint_change;

/* Changes that end the redundant constraints and keep the mobility. */
typedef struct km_remedy_set {
  int redundant;         /* redundant constraints near the configuration, the incidental ones left out */
  int remaining;         /* redundant constraints after the changes; 0: the set is complete */
  int mobility;          /* mobility near the configuration, before and after the changes */
  bool is_checked;       /* an analysis of the changed model found `remaining` and `mobility` */
  bool is_infinitesimal; /* no set exists: some motions are infinitesimal, so the dimensions must change */
  bool is_too_large;     /* a substructure exceeds KM_MAX_SET_SIZE and was left out */
  int change_count;
  km_joint_change *changes; /* [change_count], by substructure in the order of the joints */
} km_remedy_set;

/* Finds joint types that together end the redundant constraints of an assembled configuration and keep its mobility;
 * chosen at a neighbouring configuration on the motion, checked there by an analysis of the changed model. Few joints
 * are changed. Types of the format precede series of joints; actuators, inputs and drivers of the model are changed
 * only where the others do not suffice, joints of couplings and held joints never. `remaining` above 0: no better set
 * was found. The state keeps its configuration. Free `*out` in any case. KM_CANCELLED, KM_MEMORY, KM_IO (the sparse QR
 * library is missing). O(joints · redundant²) per substructure. */
KM_API km_status km_remedy_set_find(const km_mechanism *mechanism, km_state *state, km_progress progress, void *context,
                                    km_remedy_set *out, km_error *error);
/* Creates the model with the joints of `set` changed, which starts at the state's configuration: bodies without mass,
 * frames, joints, couplings and holds. The caller frees `*out` with km_model_free. KM_USAGE: a change does not fit its
 * joint; KM_MEMORY. */
KM_API km_status km_remedy_set_model(const km_mechanism *mechanism, const km_state *state, const km_remedy_set *set,
                                     km_model **out, km_error *error);
KM_API void km_remedy_set_free(km_remedy_set *set);

/* ---- Diagnosis of a configuration and checks of a model. */

/* Properties of a configuration beyond its mobility numbers. */
typedef struct km_diagnosis {
  km_finite_mobility finite;    /* finite motions */
  km_redundancies redundancies; /* redundant constraints */
  km_passive_freedoms passive;  /* passive freedoms */
  km_remedy_set remedies;       /* changes that end all redundant constraints */
} km_diagnosis;

/* Finds all four at an assembled configuration. Free `*out` in any case. KM_CANCELLED, KM_MEMORY. Cost: the sum of
 * them. */
KM_API km_status km_diagnosis_find(const km_mechanism *mechanism, km_state *state, km_progress progress, void *context,
                                   km_diagnosis *out, km_error *error);
KM_API void km_diagnosis_free(km_diagnosis *diagnosis);

/* Adds notes to `messages` about the geometry of an assembled configuration: ends of a planar loop that are offset
 * along its hinge axes; overconstrained substructures that are rigid as written but within a thousandth of their size
 * of a mobile one. The state keeps its configuration. O(loops), and 20 compilations of the model for each such
 * substructure. */
KM_API void km_geometry_notes(const km_mechanism *mechanism, km_state *state, km_messages *messages);
/* Adds a warning for each substructure whose rank is doubtful: a singular value within a factor of ten of the rank
 * tolerance or, for exact data, between rounding (1e-10) and rounded geometry (1e-5). KM_MEMORY. O(rows · columns²)
 * each. */
KM_API km_status km_rank_doubts(const km_mechanism *mechanism, km_state *state, km_messages *messages, km_error *error);

/* Type of a planar four-bar loop (Grashof 1883). */
typedef enum km_four_bar_kind {
  KM_FOUR_BAR_CRANK_ROCKER,  /* the hinge between ground and shortest link goes round */
  KM_FOUR_BAR_DOUBLE_CRANK,  /* the shortest link is the ground: both its hinges go round */
  KM_FOUR_BAR_DOUBLE_ROCKER, /* the shortest link is the coupler, which alone makes full turns */
  KM_FOUR_BAR_TRIPLE_ROCKER, /* no hinge goes round: the longest link is too long */
  KM_FOUR_BAR_CHANGE_POINT   /* shortest + longest = the others: all links can be in line */
} km_four_bar_kind;
KM_API const char *km_four_bar_name(km_four_bar_kind kind); /* "crank-rocker" …; "": no such kind */

/* A planar loop of four hinges. Link i lies between joints i - 1 and i; link 0 is the ground, or the body nearest to
 * it. */
typedef struct km_four_bar {
  km_four_bar_kind kind; /* type by Grashof's inequality */
  int joints[4];         /* joints in their order round the loop */
  int bodies[4];         /* body of each link */
  double lengths[4];     /* distances between the hinges, the model's length unit */
  int shortest, longest; /* links */
  double excess;         /* shortest + longest − the others: by this much the longest link is too long if positive */
} km_four_bar;
/* Finds the four-bar in a loop, 0 … loops - 1, at the state's configuration (km_poses_compute). False: the loop isn't
 * one: other joints, a held hinge, hinges that aren't parallel. O(depth of the spanning tree). */
KM_API bool km_four_bar_find(const km_mechanism *mechanism, const km_state *state, int loop, km_four_bar *out);

/* Severity of a finding. */
typedef enum km_finding_severity {
  KM_FINDING_FAULT,     /* the mechanism cannot work as described */
  KM_FINDING_WARNING,   /* likely to be a mistake */
  KM_FINDING_HINT,      /* a property that mechanisms of this kind have by nature */
  KM_FINDING_SEVERITIES /* number of severities */
} km_finding_severity;
/* Returns "fault", "warning", and the third level for a hint. */
KM_API const char *km_finding_severity_name(km_finding_severity severity);

/* One finding: a key for programs, a statement, an advice. */
typedef struct km_finding {
  km_finding_severity severity; /* severity */
  const char *kind; /* "redundant", "shaky", "undecided", "branch", "doubtful-rank", "units", "angles", "massless-loop",
                     * "unused-frame", "idle", "limits", "start", "damping", "stop", "friction", "geometry", "reader" */
  const char *statement, *advice; /* the finding; what to do about it */
} km_finding;

/* All findings about a model. */
typedef struct km_findings {
  km_finding *items; /* findings in the order of the checks */
  size_t count;
  size_t counts[KM_FINDING_SEVERITIES]; /* number of findings of each severity */
  struct km_findings_store *store;      /* memory of the texts */
} km_findings;

/* Checks a model at an assembled configuration. `messages` are those of the reader, whose warnings and notes count;
 * NULL: none. Free `*out` in any case. KM_CANCELLED, KM_MEMORY. */
KM_API km_status km_check(const km_mechanism *mechanism, km_state *state, const km_messages *messages,
                          km_progress progress, void *context, km_findings *out, km_error *error);
/* Removes the findings of a kind, for instance "start" if the caller has moved the mechanism from its start. */
KM_API void km_findings_leave_out(km_findings *findings, const char *kind);
KM_API void km_findings_free(km_findings *findings);

#ifdef __cplusplus
}
#endif
#endif
