/* A workspace while its size is found (docs/theory.md 4.23). */
#ifndef KM_SPACE_VOLUME_SEARCH_H
#define KM_SPACE_VOLUME_SEARCH_H

#include "space/volume/moved_point.h"

enum {
  KM_VOLUME_ATTEMPTS = 8,       /* that end where no motion brings the point nearer, for a sample that isn't reached */
  KM_MOST_VOLUME_ATTEMPTS = 24, /* most attempts of a sample */
  KM_VOLUME_SHARE = 16          /* samples or configurations of each thread from one report of progress to the next */
};

/* A known configuration. */
typedef struct km_known_point {
  double x[3];
  const double *saved;
  bool is_start; /* found by a random closure or motion, not for a sample */
} km_known_point;

/* A known configuration in the order of x[0]. */
typedef struct km_known_place {
  double x;
  int index;
} km_known_place;

/* A sample. */
typedef struct km_volume_sample {
  double x[3];
  bool is_reached;
  int attempts, blocked;              /* attempts so far, and those that ended where no motion brings it nearer */
  int tried[KM_MOST_VOLUME_ATTEMPTS]; /* known configurations from which they began */
  double nearest_tried;               /* least distance of their points */
} km_volume_sample;

typedef struct km_volume_search {
  const km_space_volume_def *def;
  km_space_volume *out;
  km_arena arena;
  int jobs;
  km_moved_point *point; /* [jobs] */
  double *home;          /* configuration of the caller's state */
  km_vec3 origin;        /* origin of the axes: 0, or the plane's point nearest to it */
  km_known_point *known; /* [known_count] */
  int known_count;
  size_t known_capacity;
  int rank;              /* largest rank of the point's motions so far */
  km_known_place *order; /* [order_count] those of the rounds before */
  int order_count;
  size_t order_capacity;
  km_volume_sample *samples;    /* [out->samples] */
  double low[3], high[3];       /* the box of all known configurations; that of the samples is out's */
  double *saved;                /* [sample][saved_size] configurations of those reached */
  int *open, open_count;        /* samples of the present round */
  int share_first, share_count; /* range of the present share in `open` */
  km_progress_stage stage;      /* the first configurations, then the samples of each box */
} km_volume_search;

/* Adds the configuration of a point. False when out of memory. */
bool km_volume_add_known(km_volume_search *g, const double *x, const double *saved, bool is_start);
/* Finds the first configurations by random closures, unless only the own circuit counts, and by motions from there; the
 * plane or space of the point; and the box. */
km_status km_volume_start(km_volume_search *g, const km_state *state, km_error *error);
/* State of the random numbers of closure, motion or sample `number`: each has its own sequence. */
static inline uint64_t km_volume_random(const km_volume_search *g, int number) {
  return (uint64_t)g->def->seed * 0x9E3779B97F4A7C15u + (uint64_t)number * 0xD1B54A32D192ED03u;
}

/* Moves along each axis from the configurations that are farthest there. *is_grown: the box was too small. KM_USAGE: it
 * has no end. KM_CANCELLED: *is_grown is as before. */
km_status km_volume_find_box(km_volume_search *g, bool *is_grown, km_error *error);
/* Reports progress of the present stage. KM_CANCELLED: the caller ends the work. */
km_status km_volume_report(km_volume_search *g, double done, km_error *error);
/* Decides the samples of the box. */
km_status km_volume_decide(km_volume_search *g, km_error *error);

#endif
