/* A map over two drivers while it is followed (docs/theory.md 4.19, 4.22). */
#ifndef KM_SPACE_MAP_SEARCH_H
#define KM_SPACE_MAP_SEARCH_H

#include "base/memory.h"
#include "space/curves/surface_curves.h"

/* A configuration that a sheet has at a grid point. */
typedef struct km_known_configuration {
  const double *saved;
  int aspect; /* 0: none, or not numbered yet */
  struct km_known_configuration *next;
} km_known_configuration;

/* Shares of the work on a map, in their order. */
typedef enum km_map_share {
  KM_MAP_SHARE_MODES,
  KM_MAP_SHARE_RANDOM_STARTS,
  KM_MAP_SHARE_CURVES,
  KM_MAP_SHARE_WORKSPACE
} km_map_share;

typedef struct km_map_search {
  km_driver_surface f;
  const km_space_map_def *def;
  km_progress_stage stage;
  km_surface_curves *curves;
  km_arena arena;
  int last_sheet;                    /* number of the newest sheet */
  size_t left_points;                /* points of curves from whose sides sheets were followed */
  size_t crossed_points;             /* points of curves whose crossing curves were added */
  int across, down;                  /* grid points along both drivers */
  double *before;                    /* [saved_size] start of a step */
  double *saved, *N;                 /* [cell][saved_size], [cell][2 · columns] */
  signed char *sign;                 /* [cell] of det A; 0: not reached */
  km_known_configuration **known;    /* [cell] those of all sheets, the present one first */
  int *queue;                        /* [tail] cells of the present sheet in the order in which they were reached */
  int tail, sheet;                   /* number of the present sheet */
  signed char *output_sign;          /* [cell] of det D; 0: no point, or on a curve */
  double *output;                    /* [cell][3] det (J; G), and its derivatives over a grid step along both drivers */
  double *rows;                      /* [cell × columns of the table] of the present sheet */
  size_t sigma_input;                /* its column */
  bool *is_written;                  /* [cell] it has a row */
  int *aspect;                       /* [cell] its aspect; 0: none yet */
  int kept_sign;                     /* sign of det (J; G) that steps keep all along; 0: they needn't */
  double *start_N, *edge_N, *kept_N; /* [2 · columns] workspace */
  double *K;                         /* [columns²] workspace */
  int *row;                          /* [columns] workspace */
  int aspect_count;                  /* aspects of all sheets so far */
  double curve_distance;             /* grid points nearer to a known curve don't look for another */
  bool is_ended;                     /* the caller's figures end the map */
  km_state *at;                      /* state for the caller's figures; NULL: none */
  km_space_map *out;
} km_map_search;

/* Begins part i of `count` equal parts of a share of the map. */
void km_map_begin_part(km_map_search *g, km_map_share share, size_t i, size_t count);
/* Reports how much of the present part is done. KM_CANCELLED: the caller ends the map. */
km_status km_map_report(km_map_search *g, double done, km_error *error);
/* Value of an axis at a grid point, and at the state, scaled. */
double km_map_axis_value(const km_map_search *g, int axis, int i);
double km_map_scaled_value(const km_map_search *g, int axis);
/* True if the range of an axis ends: it isn't a full turn of a hinge. */
bool km_map_axis_ends(const km_map_search *g, int axis);
/* One of the four neighbours of a cell; −1: the grid ends there. */
int km_map_neighbour(const km_map_search *g, int cell, int k);
/* True if the state's configuration is a saved one, but for full turns of hinges. */
bool km_map_is_at(const km_map_search *g, const double *saved);
/* det (J; G), and in *rate its derivative along the step N du. */
double km_map_output_determinant(km_map_search *g, const double *N, const double *du, double *rate);
/* True if the cubic with this value and derivative at the start (or end, with the derivative's other sign) of a step
 * has the first (last) two Bernstein coefficients of this sign. Four of them: it has no root in the step. */
bool km_map_has_sign(double sign, double value, double rate);
/* True if the state lies beyond a saved configuration as far as the tangents at both ends of the step du predict. */
bool km_map_is_smooth(km_map_search *g, const double *saved, const double *N, const double *N_here, const double *du);
/* Moves the state from a cell of the sheet to another one, in steps that keep the sign of det A, and g->kept_sign. N:
 * workspace for the tangents. False: it isn't reached. */
bool km_map_reach(km_map_search *g, int from, int cell, double *N);
/* Numbers the aspect of a cell: all cells that steps of the grid connect without a singularity of the drivers or of the
 * output. `stack`[cell] is workspace. */
void km_map_number_aspect(km_map_search *g, int first, int *stack);
/* Moves the state from a configuration to the grid point nearest to it. *sign: that of det A; N: workspace for the
 * tangents. Returns the cell; −1: it isn't reached. */
int km_map_enter_grid(km_map_search *g, int *sign, double *N);
/* The state's configuration among those that sheets have at a cell, but for full turns of hinges; NULL: it isn't. */
km_known_configuration *km_map_find_known(const km_map_search *g, int cell);
/* Notes the state's configuration among those of a cell. False when out of memory. */
bool km_map_note_configuration(km_map_search *g, int cell);
/* Checks axes and point. KM_USAGE. */
km_status km_map_check_definition(const km_mechanism *m, const km_space_map_def *def, km_error *error);
/* Adds the tables' columns. False when out of memory. */
bool km_map_add_columns(km_map_search *g);
/* Fills the row of the present cell, its aspect left open. N: tangents there. *output_sign: that of det D. False: the
 * caller ends the map, or out of memory. */
bool km_map_fill_row(km_map_search *g, int cell, int sheet, const double *N, int *output_sign);

#endif
