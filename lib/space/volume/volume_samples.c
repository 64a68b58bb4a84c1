/* The samples of a workspace's box, decided in rounds (docs/theory.md 4.23).
 *
 *   starts of a sample's attempts in a round: the two nearest known configurations, the nearest of the first ones, and
 *   one by chance; each once. Samples with KM_VOLUME_ATTEMPTS blocked attempts begin at a nearer one only.
 *   A round knows the configurations of the rounds before, so that the result doesn't depend on threads. */
#include "space/volume/volume_search.h"

#include "base/random.h"

#include <stdlib.h>
#include <string.h>

enum { STARTS = 4 };

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the samples");
}

/* ---- The nearest known configurations. */

static int compare_places(const void *a, const void *b) {
  const km_known_place *p = a, *q = b;
  return p->x < q->x ? -1 : p->x > q->x ? 1 : p->index - q->index;
}

static bool sort_known(km_volume_search *g) {
  void *order = g->order;
  bool is_ok = km_reserve(&order, &g->order_capacity, (size_t)g->known_count, sizeof *g->order);
  g->order = order;
  for (int i = 0; is_ok && i < g->known_count; ++i)
    g->order[i] = (km_known_place){g->known[i].x[0], i};
  g->order_count = is_ok ? g->known_count : 0;
  if (is_ok)
    qsort(g->order, (size_t)g->order_count, sizeof *g->order, compare_places);
  return is_ok;
}

static bool is_tried(const km_volume_sample *sample, int known) {
  for (int i = 0; i < sample->attempts; ++i)
    if (sample->tried[i] == known)
      return true;
  return false;
}

static double distance(const km_volume_search *g, const double *a, const double *b) {
  double square = 0.0;
  for (int k = 0; k < g->out->dimension; ++k)
    square += (a[k] - b[k]) * (a[k] - b[k]);
  return sqrt(square);
}

/* First place in the order whose x isn't less. */
static int first_place(const km_volume_search *g, double x) {
  int low = 0, high = g->order_count;
  while (low < high) {
    int middle = (low + high) / 2;
    if (g->order[middle].x < x)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* The nearest known configuration that the sample hasn't tried, or of the first ones; −1: none nearer than *least. */
static int nearest(const km_volume_search *g, const km_volume_sample *sample, bool is_start, double *least) {
  int above = first_place(g, sample->x[0]), below = above - 1, found = -1;
  while (below >= 0 || above < g->order_count) {
    double down = below >= 0 ? sample->x[0] - g->order[below].x : HUGE_VAL;
    double up = above < g->order_count ? g->order[above].x - sample->x[0] : HUGE_VAL;
    if (fmin(down, up) >= *least)
      break;
    int i = g->order[down <= up ? below-- : above++].index;
    double from = distance(g, sample->x, g->known[i].x);
    if (from < *least && (g->known[i].is_start || !is_start) && !is_tried(sample, i)) {
      *least = from;
      found = i;
    }
  }
  return found;
}

/* ---- Attempts. */

/* The start of a sample's next attempt in a round; −1: none. */
static int choose_start(const km_volume_search *g, const km_volume_sample *sample, int sample_index, int start) {
  double least = sample->blocked < KM_VOLUME_ATTEMPTS ? HUGE_VAL : sample->nearest_tried;
  if (start < STARTS - 1 || sample->blocked >= KM_VOLUME_ATTEMPTS)
    return nearest(g, sample, start == STARTS - 2 && sample->blocked < KM_VOLUME_ATTEMPTS, &least);
  uint64_t random = (uint64_t)g->def->seed + (uint64_t)sample_index * 0x9E3779B97F4A7C15u + (uint64_t)sample->attempts;
  int by_chance = (int)km_splitmix(&random, 0.0, g->order_count);
  return is_tried(sample, by_chance) ? -1 : by_chance;
}

static void attempt(const km_volume_search *g, km_moved_point *p, km_volume_sample *sample, int known, double *saved) {
  sample->tried[sample->attempts++] = known;
  sample->nearest_tried = fmin(sample->nearest_tried, distance(g, sample->x, g->known[known].x));
  km_moved_point_restore(p, g->known[known].saved);
  km_point_end end = km_moved_point_begin(p) ? km_moved_point_move_to(p, sample->x) : KM_POINT_UNSETTLED;
  sample->blocked += end == KM_POINT_BLOCKED;
  sample->is_reached = end == KM_POINT_REACHED;
  if (sample->is_reached)
    km_moved_point_save(p, saved);
}

/* The attempts of a round on every jobs-th open sample. */
static void attempt_share(void *context, int job) {
  km_volume_search *g = context;
  km_moved_point *p = &g->point[job];
  for (int i = job; i < g->share_count; i += g->jobs) {
    int index = g->open[g->share_first + i];
    km_volume_sample *sample = &g->samples[index];
    double *saved = g->saved + (size_t)index * p->saved_size;
    for (int start = 0; start < STARTS && !sample->is_reached && sample->attempts < KM_MOST_VOLUME_ATTEMPTS; ++start) {
      int known = choose_start(g, sample, index, start);
      if (known >= 0)
        attempt(g, p, sample, known, saved);
    }
  }
}

/* ---- Rounds. */

static void place_samples(km_volume_search *g) {
  const km_space_volume *out = g->out;
  for (int i = 0; i < out->samples; ++i) {
    uint64_t random = km_volume_random(g, i);
    g->samples[i] = (km_volume_sample){.nearest_tried = HUGE_VAL};
    for (int k = 0, cell = i / 2; k < out->dimension; ++k) {
      double width = (out->box_high[k] - out->box_low[k]) / out->cells[k];
      g->samples[i].x[k] = out->box_low[k] + width * (cell % out->cells[k] + km_splitmix(&random, 0.0, 1.0));
      cell /= out->cells[k];
    }
  }
}

/* Lists the samples that a round may reach; returns the attempts made so far. */
static long list_open(km_volume_search *g) {
  long attempts = 0;
  g->open_count = 0;
  for (int i = 0; i < g->out->samples; ++i) {
    attempts += g->samples[i].attempts;
    if (!g->samples[i].is_reached && g->samples[i].attempts < KM_MOST_VOLUME_ATTEMPTS)
      g->open[g->open_count++] = i;
  }
  return attempts;
}

/* Makes the attempts of a round, share by share. Each round is half of the progress that is left. KM_CANCELLED: the
 * caller ends them. */
static km_status attempt_round(km_volume_search *g, int round, km_error *error) {
  for (g->share_first = 0; g->share_first < g->open_count; g->share_first += g->share_count) {
    int left = g->open_count - g->share_first;
    g->share_count = left < KM_VOLUME_SHARE * g->jobs ? left : KM_VOLUME_SHARE * g->jobs;
    km_parallel_for(g->jobs, g->jobs, attempt_share, g);
    km_status status = km_volume_report(g, 1.0 - (1.0 - 0.5 * g->share_first / g->open_count) * pow(0.5, round), error);
    if (status)
      return status;
  }
  return KM_OK;
}

/* Adds the samples that a round has reached to the known configurations. */
static km_status add_reached(km_volume_search *g, km_error *error) {
  for (int i = 0; i < g->open_count; ++i) {
    int index = g->open[i];
    if (g->samples[index].is_reached &&
        !km_volume_add_known(g, g->samples[index].x, g->saved + (size_t)index * g->point[0].saved_size, false))
      return no_memory(error);
  }
  return KM_OK;
}

km_status km_volume_decide(km_volume_search *g, km_error *error) {
  km_status status = KM_OK;
  place_samples(g);
  long before = -1, attempts = list_open(g);
  for (int round = 0; !status && attempts > before; ++round) {
    before = attempts;
    status = sort_known(g) ? attempt_round(g, round, error) : no_memory(error);
    if (status != KM_MEMORY && add_reached(g, NULL))
      status = no_memory(error);
    attempts = list_open(g);
  }
  g->out->is_complete = !status && attempts == before;
  return status;
}
