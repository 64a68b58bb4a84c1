/* What the lanes of several drives hold: arrays with an element for each lane. Private to kinematics/. */
#ifndef KM_CONTINUATION_BATCH_BATCH_ARRAYS_H
#define KM_CONTINUATION_BATCH_BATCH_ARRAYS_H

#include "continuation/batch/batch.h"
#include "linalg/dense/recorded_elimination.h"

/* One number of every lane. */
typedef struct km_batch_number {
  double of[KM_BATCH_LANES];
} km_batch_number;

/* Vectors, poses and twists of every lane. */
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

/* The numbers of a planar step and of a planar loop: see km_planar_step and km_loop. */
typedef struct km_lane_step {
  km_batch_number x, y, ux, uy;
  bool still; /* stays where it is while the loops are closed: only the driver carries it */
  bool kept;  /* its place is read later than by the next step */
} km_lane_step;
typedef struct km_lane_planar_loop {
  km_batch_number close[2][2], apart[2], point[2], turn;
  km_batch_number origin[2][2]; /* the point of its rows, in x and y, from each of the two origins */
} km_lane_planar_loop;
/* The same in space: see km_step and km_loop. */
typedef struct km_lane_space_step {
  km_lane_pose before;
  km_batch_number pitch;
} km_lane_space_step;
typedef struct km_lane_space_loop {
  km_lane_pose close[2];
  km_lane_vec3 apart, point;
  km_lane_vec3 origin[2]; /* the point of its rows from each of the two origins */
} km_lane_space_loop;
/* What every loop has. row: places of its rows in `error`, v x y z, w x y z, or in a plane x, y, turn; behind its end if they
 * are none. square: six times that of its residual. fixed: in a plane the parts of its misfit that stay, v z, w x, w y. */
typedef struct km_lane_loop {
  km_batch_number square, fixed[3];
  int row[6];
} km_lane_loop;
/* See km_entry. at: places of the rows in J, as above; behind its end if they are none. A ball's next two columns follow at
 * `next` each; what has no row lies two columns behind the end at most. turn: of a planar step's column, which stays. */
typedef struct km_lane_entry {
  int step, columns, next;
  double side, turn;
  int at[6];
} km_lane_entry;
typedef struct km_lane_coupling {
  km_batch_number constant;
} km_lane_coupling;

typedef struct km_lane_slot {
  km_batch_number angle, cosine, sine, x, y;
} km_lane_slot;
/* A column of a planar step but for its turn: v x, v y. */
typedef struct km_lane_column {
  km_batch_number x, y;
} km_lane_column;

/* What is shown of a row: coordinates, the unit direction of motion (lengths over the characteristic length), and mobility
 * numbers. */
typedef struct km_lane_row {
  km_batch_number *q, *z, *numbers; /* [columns] */
  km_batch_number *residual;
} km_lane_row;

/* More freedoms than these don't ride. */
enum { KM_BATCH_FREEDOMS = 12 };

/* See km_step_history and km_driver_motion_place. closed_at: the driver where the loops were closed; residual: of the worst loop. */
typedef struct km_lane_place {
  km_batch_number last_h, equal_count, s, largest, stopped, closed_at, residual, largest_b;
  km_batch_number older_count, older_h[KM_OLDER_STEPS];
} km_lane_place;

struct km_batch {
  km_arena arena;
  int count;
  km_driver_motion *drives[KM_BATCH_LANES];
  const km_mechanism *m; /* of the first drive: the structure is that of all */
  const km_substructure *sub;
  int coordinate, column; /* the driver */
  unsigned aboard;        /* bits: lanes that hold the course of their drive */
  unsigned there;         /* those that the last step led to their targets */
  unsigned
      looked;     /* those whose states show the present pose with all that it has, see km_driver_motion_prepare_read */
  unsigned ahead; /* and those whose course is newer than that of the drive */
  km_recorded_elimination replay; /* by the pivots of the lanes aboard */
  int beside;                     /* motions that leave the driver alone: freedoms but one */
  bool *is_length;                /* [columns] its unit may be another one than 1 */
  bool *is_ball;                  /* [columns] it belongs to a ball, as the next or last two do too */
  bool *is_limited;               /* [columns] in some lane */

  /* Numbers of the mechanisms. */
  km_lane_step *steps;             /* [planar steps of the mechanism] */
  km_lane_space_step *space_steps; /* [other steps] */
  km_lane_loop *loops;             /* [loop], and so are the next two, for those of their kind: */
  km_lane_planar_loop *planar_loops;
  km_lane_space_loop *space_loops;
  km_lane_entry *entries;
  km_lane_coupling *couplings;
  km_batch_number *coefficients, *term_unit;                                      /* [term] */
  km_batch_number *unit, *weight, *low, *high;                                    /* [columns] */
  km_batch_number size, inverse_size, closure_tolerance, driver_low, driver_high; /* the driver's limits, scaled */

  /* Where the drives are. */
  km_lane_place here;
  km_batch_number *q;                      /* [coordinate] */
  km_lane_quaternion *ball;                /* [ball] */
  km_batch_number *t, *last_t, *last_move; /* [columns] as in km_step_history; so are these: */
  km_batch_number *rest;
  /* [columns] of one freedom `moves`, and where a step has ended its move is in place of the oldest one, until
   * km_batch_extend_history; of several the first are `older_t`. */
  km_batch_number *past[KM_CURVE_MOVES];
  km_batch_number sign, next_sign; /* of the pivots' product, ±1, and where the step ends */
  km_batch_number pivoted_b, smallest_pivot;
  km_batch_number target; /* of the step, scaled */
  km_batch_number factor; /* a target in the model's unit times this is the scaled one */

  /* What a step leaves: */
  km_batch_number
      *B; /* [freedom × rank] null vectors: the dependent columns' in pivot order, negative; the driver's is last */
  km_batch_number *Z;     /* [freedom × columns] of several freedoms: the null space, the driver's vector last */
  km_batch_number *error; /* [rows], and one more for what is no row; J alike */

  /* All that makes a place lies in one block, which q begins. A copy, to come back to. */
  size_t place_count;
  km_batch_number *kept;
  km_batch_number *kept_past[KM_CURVE_MOVES]; /* as `past` was, whose arrays change their places */
  km_lane_place kept_here;

  /* Rows that were passed, and behind them the one where the drives are, `row_size` numbers apart, and one more for steps that
   * are no row's. `row` is the one that steps write, `shown` the one that is looked at. */
  km_lane_row rows[KM_BATCH_ROWS + 1];
  size_t row_size;
  const km_lane_row *row, *shown;
  int passed;                       /* rows before the last one */
  const km_batch_number *before[2]; /* [columns] z at the row before, and at the one before that, */
  unsigned known[2];                /* in these lanes */
  km_batch_number *last_z[2];       /* [columns] the same where the last pass ended */
  unsigned sound;                   /* lanes whose pivots serve whoever looks at the pose */
  bool looks;                       /* somebody looks at rows that aren't quiet */
  unsigned several;                 /* lanes that the last row took several steps */
  unsigned quiet;   /* then: lanes where no entry of z has changed its sign, or come near 0, since the row before */
  unsigned arrived; /* lanes that the last row's steps led to their targets */

  /* What a step works on. */
  km_batch_number *from, *move, *next_t, *x; /* [columns] */
  km_batch_number *stage[KM_PATH_STAGES];    /* [columns] km_minimum_norm_path's rates */
  km_batch_number *J, *y, *inverse;          /* [rows × columns], [rows], [rank] */
  km_lane_slot *slots;
  km_lane_column *h;
  km_lane_pose *poses;   /* of the slots of programs in space */
  km_lane_twist *twists; /* [steps in space × 3], as balls have them */
  km_lane_quaternion *from_ball;
};

/* Do the mechanisms of two drives differ in numbers only, in the substructure that moves? And are lanes for it at all? */
bool km_batch_has_same_structure(const km_driver_motion *one, const km_driver_motion *other);
bool km_batch_fits(const km_driver_motion *drive);
/* Where the numbers of the loops' rows and entries go. */
void km_batch_copy_structure(km_batch *lanes);
/* The numbers of the index-th drive's mechanism into its lane. */
void km_batch_copy_numbers(km_batch *lanes, int index);

/* Where a step ends in these lanes: the balls' coordinates, and into `move` the rotation vectors that led them there. */
void km_batch_finish_ball_joints(km_batch *lanes, unsigned ended);

/* Of one freedom: the moves of the lanes that `took` a step become older, and the step's one joins them. */
void km_batch_extend_history(km_batch *lanes, unsigned took);

/* Keeps the place of all lanes, and brings all, or one, back there. */
void km_batch_save(km_batch *lanes);
void km_batch_restore(km_batch *lanes);
void km_batch_restore_lane(km_batch *lanes, int index);

/* One step of the lanes `wanted` towards their targets. Returns those that took it; the others are where they were. By the
 * processor's registers. */
unsigned km_batch_step_sse2(km_batch *lanes, unsigned wanted);
unsigned km_batch_step_avx2(km_batch *lanes, unsigned wanted);
unsigned km_batch_step_avx512(km_batch *lanes, unsigned wanted);

static inline km_quaternion km_lane_ball(const km_lane_quaternion *ball, int i) {
  return (km_quaternion){ball->w.of[i], ball->x.of[i], ball->y.of[i], ball->z.of[i]};
}

/* What a course remembers from before its last step: see km_batch. */
typedef struct km_lane_past {
  int count;
  double *const *of;
} km_lane_past;

static inline km_lane_past km_lane_past_of(const km_batch *l, const km_step_history *course) {
  return l->beside == 0 ? (km_lane_past){KM_CURVE_MOVES, course->moves}
                        : (km_lane_past){KM_OLDER_STEPS, course->older_t};
}

/* The state's ball joints are those of lane i. */
void km_batch_write_ball_joints(const km_batch *lanes, int i);
/* Jacobian, partition and null space of the drive's state, as at a step outside a batch. */
void km_batch_refresh_state(const km_batch *lanes, km_driver_motion *drive);

#endif
