/* The compiled mechanism. Built once, then read only; contiguous arrays, indices instead of pointers.
 *
 * A substructure is computed by itself: its lengths are divided by its own size, and each of its loops is
 * seen from the loop's base body, near the loop's own joints. Neither the inertial frame nor other
 * substructures touch its digits. Loops with the same base share one program of steps. */
#ifndef KM_TOPOLOGY_MECHANISM_H
#define KM_TOPOLOGY_MECHANISM_H

#include "kmech/mechanism.h"
#include "model/model.h"
#include "spatial/twist.h"
#include "topology/spanning_tree.h"

/* One primitive motion on the way out from a base. Slot 0 of a program is its base. */
typedef struct km_step {
  km_primitive primitive;
  int axis;
  int coordinate;    /* first coordinate of the primitive */
  int ball;          /* index among the ball motions, for KM_BALL */
  double sign;       /* -1: the joint is passed against its sense */
  double pitch;      /* scaled travel per radian of a helical motion */
  int from, to;      /* pose slots of the program */
  bool has_rotation; /* `before` turns, not only shifts */
  km_pose before;    /* from slot `from` to the frame of the motion, scaled */
} km_step;

/* The same in a plane, from the configuration in which every coordinate is 0: orientations there count as 0,
 * so no constant rotation is left. */
typedef struct km_planar_step {
  bool is_slide;
  int coordinate;
  double sign;
  int from, to;
  double x, y;   /* the joint's place less that of `from`, when all coordinates are 0, scaled */
  double ux, uy; /* direction of a slide, when all coordinates are 0 */
} km_planar_step;

/* Loops seen from one base body. Slots have the base frame's axes; their positions are counted from where their branch
 * leaves the base body. */
typedef struct km_program {
  bool planar;
  int base_frame;             /* the frame of the base body whose axes slot 0 has */
  int step_start, step_count; /* into steps or planar_steps */
  int loop_start, loop_count; /* into loop_order */
  int slot_count;
  int twist_start; /* into the states' twists: three a step in space, one in a plane */
} km_program;

/* A step's columns in a loop's block: +1 on the virtual side, -1 on the other. */
typedef struct km_entry {
  int step;   /* into the program's steps */
  int column; /* first column in the substructure's Jacobian */
  double side;
  size_t value_index,
      column_stride; /* where its first value is stored, and how far behind it that of the next column is */
} km_entry;

typedef struct km_loop {
  int lambda;               /* dimension of the motion space */
  int rows[6];              /* which of v x y z, w x y z are independent; planar programs: x, y, turn */
  bool has_moving_point;    /* all of v and w: the rows may be taken at any point */
  int row_start;            /* in the substructure's Jacobian */
  int slot[2];              /* where the virtual body and the embedding body end */
  km_pose closing_frame[2]; /* from those slots to the two frames that must meet, scaled */
  km_vec3 origin_offset;    /* from the origin of the first slot's branch to that of the second's, scaled */
  km_vec3 point[2];         /* the loop's own point, about which its rows are taken, from each of the two origins */
  double planar_closing_point[2][2]; /* the same in a planar program, in the plane's axes */
  double planar_origin_offset[2], planar_point[2];
  double planar_closing_angle; /* turn of the one frame against the other when all coordinates are 0 */
  double fixed_misfit[6];      /* planar: what no coordinate can change (v z, w x, w y in the plane's frame) */
  double
      pin_offset; /* of a loop of hinges in a plane: distance of its ends along the hinge axes, scaled; not an error */
  km_vec3 plane_normal; /* unit direction of that, in the base body's axes */
  int entry_start, entry_count;
} km_loop;

typedef struct km_coupling {
  int row;
  int term_start, term_count;
  double constant; /* of the scaled row */
} km_coupling;

typedef struct km_term {
  int coordinate, column; /* column -1: held */
  double coefficient;     /* of the scaled coordinate, scaled so that the largest of a row is 1 */
  int curve_start,
      curve_count;    /* > 0: instead, a polynomial of the scaled coordinate, lowest power first; in `curves` */
  size_t value_index; /* where its value is stored in the Jacobian */
} km_term;

/* Which entries of a Jacobian are stored: all, column by column, or of a large one with few entries other than 0 just
 * those: the rows of column c are row[start[c] … start[c+1]-1]. */
typedef struct km_pattern {
  int *start, *row; /* NULL: all */
  size_t size;      /* stored values */
  bool *used;       /* [rows × columns] where all are stored: can the value be other than 0? NULL: by its entries */
} km_pattern;

typedef struct km_substructure {
  int rows, columns;
  double size;      /* length scale, in the model's unit */
  double span;      /* the part of `size` that no pose changes: distances between joints, and pitches */
  int column_start; /* into column_coordinate */
  int program_start, program_count;
  int loop_start, loop_count; /* into loop_order */
  int ball_start, ball_count; /* into ball_order */
  int limited_count;          /* of its columns that have limits: limited_column[column_start …] */
  int coupling_start, coupling_count;
  km_pattern pattern;
  size_t matrix_start; /* into the states' Jacobian store */
  int error_start;     /* into the states' error store */
} km_substructure;

/* A joint on the way from the inertial frame to a body, for poses in the inertial frame. */
typedef struct km_arc {
  int body, parent, joint;
  bool is_reversed;
  km_pose before, after; /* parent body to joint frame, joint frame to body; unscaled */
} km_arc;

struct km_mechanism {
  km_arena arena;
  km_mechanism *spare; /* arrays of its own that the next renumbering fills; NULL until the first one */
  struct km_compile_workspace *spare_workspace;
  km_hold *holds;
  int hold_count;
  unsigned version; /* how often it was given new numbers */
  const km_model *model;
  km_topology topology;
  double length; /* the characteristic length, in the model's unit */
  km_length_source length_source;
  double position_rounding;     /* a distance up to this is 0 but for the rounding of places (km_position_rounding) */
  double closure_tolerance;     /* of secondary rows, scaled */
  bool closure_tolerance_given; /* by the file or the caller: pivots and motion spaces then follow it */
  int coordinate_count, ball_count;
  bool *held;             /* [coordinate] */
  double *start;          /* [coordinate] initial displacement: radians, or the model's length unit */
  double *start_rate;     /* [coordinate] initial rate, per time; 0 of held ones */
  bool *start_stated;     /* [coordinate] the model states that rate; false of held ones */
  double *low, *high;     /* [coordinate] limits, the same units */
  double *max_ball_angle; /* [coordinate] limit of a ball's angle, at its first one; infinity: none */
  double *max_rate;       /* [coordinate] of the drive, the same units over the model's time unit; infinity: none */
  double *max_force;      /* [coordinate] of the drive, a force or (of angles) a torque; infinity: none */
  double *armature;       /* [coordinate] inertia of the drive's rotor: a mass, of angles times length² */
  double *friction;       /* [coordinate] constant friction, a force or a torque */
  double *scale;          /* [coordinate] D of theory 4: 1, or 1/characteristic length for lengths */
  double *factor;         /* [coordinate] km_model_coordinate_factor */
  double *unit;           /* [coordinate] 1, or the substructure's size for lengths: coordinate = unit · scaled */
  int *ball_of;           /* [coordinate] ball motion that it belongs to, -1 */
  int *ball_coordinate;   /* [ball] its first coordinate */
  int *ball_order;        /* [ball] by substructure; those that are in none, or held, aren't listed */
  int *substructure_of;   /* [coordinate] -1: in none */
  int *column_of;         /* [coordinate] column in its substructure; -1: held or in none */
  km_substructure *substructures;
  int *column_coordinate; /* coordinates of the substructures' columns */
  int *limited_column;    /* of each substructure from its column_start on: the columns whose coordinates have limits */
  double *column_weight;  /* D of a column's scaled coordinate: scale · unit */
  km_program *programs;
  km_step *steps;
  km_planar_step *planar_steps;
  km_loop *loops;  /* [topology.loop_count] */
  int *loop_order; /* loops by substructure */
  km_entry *entries;
  km_coupling *couplings;
  km_term *terms;
  double *curves; /* coefficients of the terms that are polynomials */
  km_arc *arcs;   /* bodies by level, without the inertial frame */
  int *arc_of;    /* [body] into arcs; -1 for the inertial frame */
  int program_count, step_count, planar_step_count, entry_count, coupling_count, term_count, curve_size;
  int twist_count;
  int largest_slots, largest_rows, largest_columns;
  size_t matrix_size;
  int error_size;
};

/* Has the coordinate limits? That of a ball's angle counts as one of its first coordinate. */
static inline bool km_is_limited(const km_mechanism *m, int c) {
  return isfinite(m->low[c]) || isfinite(m->high[c]) || isfinite(m->max_ball_angle[c]);
}

/* How to compile a model. What is 0 follows the model. */
typedef struct km_compiling {
  const km_hold *holds;
  int hold_count;
  double closure_tolerance;
  double length; /* characteristic length */
  km_length_source length_source;
} km_compiling;

/* km_mechanism_compile without a look at the assembled pose: where neither `how` nor the model has a length, it is one
 * length unit. */
km_status km_mechanism_compile_as(const km_model *model, const km_compiling *how, km_mechanism **out, km_error *error);

#endif
