/* All solutions over one value of the parameters, by monodromy on a graph (docs/theory.md 4.15).
 *
 *   node  : parameters P_k with the solutions that are known there; the caller begins node 0
 *   edge  : the straight path between two nodes; each solution is tracked along each edge once
 *   node k is joined to the last 6 nodes before it; a triangle of edges is a closed path
 *
 * The solutions of H(x, P) = 0 form an irreducible set, so that closed paths permute them transitively. The search is
 * quiet after nodes that brought no further solution; that is no proof (trace_test.h). Source: T. Duff, C. Hill,
 * A. Jensen, K. Lee, A. Leykin, J. Sommars, Solving polynomial systems via homotopy continuation and monodromy,
 * IMA J. Numerical Analysis 39, 2019. */
#ifndef KM_SPACE_COMPLEX_MONODROMY_H
#define KM_SPACE_COMPLEX_MONODROMY_H

#include "space/complex/homotopy.h"

#include "kmech/base.h"

/* Solutions at one value of the parameters. */
typedef struct km_fibre {
  km_complex *parameters;
  km_wide *points;   /* [count × length] */
  km_complex *marks; /* [count × KM_FINGERPRINT] fingerprints of the points */
  size_t point_capacity, mark_capacity;
  int count;
} km_fibre;

enum { KM_UNTRACKED = -1, KM_UNTRACKABLE = -2 };

/* Partners of the solutions of both ends of an edge. */
typedef struct km_fibre_edge {
  int node[2];
  int *partner[2]; /* [count of the node] index at the other node, KM_UNTRACKED, or KM_UNTRACKABLE */
  size_t capacity[2];
  int length[2]; /* entries of partner */
} km_fibre_edge;

enum { KM_MAX_NODES = 64, KM_NODE_EDGES = 6 };

typedef struct km_monodromy {
  km_homotopy *h;
  uint64_t *random;
  km_fibre node[KM_MAX_NODES];
  km_fibre_edge edge[KM_NODE_EDGES * KM_MAX_NODES];
  int node_count, edge_count;
  int limit;  /* largest number of solutions */
  long paths; /* number of tracked paths */
  km_progress progress;
  void *context;
  bool is_exhausted;      /* more solutions, or more work, than is allowed */
  bool failed, cancelled; /* out of memory; cancelled by the caller */
} km_monodromy;

/* Adds a solution unless it is known. Returns its index, −1 when out of memory. */
int km_fibre_add(km_monodromy *g, km_fibre *fibre, const km_wide *x);
/* Index of the solution with the bodies' poses of x, and with its s on a section; −1: none. */
int km_fibre_find(const km_monodromy *g, const km_fibre *fibre, const km_wide *x);

/* Adds nodes and tracks all solutions along all edges. False: out of memory, cancelled, or more than `limit`
 * solutions. */
bool km_monodromy_extend(km_monodromy *g, int nodes);
/* Adds a node at given parameters with an edge to node 0, and further ones while it has fewer solutions than node 0.
 * Returns its index; −1: as false of km_monodromy_extend. */
int km_monodromy_add(km_monodromy *g, const km_complex *parameters);
/* Index at a node of the solution to which solution i of node 0 leads along their edge; negative: none. */
int km_monodromy_partner(const km_monodromy *g, int i, int node);
/* Adds nodes until `quiet` of them in turn brought no further solution to node 0. The caller has set the parameters
 * and at least one solution of node 0. False as km_monodromy_extend. */
bool km_monodromy_search(km_monodromy *g, int quiet);
/* Makes the node with the most solutions node 0: solutions of another one may be lost beside poles. */
void km_monodromy_choose_first(km_monodromy *g);
/* Tracks x along a straight path, again with shorter steps where it is lost. */
km_path_outcome km_monodromy_track(km_monodromy *g, const km_complex *from, const km_complex *to, km_wide *x);
void km_monodromy_free(km_monodromy *g);

#endif
