/* The compiled mechanism: topology, loop programs and numbers (docs/theory.md 2.2-2.5). Built once, then read only;
 * contiguous arrays, indices instead of pointers.
 *
 * A substructure is computed by itself: its lengths are divided by its own size, and each of its loops is expressed in
 * the axes of the loop's base body, near the loop's own joints. Neither the inertial frame nor other substructures
 * affect its digits. Loops with one base body share one program of steps. */
#ifndef KM_TOPOLOGY_MECHANISM_H
#define KM_TOPOLOGY_MECHANISM_H

#include "kmech/mechanism.h"
#include "model/model.h"
#include "spatial/twist.h"
#include "topology/spanning_tree.h"

/* One primitive motion of a program, from the base outwards. Slot 0 of a program is its base. */
typedef struct km_step {
  km_primitive primitive;
  int axis;
  int coordinate;    /* first coordinate of the primitive */
  int ball;          /* index among the ball motions, for KM_BALL */
  double sign;       /* −1: the joint is reversed */
  double pitch;      /* scaled travel per radian of a helical motion */
  int from, to;      /* pose slots of the program */
  bool has_rotation; /* `before` has a rotation */
  km_pose before;    /* displacement from slot `from` to the frame of the motion, scaled */
} km_step;

/* Planar step, counted from the configuration in which every coordinate is 0: orientations there count as 0, so that no
 * constant rotation remains. */
typedef struct km_planar_step {
  bool is_slide;
  int coordinate;
  double sign;
  int from, to;
  double x, y;   /* position of the joint minus that of `from`, with all coordinates 0, scaled */
  double ux, uy; /* direction of a slide, with all coordinates 0 */
} km_planar_step;

/* Program of the loops with one base body. Slots have the base frame's axes; positions are counted from the point where
 * the branch leaves the base body. */
typedef struct km_program {
  bool planar;
  int base_frame;             /* frame of the base body with the axes of slot 0 */
  int step_start, step_count; /* range in steps or planar_steps */
  int loop_start, loop_count; /* range in loop_order */
  int slot_count;
  int twist_start; /* first index in the states' twists: three per spatial step, one per planar step */
} km_program;

/* Columns of a step in a loop's block of J: side +1 on the path to the virtual body, −1 on the other. */
typedef struct km_entry {
  int step;   /* index in the program's steps */
  int column; /* first column in the substructure's Jacobian */
  double side;
  size_t value_index, column_stride; /* index of its first value in J, and distance to the value of the next column */
} km_entry;

typedef struct km_loop {
  int lambda;               /* dimension of the motion space */
  int rows[6];              /* independent rows of (v; ω), 0 to 5; planar programs: of (v_x, v_y, ω) */
  bool has_moving_point;    /* the loop has all rows of v and ω, so they may be taken at the moving point where its
                             * frames meet */
  int row_start;            /* in the substructure's Jacobian */
  int slot[2];              /* last slots of the virtual side and of the other side */
  km_pose closing_frame[2]; /* displacements from these slots to the two frames that must coincide, scaled */
  km_vec3 origin_offset;    /* vector from the origin of the first branch to that of the second, scaled */
  km_vec3 point[2];         /* point of the loop at which its rows are taken, from each of the two origins */
  double planar_closing_point[2][2]; /* closing positions in a planar program, in the plane's axes */
  double planar_origin_offset[2], planar_point[2];
  double planar_closing_angle; /* rotation of the first closing frame relative to the second with all coordinates 0 */
  double fixed_misfit[6];      /* planar: closure error that no coordinate changes (v_z, ω_x, ω_y in the plane's
                                * frame) */
  double pin_offset;    /* planar loop of hinges: offset of its ends along the hinge axes, scaled; not an error */
  km_vec3 plane_normal; /* unit normal of the plane, in the base body's axes */
  int entry_start, entry_count;
} km_loop;

typedef struct km_coupling {
  int row;
  int term_start, term_count;
  double constant; /* constant of the scaled row */
} km_coupling;

typedef struct km_term {
  int coordinate, column; /* column -1: held */
  double coefficient;     /* coefficient of the scaled coordinate; the largest of a row is 1 */
  int curve_start,
      curve_count;    /* count > 0: a polynomial of the scaled coordinate instead, lowest power first, in `curves` */
  size_t value_index; /* index of its value in the Jacobian */
} km_term;

/* Stored entries of a Jacobian: all by column, or of a large sparse one those that can be non-zero: the rows of column
 * c are row[start[c] … start[c+1]-1]. */
typedef struct km_pattern {
  int *start, *row; /* NULL: all */
  size_t size;      /* number of stored values */
  bool *used;       /* [rows × columns] if all are stored: the value can be non-zero; NULL for sparse patterns */
} km_pattern;

typedef struct km_substructure {
  int rows, columns;
  double size;      /* length scale, in the model's unit */
  double span;      /* part of `size` that is constant in all configurations: distances between joints, and pitches */
  int column_start; /* first index in column_coordinate */
  int program_start, program_count;
  int loop_start, loop_count; /* range in loop_order */
  int ball_start, ball_count; /* range in ball_order */
  int limited_count;          /* number of its columns with limits: limited_column[column_start …] */
  int coupling_start, coupling_count;
  km_pattern pattern;
  size_t matrix_start; /* first index in the states' Jacobian store */
  int error_start;     /* first index in the states' error store */
} km_substructure;

/* A tree joint of a body, for forward kinematics in the inertial frame. */
typedef struct km_arc {
  int body, parent, joint;
  bool is_reversed;
  km_pose before, after; /* parent body to joint frame, joint frame to body; unscaled */
} km_arc;

struct km_mechanism {
  km_arena arena;
  km_mechanism *spare; /* second set of arrays for the next renumbering; NULL until the first one */
  struct km_compile_workspace *spare_workspace;
  km_hold *holds;
  int hold_count;
  unsigned version; /* number of renumberings */
  const km_model *model;
  km_topology topology;
  double length; /* the characteristic length, in the model's unit */
  km_length_source length_source;
  double position_rounding;     /* distance that rounding of positions can cause (km_position_rounding) */
  double closure_tolerance;     /* tolerance of secondary rows, scaled */
  bool closure_tolerance_given; /* stated by the file or the caller; ranks and motion spaces then use it */
  int coordinate_count, ball_count;
  bool *held;             /* [coordinate] */
  double *start;          /* [coordinate] initial displacement: radians, or the model's length unit */
  double *start_rate;     /* [coordinate] initial rate, per time; 0 of held ones */
  bool *start_stated;     /* [coordinate] the model states that rate; false of held ones */
  double *low, *high;     /* [coordinate] limits, the same units */
  double *max_ball_angle; /* [coordinate] limit of a ball joint's angle, at its first coordinate; infinity: none */
  double *max_rate;       /* [coordinate] of the drive, the same units over the model's time unit; infinity: none */
  double *max_force;      /* [coordinate] of the drive, a force or (of angles) a torque; infinity: none */
  double *armature;       /* [coordinate] inertia of the drive's rotor: a mass, of angles times length² */
  double *friction;       /* [coordinate] constant friction, a force or a torque */
  double *scale;          /* [coordinate] metric D (docs/theory.md 1.4): 1, or 1/characteristic length for lengths */
  double *factor;         /* [coordinate] km_model_coordinate_factor */
  double *unit;           /* [coordinate] 1, or the substructure's size for lengths: coordinate = unit · scaled */
  int *ball_of;           /* [coordinate] ball motion that it belongs to, -1 */
  int *ball_coordinate;   /* [ball] its first coordinate */
  int *ball_order;        /* [ball] ball motions by substructure; those in none and held ones are omitted */
  int *substructure_of;   /* [coordinate] -1: in none */
  int *column_of;         /* [coordinate] column in its substructure; -1: held or in none */
  km_substructure *substructures;
  int *column_coordinate; /* coordinates of the substructures' columns */
  int *limited_column;    /* columns with limits, of each substructure from its column_start on */
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
  int *arc_of;    /* [body] index into arcs; -1 for the inertial frame */
  int program_count, step_count, planar_step_count, entry_count, coupling_count, term_count, curve_size;
  int twist_count;
  int largest_slots, largest_rows, largest_columns;
  size_t matrix_size;
  int error_size;
};

/* True if all loops of a substructure are planar; false without loops. */
static inline bool km_substructure_is_planar(const km_mechanism *m, int index) {
  const km_substructure *sub = &m->substructures[index];
  bool planar = sub->program_count > 0;
  for (int p = sub->program_start; p < sub->program_start + sub->program_count; ++p)
    planar = planar && m->programs[p].planar;
  return planar;
}

/* True if the coordinate has limits. The limit of a ball joint's angle counts for its first coordinate. */
static inline bool km_is_limited(const km_mechanism *m, int c) {
  return isfinite(m->low[c]) || isfinite(m->high[c]) || isfinite(m->max_ball_angle[c]);
}

/* Options of a compilation. Values of 0 follow the model. */
typedef struct km_compiling {
  const km_hold *holds;
  int hold_count;
  double closure_tolerance;
  double length; /* characteristic length */
  km_length_source length_source;
  bool cuts_balls; /* loops are cut at ball joints where they can be, not where the breadth-first tree ends */
} km_compiling;

/* The holds of a model; NULL when out of memory. The caller frees them. */
km_hold *km_model_list_holds(const km_model *model);

/* Options that compile the model of m as m was compiled; its holds are borrowed. */
static inline km_compiling km_mechanism_options(const km_mechanism *m) {
  return (km_compiling){.holds = m->holds,
                        .hold_count = m->hold_count,
                        .closure_tolerance = m->closure_tolerance_given ? m->closure_tolerance : 0.0,
                        .length = m->length,
                        .length_source = m->length_source};
}

/* Compiles a model without assembly: if neither the options nor the model have a length, the characteristic length is
 * one length unit. */
km_status km_mechanism_compile_as(const km_model *model, const km_compiling *options, km_mechanism **out,
                                  km_error *error);

#endif
