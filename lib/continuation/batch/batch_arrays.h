/* Data of a batch: arrays with one element per lane. Private to continuation/. */
#ifndef KM_CONTINUATION_BATCH_BATCH_ARRAYS_H
#define KM_CONTINUATION_BATCH_BATCH_ARRAYS_H

#include "continuation/batch/batch.h"
#include "linalg/dense/recorded_elimination.h"

/* One number per lane. */
typedef struct km_batch_number {
  double of[KM_BATCH_LANES];
} km_batch_number;

/* Vectors, poses, twists and quaternions per lane. */
typedef struct km_lane_vec3 {
  km_batch_number x, y, z;
} km_lane_vec3;
typedef struct km_lane_pose {
  km_lane_vec3 axis[3], p; /* see km_rotation */
} km_lane_pose;
typedef struct km_lane_twist {
  km_lane_vec3 v, w;
} km_lane_twist;
typedef struct km_lane_quaternion {
  km_batch_number w, x, y, z;
} km_lane_quaternion;

/* Numbers of a planar step and of a planar loop: see km_planar_step and km_loop. */
typedef struct km_lane_step {
  km_batch_number x, y, ux, uy;
  bool is_constant; /* constant while the loops close: only the driver moves it */
  bool is_stored;   /* its pose is stored for later reads than that of the next step */
} km_lane_step;
typedef struct km_lane_planar_loop {
  km_batch_number closing_point[2][2], origin_offset[2], point[2], turn;
  km_batch_number origin[2][2]; /* [branch][x, y] reference point of its rows, from each branch's origin */
} km_lane_planar_loop;
/* Numbers of a spatial step and of a spatial loop: see km_step and km_loop. */
typedef struct km_lane_spatial_step {
  km_lane_pose before;
  km_batch_number pitch;
} km_lane_spatial_step;
typedef struct km_lane_spatial_loop {
  km_lane_pose closing_frame[2];
  km_lane_vec3 origin_offset, point;
  km_lane_vec3 origin[2]; /* [branch] reference point of its rows, from each branch's origin */
} km_lane_spatial_loop;
/* Results of a loop. row: positions of its rows in `error`, v x y z, w x y z, or planar x, y, angle; behind the end
 * for components without a row. square: 6 · residual². fixed: of planar loops the constant closure errors v z, w x, w
 * y. */
typedef struct km_lane_loop {
  km_batch_number square, fixed[3];
  int row[6];
} km_lane_loop;
/* Columns of an entry, see km_entry. at: positions of the rows in J, behind its end for components without a row. A
 * ball joint's next two columns follow with stride `next`. turn: w z of a planar step's column, constant. */
typedef struct km_lane_entry {
  int step, columns, column_stride;
  double side, turn;
  int position[6];
} km_lane_entry;
typedef struct km_lane_coupling {
  km_batch_number constant;
} km_lane_coupling;

typedef struct km_lane_slot {
  km_batch_number angle, cosine, sine, x, y;
} km_lane_slot;
/* v x and v y of a planar step's column. */
typedef struct km_lane_column {
  km_batch_number x, y;
} km_lane_column;

/* Results of a row: coordinates, unit direction of motion (scaled by the characteristic length), mobility numbers. */
typedef struct km_lane_row {
  km_batch_number *q, *z, *mobility_number; /* [columns] */
  km_batch_number *residual;
} km_lane_row;

/* Most freedoms of a batched motion. */
enum { KM_BATCH_FREEDOMS = 12 };

/* Lane data of km_step_history and km_driver_motion_position. closed_at: driver value at which the loops were closed;
 * residual: of the worst loop; largest_b: largest entry of B. */
typedef struct km_lane_position {
  km_batch_number last_h, equal_count, s, largest, stopped, closed_at, residual, largest_b;
  km_batch_number older_count, older_h[KM_OLDER_STEPS];
} km_lane_position;

struct km_batch {
  km_arena arena;
  int count;
  km_driver_motion *drives[KM_BATCH_LANES];
  const km_mechanism *m; /* mechanism of the first motion, with the structure of all */
  const km_substructure *sub;
  int coordinate, column; /* the driver */
  unsigned active;        /* bits: lanes that hold the history of their motion */
  unsigned at_target;     /* bits: lanes whose last step reached the target */
  unsigned refreshed;     /* bits: lanes whose states are complete: km_driver_motion_prepare_read */
  unsigned unwritten;     /* bits: lanes with results that are not written back */
  /* list of operations of the elimination with the pivots of the active lanes (theory 3.8) */
  km_recorded_elimination elimination;
  int extra_freedoms; /* freedoms besides the driver's */
  bool *is_length;    /* [columns] a length: its unit can differ from 1 */
  bool *is_ball;      /* [columns] component of a ball joint */
  bool *is_limited;   /* [columns] limited in some lane */

  /* Numbers of the mechanisms. */
  km_lane_step *steps;                 /* [planar steps of the mechanism] */
  km_lane_spatial_step *spatial_steps; /* [other steps] */
  km_lane_loop *loops;                 /* [loop]; planar_loops and spatial_loops too, each for its kind */
  km_lane_planar_loop *planar_loops;
  km_lane_spatial_loop *spatial_loops;
  km_lane_entry *entries;
  km_lane_coupling *couplings;
  km_batch_number *coefficients, *term_unit;                                      /* [term] */
  km_batch_number *unit, *weight, *low, *high;                                    /* [columns] */
  km_batch_number size, inverse_size, closure_tolerance, driver_low, driver_high; /* the driver's limits, scaled */

  /* Positions of the motions. */
  km_lane_position current;
  km_batch_number *q;                      /* [coordinate] */
  km_lane_quaternion *ball;                /* [ball] */
  km_batch_number *t, *last_t, *last_move; /* [columns] as in km_step_history; remaining_step too */
  km_batch_number *remaining_step;
  /* [columns] with one freedom `moves` of km_step_history; a step writes its move in place of the oldest one until
   * km_batch_rotate_history. The first are `older_t` with several freedoms. */
  km_batch_number *past[KM_CURVE_MOVES];
  km_batch_number sign, next_sign; /* sign of the pivots' product, at the start and at the end of a step */
  km_batch_number max_b_at_search, smallest_pivot;
  km_batch_number target; /* target of the driver, scaled */
  km_batch_number factor; /* factor from the model's unit to the scaled driver */

  /* Results of a step. */
  km_batch_number
      /* [freedom × rank] negative entries of the null vectors in dependent columns, in pivot order; the driver's
       * vector is last */
      *B;
  /* [freedom × columns] with several freedoms: orthonormal null space, the driver's vector last */
  km_batch_number *Z;
  km_batch_number *error; /* [rows + 1], the last for components without a row; J alike */

  /* The positions of all lanes lie in one block, which q begins, and its saved copy. */
  size_t position_count;
  km_batch_number *saved;
  km_batch_number *saved_past[KM_CURVE_MOVES]; /* order of the arrays in `past`, which are exchanged */
  km_lane_position saved_current;

  /* Passed rows, the present row behind them, and one row for probes; row_size numbers apart. `row` is written by
   * steps, `read_row` is read by observers. */
  km_lane_row rows[KM_BATCH_ROWS + 1];
  size_t row_size;
  const km_lane_row *row, *read_row;
  int passed_rows;                      /* rows before the present one */
  const km_batch_number *previous_z[2]; /* [columns] z in the previous row and in the one before it, */
  unsigned has_previous[2];             /* known in these lanes */
  km_batch_number *last_z[2];           /* [columns] copies of previous_z at the end of km_batch_advance_rows */
  unsigned has_valid_pivots;            /* lanes whose pivots are valid for observers of the configuration */
  bool is_observed;                     /* observers read rows that contain a zero */
  unsigned is_multi_step;               /* lanes that needed several steps in the last row */
  /* if observed: lanes in which no entry of z changed sign or came near 0 since the previous row */
  unsigned has_no_zero;
  unsigned arrived; /* lanes that reached their targets in the last row */

  /* Workspace of a step. */
  km_batch_number *from, *move, *next_t, *x; /* [columns] */
  km_batch_number *stage[KM_PATH_STAGES];    /* [columns] Runge-Kutta stage rates */
  km_batch_number *J, *y, *inverse;          /* [rows × columns], [rows], [rank] */
  km_lane_slot *slots;
  km_lane_column *h;
  km_lane_pose *poses;   /* [slot] of spatial programs */
  km_lane_twist *twists; /* [3 × spatial steps]: a ball joint has three */
  km_lane_quaternion *from_ball;
};

/* True if the moving substructures of two motions have equal structure; and true if a batch covers the motion. */
bool km_batch_has_same_structure(const km_driver_motion *one, const km_driver_motion *other);
bool km_batch_fits(const km_driver_motion *drive);
/* Sets the positions of the loops' rows and entries. */
void km_batch_copy_structure(km_batch *lanes);
/* Copies the numbers of the index-th motion's mechanism into its lane. */
void km_batch_copy_numbers(km_batch *lanes, int index);

/* Finishes a step in the lanes `ended`: coordinates of ball joints, and into `move` their rotation vectors. */
void km_batch_finish_ball_joints(km_batch *lanes, unsigned ended);

/* Shifts the moves of the lanes that `took` a step and adds its move; one freedom. */
void km_batch_rotate_history(km_batch *lanes, unsigned took);

/* Saves the positions of all lanes; restores all of them, or one. */
void km_batch_save(km_batch *lanes);
void km_batch_restore(km_batch *lanes);
void km_batch_restore_lane(km_batch *lanes, int index);

/* Takes one step of the lanes `wanted` towards their targets. Returns those that took it; the others keep their
 * position. One function per register width. */
unsigned km_batch_step_sse2(km_batch *lanes, unsigned wanted);
unsigned km_batch_step_avx2(km_batch *lanes, unsigned wanted);
unsigned km_batch_step_avx512(km_batch *lanes, unsigned wanted);

static inline km_quaternion km_lane_ball(const km_lane_quaternion *ball, int i) {
  return (km_quaternion){ball->w.of[i], ball->x.of[i], ball->y.of[i], ball->z.of[i]};
}

/* Vectors of a history from before its last step: see `past` of km_batch. */
typedef struct km_lane_past {
  int count;
  double *const *of;
} km_lane_past;

static inline km_lane_past km_lane_past_of(const km_batch *l, const km_step_history *history) {
  return l->extra_freedoms == 0 ? (km_lane_past){KM_CURVE_MOVES, history->moves}
                                : (km_lane_past){KM_OLDER_STEPS, history->older_t};
}

/* Copies history, position and the coordinates of the substructure from the i-th motion into its lane, or back. */
void km_batch_transfer(km_batch *lanes, int i, bool is_loaded);
/* Copies the ball joints of lane i into its state. */
void km_batch_write_ball_joints(const km_batch *lanes, int i);
/* Computes Jacobian, partition and null space of a batched motion's state, with the bits of a single motion. */
void km_batch_refresh_state(const km_batch *lanes, km_driver_motion *drive);

#endif
