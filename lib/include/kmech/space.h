/* Configuration spaces: all assembly modes with a proof, their circuits, maps over two drivers, turning curves,
 * singularity-free paths. */
#ifndef KMECH_SPACE_H
#define KMECH_SPACE_H

#include "kmech/base.h"
#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- All assembly modes: the configurations that close the loops with some coordinates locked (docs/theory.md 4.15 to
 * 4.17). */

/* Reason why a list of modes is not shown to be complete. */
typedef enum km_mode_gap {
  KM_GAP_NONE,     /* complete: the trace test passed, and every solution was followed to the closed loops */
  KM_GAP_TRACE,    /* the trace test did not pass: at least these modes */
  KM_GAP_LOST,     /* solutions were lost on the way to the closed loops */
  KM_GAP_SINGULAR, /* singular solutions: several may coincide, or the solutions there are curves */
  KM_GAP_MOVES,    /* a mode moves, although all locked joints stay: the modes there are samples of a self-motion */
  KM_GAP_LIMIT,    /* the search ended at its limit of solutions or of work */
  KM_GAP_STOPPED,  /* `progress` ended the search: the modes are those of the solutions found until then */
  KM_GAP_REFUSED   /* km_all_modes_find refuses the mechanism: the state's own mode alone */
} km_mode_gap;
/* Returns "complete", "trace", "lost", "singular", "self-motion", "limit", "stopped", "refused"; "" for another value. */
KM_API const char *km_mode_gap_name(km_mode_gap gap);

/* Evidence of one assembly mode. */
typedef struct km_mode_evidence {
  bool is_certified;     /* the proof holds: exactly one solution lies within error_bound, and no other within radius */
  double kantorovich;    /* h of the proof, at most 1/2 if it holds; NaN at a singular configuration */
  double error_bound;    /* distance to the exact solution: radians, lengths over the substructure's size */
  double radius;         /* distance within which there is no other solution, in the same units */
  double residual;       /* √(eᵀe/6) of the worst loop, scaled */
  int mobility;          /* instantaneous mobility with all coordinates free */
  bool is_singular;      /* bodies can move to first order although the locked coordinates stay */
  bool moves;            /* they can move: a self-motion, of which this is a sample */
  bool is_within_limits; /* all coordinates are within their limits */
} km_mode_evidence;

/* All assembly modes. */
typedef struct km_all_modes {
  int count;                  /* number of modes; the first is that of the state */
  double *coordinates;        /* [count × coordinate count] in the model's units */
  double *mobility_numbers;   /* [count × coordinate count] with all coordinates free */
  km_mode_evidence *evidence; /* [count] */
  int substructure;           /* index of the substructure whose modes these are */
  bool is_complete;           /* there are no other modes */
  km_mode_gap gap;            /* reason for the verdict */
  int complex_solutions;      /* complex solutions over a generic closure error */
  int section_points;         /* points of the section in the trace test */
  double trace_difference;    /* relative second difference of the trace test; rounding if it passed; NaN: not made */
  int estimate;               /* estimated number of complex solutions of an incomplete search */
  int samples, found_once;    /* its independent finds, and the solutions found by one of them */
  int infinite, singular;     /* solutions that go to infinity, or to a singular solution, as the loops close */
  int outside;                /* modes outside the joint limits: in the list, or left out */
} km_all_modes;

enum {
  KM_DEFAULT_MODE_SOLUTIONS = 20000 /* complex solutions that are followed, unless stated */
};

/* Options of the search. */
typedef struct km_all_modes_def {
  const int *locked; /* [locked_count] coordinates that keep their values; NULL: none */
  int locked_count;
  bool within_limits; /* modes outside the joint limits are left out, but that of the state */
  int max_solutions;  /* complex solutions that are followed; 0: KM_DEFAULT_MODE_SOLUTIONS */
  unsigned long seed; /* start of the random numbers; the modes don't depend on it */
} km_all_modes_def;

/* Finds all assembly modes of one substructure: that of the locked coordinates, else the largest one. Its closure
 * errors are followed over the complex numbers by monodromy; the trace test shows completeness; real solutions of the
 * closed loops are the modes, and Newton-Kantorovich proves each. Two configurations are one mode if all bodies have
 * the same poses to 1e-6, as in km_modes_find. Modes are ordered by their coordinates behind the first one, that of
 * the state; where the loops don't close from the state, the first one is that of a random start. The state keeps its
 * configuration. KM_USAGE: an index is invalid, locked coordinates lie in different
 * substructures, there is no loop, bodies can move although the locked coordinates stay (the message says in how many
 * ways), or a joint is a screw or coupled; KM_NO_RESULT: no start closes; KM_MEMORY; KM_CANCELLED: `*out` has the modes
 * of the solutions found until then. Free `*out` in any case. O(complex solutions · 10³ · rank³). */
KM_API km_status km_all_modes_find(const km_mechanism *mechanism, const km_state *state, const km_all_modes_def *def,
                                   km_progress progress, void *context, km_all_modes *out, km_error *error);
KM_API void km_all_modes_free(km_all_modes *modes);

/* ---- Circuits: the modes that one motion connects (docs/theory.md 4.18). */

/* Reason why circuits are not known, or perhaps too many. */
typedef enum km_circuit_gap {
  KM_CIRCUIT_GAP_NONE,        /* every curve was followed to its end */
  KM_CIRCUIT_GAP_FREEDOMS,    /* not answered: with the locked coordinates free, bodies move in several ways */
  KM_CIRCUIT_GAP_SELF_MOTION, /* not answered: modes are samples of self-motions */
  KM_CIRCUIT_GAP_BALL,        /* not answered: nothing but ball joints is locked */
  KM_CIRCUIT_GAP_LOST,        /* a curve was not followed to its end: circuits may be connected there */
  KM_CIRCUIT_GAP_STOPPED      /* not answered: `progress` ended the search */
} km_circuit_gap;
/* Returns "none", "freedoms", "self-motion", "ball", "lost", "stopped"; "" for another value. */
KM_API const char *km_circuit_gap_name(km_circuit_gap gap);

/* Circuits of a list of modes. */
typedef struct km_mode_circuits {
  int count;          /* number of circuits; 0: not answered */
  int *circuit;       /* [number of modes] circuit of each mode, from 1 in the order of the modes; 0: not answered */
  int freedom;        /* freedoms of the bodies with the locked coordinates free; 0: each mode is a circuit */
  km_circuit_gap gap; /* reason for the verdict */
} km_mode_circuits;

/* Finds the circuits of the modes that km_all_modes_find found with the same mechanism, state and definition. The
 * locked coordinates are free and limits are ignored. The curve through each mode is followed by arc length; a mode is
 * on it if all bodies have the same poses to 1e-6 where the first locked coordinate has its value again. A curve ends
 * where it closes, or where a slide is farther than 100 sizes; all branches of a branch point belong to one circuit.
 * KM_USAGE, KM_MEMORY, KM_CANCELLED. Free `*out` in any case. O(length of the curves · 20 · rank³). */
KM_API km_status km_mode_circuits_find(const km_mechanism *mechanism, const km_state *state,
                                       const km_all_modes_def *def, const km_all_modes *modes, km_progress progress,
                                       void *context, km_mode_circuits *out, km_error *error);
KM_API void km_mode_circuits_free(km_mode_circuits *circuits);

/* Finds all modes and then their circuits, with one course of progress. Errors as km_all_modes_find and
 * km_mode_circuits_find; KM_CANCELLED: `*modes` has those found until then, `*circuits` that it was stopped. Free both
 * in any case. Cost: the sum of both. */
KM_API km_status km_modes_and_circuits_find(const km_mechanism *mechanism, const km_state *state,
                                            const km_all_modes_def *def, km_progress progress, void *context,
                                            km_all_modes *modes, km_mode_circuits *circuits, km_error *error);

/* ---- Maps over two drivers: sheets of configurations, and singularity curves (docs/theory.md 4.19). */

enum {
  KM_MAX_MAP_STEPS = 2000 /* most intervals of a map's axis */
};

/* Kind of a curve on the surface of configurations. */
typedef enum km_curve_kind {
  KM_CURVE_INPUT,    /* singularity: the drivers don't determine the motion, bodies move although both stay */
  KM_CURVE_OUTPUT,   /* singularity: the point can't move in some direction of its plane */
  KM_CURVE_LIMIT,    /* a driver is at an end of its range, or a joint at a limit */
  KM_CURVE_CLEARANCE /* two bodies have the least clearance */
} km_curve_kind;
/* Returns "input", "output", "limit", "clearance"; "" for another value. */
KM_API const char *km_curve_kind_name(km_curve_kind kind);

/* One axis of a map: a driver and the grid of its values. */
typedef struct km_space_axis {
  int coordinate;  /* the driver: a free hinge or slide */
  double from, to; /* model's unit */
  int steps;       /* intervals, 1 to KM_MAX_MAP_STEPS */
} km_space_axis;

/* Figures that a caller adds to each cell of a map. */
typedef struct km_map_figures {
  int count;                /* number of figures */
  const char *const *names; /* [count] names of their columns */
  const char *const *units; /* [count] units; "": none */
  /* Computes values[count] at the state's configuration, whose mobility is known (km_mobility_compute). False ends the
   * map with KM_CANCELLED. */
  bool (*compute)(void *context, const km_mechanism *mechanism, km_state *state, double *values);
  void *context; /* passed to `compute` */
} km_map_figures;

/* Figures that can be added to each cell of a map. */
typedef enum km_map_quantity {
  KM_MAP_QUANTITY_MOBILITY,  /* nothing beside the mobility numbers, which every cell has */
  KM_MAP_QUANTITY_ADVANTAGE, /* column ma.INPUT/OUTPUT: km_transfer_compute */
  KM_MAP_QUANTITY_FORCES,    /* columns f.JOINT: km_statics_compute */
  KM_MAP_QUANTITY_CLEARANCE  /* column clearance: km_clearance_compute */
} km_map_quantity;
/* Words of km_map_quantity, in its order. */
#define KM_MAP_QUANTITY_WORDS "mobility or advantage or forces or clearance"

/* Creates the figures of `quantity`; `*out` is NULL for KM_MAP_QUANTITY_MOBILITY. Input and output of the advantage are
 * those of the model's analysis. The actuators are the model's, else drivers[2]. Pairs of bodies are chosen at the
 * configuration of `state`, whose poses are computed. The mechanism must outlive the figures, which the caller frees.
 * KM_USAGE: a driver is invalid, the model has no input or output, or no pair of bodies has shapes; KM_MODEL, KM_IO:
 * shapes, loads; KM_MEMORY. */
KM_API km_status km_map_figures_create(const km_mechanism *mechanism, km_state *state, km_map_quantity quantity,
                                       const int *drivers, km_map_figures **out, km_error *error);
KM_API void km_map_figures_free(km_map_figures *figures);

/* A store of a map that is being followed. */
typedef struct km_map_store km_map_store;

/* Definition of a map. */
typedef struct km_space_map_def {
  km_space_axis axis[2];  /* the drivers, of one part of the mechanism or of two */
  bool has_point;         /* the map adds the place of a point that moves on a plane or a sphere */
  int frame;              /* its frame */
  const char *point_name; /* its name in columns: "body/frame" */
  bool own_sheet;     /* only sheets of the given modes; else also those that their curves and random starts lead to */
  bool within_limits; /* cells outside the joint limits are left out; they are followed all the same */
  const km_map_figures *figures; /* further columns; NULL: none */
  const km_clearance *clearance; /* cells in which a pair of bodies is nearer than `least_clearance` are left out, and
                                  * curves bound them; NULL: none */
  double least_clearance;        /* model's unit */
  km_map_store *store;           /* keeps what is found, km_map_store_open; NULL: none */
} km_space_map_def;

/* The plane or sphere on which a map's point moves. Its chart, of equal areas: x_i = a_i·p of a plane; of a sphere
 * x_i = R √(2 / (1 + a_3·n)) a_i·n, n = (p − origin) / R (J. H. Lambert 1772). */
typedef struct km_point_surface {
  double axis[3][3]; /* a_1, a_2, a_3: unit vectors, right-handed, world frame. Plane: the last one is its normal */
  double origin[3];  /* the sphere's centre, or the plane's point nearest to the world's origin; model's unit */
  double radius;     /* R; 0: a plane */
} km_point_surface;

/* The places that the point reaches in an aspect, without a singularity. */
typedef struct km_aspect_workspace {
  int aspect;           /* its number in the cells */
  double area;          /* area of these places; NaN: a curve that bounds them wasn't found */
  double circle[3];     /* centre of the largest circle in them, model's unit, world frame */
  double radius;        /* its radius, to 1e-5 of the extent; 0: none, the outline has a gap, or a sphere, see `cone` */
  double rectangle[3];  /* centre of the largest rectangle in them, sides along the plane's axes */
  double width, height; /* its sides: in the plane z = const along x and y; 0: none */
  double cone[3];       /* unit vector, world frame: axis of the largest cone in them from a sphere's centre */
  double half_angle;    /* angle between the cone and its axis, to 1e-5, in radians; 0: none, the outline has a gap, or
                         * a plane */
} km_aspect_workspace;

/* A map. */
typedef struct km_space_map {
  km_table *cells;  /* q. of both drivers, sheet (number, modes first), aspect, q. of the other coordinates, m. of
                     * every coordinate, sigma.input, sigma.closure, with a point its x y z, sigma.output and
                     * manipulability, on a sphere chart. x and y, then the figures: a row for each grid point that a
                     * sheet reaches */
  km_table *curves; /* curve (number), kind (km_curve_kind), q. of every coordinate, with a point its x y z, on a sphere
                     * chart. x and y: points of singularity curves, ends of ranges and limits from end to end, or
                     * around a closed curve to its first point */
  int sheet_count;  /* sheets with grid points: of modes, and of motions that only curves or random starts lead to */
  int aspect_count; /* parts of the sheets within which the drivers lead from each grid point to each other one without
                     * a singularity of drivers or point */
  int curve_count;  /* number of curves */
  km_table *boundary; /* loop (number), kind (km_curve_kind), curve, x y z of the point, on a sphere chart. x and y: the
                       * outline of the workspace loop by loop, the workspace on the left, seen against the normal;
                       * NULL: no point */
  km_point_surface surface; /* the point's plane or sphere */
  int hole_count;        /* loops around places that can't be reached; where the end of a sphere's chart is reached, all
                          * loops but one */
  double workspace_area; /* area of the places that the point reaches; NaN: an outline doesn't close */
  double
      gap; /* longest gap of the outline, where a curve is missing and a straight line closes it; 0: none; infinite: a
               * loop doesn't close */
  int unbounded;                   /* grid points whose place lies outside the outline: 0 unless a curve is missing */
  int checked;                     /* grid points of which that was checked, at most 2 000 */
  km_aspect_workspace *workspaces; /* [workspace_count] by aspect */
  int workspace_count;             /* aspects; 0: no point */
  bool is_stopped; /* `progress` ended the search: there are the finished sheets and the curves found until then */
} km_space_map;

/* Finds the modes from which a map begins: those of the parts that its drivers `first` and `second` move, with the
 * drivers locked, in all combinations. A driver of no loop has one. `seed`: as in km_all_modes_def. `*out` has no
 * evidence and no mobility numbers where the drivers move different parts. Errors as km_all_modes_find. Free `*out` in
 * any case. */
KM_API km_status km_map_modes_find(const km_mechanism *mechanism, const km_state *state, int first, int second,
                                   unsigned long seed, km_progress progress, void *context, km_all_modes *out,
                                   km_error *error);

/* Opens or creates the file that keeps what a map has found: modes, grid points with their figures, and curves. The map
 * that is computed with it, in `def->store`, takes from it what is there, and computes and keeps the rest; tables and
 * numbers have the same bits as those of a map without a store. Results are kept each tenth of a second, whatever
 * ends the process. The file belongs to one version of the library, one model with its meshes, one pose, definition and
 * `seed` (km_space_map_find). Figures are known by their names and units, not by what their function computes.
 * `replace`: results of another map are deleted. Mechanism and definition must outlive the store, which the caller
 * frees; one map at a time uses it, once. KM_USAGE: invalid definition, or the store of another map; KM_IO: the file
 * can't be read or written, is damaged, or is in use by another run; KM_MEMORY. O(bytes of the file). */
KM_API km_status km_map_store_open(const char *path, const km_mechanism *mechanism, const km_state *state,
                                   const km_space_map_def *def, unsigned long seed, bool replace, km_map_store **out,
                                   km_error *error);
/* Commits and closes the file. */
KM_API void km_map_store_free(km_map_store *store);

/* Follows the configurations over a grid of two drivers, from each mode (km_map_modes_find) and from grid point to grid
 * point. A sheet ends at singular configurations of the drivers, where det A = 0, A the Jacobian's
 * columns of the other coordinates. sigma.input and sigma.closure are the smallest singular values of A and of J,
 * sigma.output and manipulability the smallest singular value and the product of both of the point's Jacobian D by the
 * drivers; lengths over the substructure's size. The curves det A = 0 that bound the sheets, and det D = 0 on them, are
 * followed by continuation, each point to 1e-11; with a point also the ends of ranges, and its workspace is found. The
 * first mode is closed. Rods between two ball joints don't spin.
 * KM_USAGE: an axis is invalid or a ball joint's, the parts have not two freedoms beside such spins, or a point that
 * moves on no plane and no sphere, or the store's map began from other modes; KM_MEMORY; KM_CANCELLED; KM_IO: the
 * store. Free `*out` in any case. O(cells · rank³). */
KM_API km_status km_space_map_compute(const km_mechanism *mechanism, const km_state *state, const km_space_map_def *def,
                                      const km_all_modes *modes, km_progress progress, void *context, km_space_map *out,
                                      km_error *error);
KM_API void km_space_map_free(km_space_map *map);

/* Finds the modes and then the map from them, with one course of progress. `seed`: as in km_all_modes_def, and that of
 * `def->store`, which keeps the modes too. With
 * own_sheet the first mode alone, that of the state, which is complete. Errors as km_map_modes_find and
 * km_space_map_compute. Free `*modes` and `*out` in any case. Cost: the sum of both. */
KM_API km_status km_space_map_find(const km_mechanism *mechanism, const km_state *state, const km_space_map_def *def,
                                   unsigned long seed, km_progress progress, void *context, km_all_modes *modes,
                                   km_space_map *out, km_error *error);

/* ---- Turning: dead points of a driver over one number of the design (docs/theory.md 4.20). */

/* Kind of a critical value of the number: an extremum of the number on a curve of dead points. */
typedef enum km_turning_kind {
  KM_TURNING_NONE,     /* a point of the curve, no critical value */
  KM_TURNING_CROSSING, /* two motions cross: circuits join or part there */
  KM_TURNING_ISOLATED, /* an isolated configuration: a circuit appears or vanishes there */
  KM_TURNING_CUSP      /* two dead points meet; the circuits stay */
} km_turning_kind;
/* Returns "none", "crossing", "isolated", "cusp"; "" for another value. */
KM_API const char *km_turning_kind_name(km_turning_kind kind);

/* A critical value. Curves of several modes with equal number, driver and kind share one. */
typedef struct km_turning_point {
  double number;        /* value of the number, in the file's unit */
  double driver;        /* value of the driver, in the model's unit; a hinge's within half a turn of 0 */
  km_turning_kind kind; /* never KM_TURNING_NONE */
  int curve;            /* number of its curve, from 1; of several modes': the first */
} km_turning_point;

/* Motion of the driver between two neighbouring critical values, found in the middle. */
typedef struct km_turning_interval {
  double from, to;   /* range of the number */
  bool is_defined;   /* the model's file can be read with the number */
  bool is_assembled; /* the model's circuit is there */
  bool turns;        /* the driver goes fully round on it */
  double low, high;  /* else its swing: the driver's unit; -infinity, infinity: without end; NaN: not found */
  int dead_points;   /* dead points of all circuits */
} km_turning_interval;

/* Definition of a turning search. */
typedef struct km_turning_def {
  int driver;         /* coordinate: a hinge or slide of a loop */
  const char *file;   /* the model's file */
  const char *path;   /* a number of it, as in km_model_read_varied */
  double from, to;    /* range of the number, from < to */
  int steps;          /* circuits are followed at steps + 1 values of the number; 0: KM_DEFAULT_TURNING_STEPS */
  unsigned long seed; /* start of the random numbers; the result doesn't depend on it */
} km_turning_def;

enum {
  KM_DEFAULT_TURNING_STEPS = 20, /* steps, unless stated */
  KM_MAX_TURNING_STEPS = 1000    /* most steps */
};

/* Dead points over a number of the design. */
typedef struct km_turning {
  km_table *curves; /* curve (number), number, critical (km_turning_kind), q. of every coordinate: points of the curves
                      * of dead points from end to end, or around a closed curve to its first point */
  int curve_count;  /* number of curves */
  int point_count;  /* number of critical values */
  int interval_count;             /* number of intervals */
  km_turning_point *points;       /* [point_count] by their number */
  km_turning_interval *intervals; /* [interval_count] from `from` to `to` */
  int modes;                      /* assembly modes from which circuits were followed */
  bool is_complete;               /* these are all modes of the model at its own number */
  km_mode_gap gap;                /* reason why they may not be all */
  bool is_stopped; /* `progress` ended the search: curves and critical values are those found until then, and there are
                    * no intervals */
} km_turning;

/* Follows the dead points of a driver, det A = 0, over the configurations and one number of the design: curves of
 * (q, p) with e(q, p) = 0, A: the Jacobian's columns of the other coordinates. Starts are the dead points of each
 * circuit at each step of the number, found by arc length. Critical values, where p is an extremum on a curve, are
 * located to 1e-9 of the range. Circuits that are at no step are not found, nor are their curves. Limits are ignored.
 * KM_USAGE: the driver can't move or is a ball joint, the part of the mechanism has not one freedom beside spins of
 * rods between two ball joints, the path is no number, or the range is invalid; KM_IO, KM_MODEL: the file; KM_MEMORY;
 * KM_CANCELLED: `*out` has the curves and critical values found so far. Free `*out` in any case. O((circuits · steps ·
 * length + curve points) · (rank³ + reading the file)). */
KM_API km_status km_turning_find(const km_mechanism *mechanism, const km_state *state, const km_turning_def *def,
                                 km_progress progress, void *context, km_turning *out, km_error *error);
KM_API void km_turning_free(km_turning *turning);

/* ---- Paths between two configurations without a singularity of the drivers (docs/theory.md 4.21). */

/* Result of a search for a path. */
typedef enum km_space_path_outcome {
  KM_SPACE_PATH_FOUND,     /* a path was found */
  KM_SPACE_PATH_SEPARATED, /* det A has opposite signs at both ends, in all modes found there: every path is singular */
  KM_SPACE_PATH_END,       /* an end can't be assembled, lacks the margin, is beyond a limit, or not free */
  KM_SPACE_PATH_NOT_FOUND, /* none was found among the configurations of the search: there may be one */
  KM_SPACE_PATH_STOPPED    /* `progress` ended the search before one was found */
} km_space_path_outcome;
/* Returns "found", "separated", "end", "not found", "stopped"; "" for another value. */
KM_API const char *km_space_path_outcome_name(km_space_path_outcome outcome);

/* Condition of a caller at every configuration of a path, such as a clearance: false if it isn't met. `state` is
 * closed, its poses are computed, and it must not be changed. */
typedef bool (*km_space_path_condition)(void *context, const km_mechanism *mechanism, const km_state *state);

/* Definition of a search for a path. */
typedef struct km_space_path_def {
  const int *drivers;       /* [driver_count] hinges and slides, one for each freedom of the parts that they move */
  int driver_count;         /* number of drivers */
  const double *to;         /* [coordinate] end: a closed configuration, in the model's units; NULL: to_drivers */
  const double *to_drivers; /* [driver_count] values of the drivers at the end, in any assembly mode */
  double margin;            /* least smallest singular value of A; 0: KM_DEFAULT_PATH_MARGIN */
  bool ignore_limits;       /* joint limits don't count */
  int most;                 /* most configurations of the search; 0: KM_DEFAULT_PATH_CONFIGURATIONS */
  unsigned long seed;       /* start of the random numbers: another one may find another path */
  km_space_path_condition condition; /* further condition; NULL: none */
  void *context;                     /* passed to `condition` */
} km_space_path_def;

enum {
  KM_DEFAULT_PATH_CONFIGURATIONS = 20000, /* configurations of a search, unless stated */
  KM_MAX_PATH_DRIVERS = 16                /* most drivers */
};
/* Least smallest singular value of A along a path, unless stated. */
#define KM_DEFAULT_PATH_MARGIN 0.02

/* A path. */
typedef struct km_space_path {
  km_space_path_outcome outcome; /* result */
  km_table *table;     /* s (scaled length of the path so far), q. of the drivers, q. of the other coordinates,
                           * sigma.input; a row for each step; no rows unless a path was found */
  km_table *motion;    /* t (0 to 1), q. of the drivers: at equal steps of time, at rest at both ends; no rows unless a
                           * path was found */
  double length;       /* scaled length of the path: radians, lengths over the size */
  double least_margin; /* smallest singular value of A along it; infinite where the drivers move no loop */
  double ends[2];      /* smallest singular value of A at both ends */
  bool is_at_start;    /* KM_SPACE_PATH_END: the start is the end that isn't allowed */
  bool is_straight;    /* the drivers go straight from one end to the other */
  bool is_smooth;      /* second derivatives of the drivers are continuous; false: no smooth path is allowed beside the
                           * one found, and this one has corners */
  int configurations;  /* configurations of the search */
  km_table *explored;  /* tree (1: from the start, 2: from the end), parent (row from which a step led there, from 0;
                        * −1: an end), q. of the drivers, q. of the other coordinates, sigma.input: a row for each
                        * configuration of a search that found no path; else no rows */
} km_space_path;

/* Searches for a path from the state's configuration to another one along which det A keeps its sign and the smallest
 * singular value of A (the Jacobian's columns of all coordinates but the drivers) its margin. The straight path of the
 * drivers comes first, then two trees of configurations that grow towards random ones and each other (J. Kuffner,
 * S. LaValle 2000), then shortening. Corners are then rounded by splines of the drivers, whose configurations are
 * allowed as well. Steps are at most 0.04 in radians and lengths over the size; each ends in a closed configuration, to
 * 1e-12. Drivers that move no loop are never singular. KM_USAGE: a driver is a ball joint, not as many drivers as
 * freedoms of the parts beside spins of rods between two ball joints; KM_MEMORY; KM_CANCELLED: the outcome is
 * KM_SPACE_PATH_STOPPED, and `*out` has the configurations explored so far. Free `*out` in any
 * case. O(configurations² + configurations · rank³). */
KM_API km_status km_space_path_find(const km_mechanism *mechanism, const km_state *state, const km_space_path_def *def,
                                    km_progress progress, void *context, km_space_path *out, km_error *error);
KM_API void km_space_path_free(km_space_path *path);

#ifdef __cplusplus
}
#endif
#endif
