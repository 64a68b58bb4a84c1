/* A loop whose passes run on several threads. */
#include "base/parallel.h"

#include "base/memory.h"

#include <pthread.h>
#include <stdatomic.h>

enum { MOST_THREADS = 64 };

typedef struct queue {
  atomic_int next;
  int count;
  void (*work)(void *context, int index);
  void *context;
} queue;

static void *run(void *data) {
  queue *q = data;
  for (int i = atomic_fetch_add(&q->next, 1); i < q->count; i = atomic_fetch_add(&q->next, 1))
    q->work(q->context, i);
  return NULL;
}

void km_parallel_for(int count, int jobs, void (*work)(void *context, int index), void *context) {
  if (!work)
    return;
  queue q = {.count = count, .work = work, .context = context};
  pthread_t threads[MOST_THREADS];
  int started = 0;
  atomic_init(&q.next, 0);
  /* A thread that can't be had is no loss: the others do its work. */
  while (started + 1 < jobs && started + 1 < count && started < MOST_THREADS &&
         pthread_create(&threads[started], NULL, run, &q) == 0)
    ++started;
  run(&q);
  for (int i = 0; i < started; ++i)
    pthread_join(threads[i], NULL);
}

typedef struct member {
  struct km_team *team;
  int index;        /* that it takes first: what it worked on in the last round is in its processor's memory */
  atomic_bool held; /* that index, by this member or by another one that had nothing else to do */
  pthread_t thread;
} member;

/* A round has a number; who has seen it takes part once. Between rounds a thread watches for a moment, then sleeps. */
struct km_team {
  member members[MOST_THREADS + 1]; /* the first one is the caller */
  int started;
  pthread_mutex_t mutex;
  pthread_cond_t begins, ends;
  atomic_uint round;
  atomic_int busy; /* threads that haven't finished the round */
  bool over;
  queue work;
};

enum { WATCH = 6000 }; /* for less than 0.1 ms: longer than a level of a small tree takes */

static void breathe(void) {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/* Waits for a round other than `seen`; its number. */
static unsigned await_round(km_team *team, unsigned seen) {
  for (int i = 0; i < WATCH; ++i, breathe())
    if (atomic_load(&team->round) != seen)
      return atomic_load(&team->round);
  pthread_mutex_lock(&team->mutex);
  while (atomic_load(&team->round) == seen)
    pthread_cond_wait(&team->begins, &team->mutex);
  pthread_mutex_unlock(&team->mutex);
  return atomic_load(&team->round);
}

static void take(km_team *team, int index) {
  bool owned = index <= team->started;
  if (index < team->work.count && !(owned && atomic_exchange(&team->members[index].held, true)))
    team->work.work(team->work.context, index);
}

static void take_part(const member *m) {
  queue *q = &m->team->work;
  take(m->team, m->index);
  for (int i = atomic_fetch_add(&q->next, 1); i < q->count; i = atomic_fetch_add(&q->next, 1))
    take(m->team, i);
}

static void *stand_by(void *data) {
  member *own = data;
  km_team *team = own->team;
  for (unsigned seen = 0;;) {
    seen = await_round(team, seen);
    if (team->over)
      return NULL;
    take_part(own);
    if (atomic_fetch_sub(&team->busy, 1) != 1)
      continue;
    pthread_mutex_lock(&team->mutex);
    pthread_cond_signal(&team->ends);
    pthread_mutex_unlock(&team->mutex);
  }
}

km_team *km_team_create(int jobs) {
  km_team *team = KM_NEW(km_team, 1);
  if (!team)
    return NULL;
  pthread_mutex_init(&team->mutex, NULL);
  pthread_cond_init(&team->begins, NULL);
  pthread_cond_init(&team->ends, NULL);
  for (int i = 0; i <= MOST_THREADS; ++i) {
    team->members[i].team = team;
    team->members[i].index = i;
  }
  while (team->started + 1 < jobs && team->started < MOST_THREADS) {
    member *m = &team->members[team->started + 1];
    if (pthread_create(&m->thread, NULL, stand_by, m))
      break;
    ++team->started;
  }
  return team;
}

static void begin_round(km_team *team) {
  pthread_mutex_lock(&team->mutex);
  atomic_fetch_add(&team->round, 1);
  pthread_cond_broadcast(&team->begins);
  pthread_mutex_unlock(&team->mutex);
}

void km_team_free(km_team *team) {
  if (!team)
    return;
  team->over = true;
  begin_round(team);
  for (int i = 0; i < team->started; ++i)
    pthread_join(team->members[i + 1].thread, NULL);
  pthread_cond_destroy(&team->begins);
  pthread_cond_destroy(&team->ends);
  pthread_mutex_destroy(&team->mutex);
  km_free(team);
}

static void await_end(km_team *team) {
  for (int i = 0; i < WATCH; ++i, breathe())
    if (atomic_load(&team->busy) == 0)
      return;
  pthread_mutex_lock(&team->mutex);
  while (atomic_load(&team->busy) != 0)
    pthread_cond_wait(&team->ends, &team->mutex);
  pthread_mutex_unlock(&team->mutex);
}

void km_team_run(km_team *team, int count, void (*work)(void *context, int index), void *context) {
  if (!team || team->started == 0 || count < 2) {
    for (int i = 0; i < count; ++i)
      work(context, i);
    return;
  }
  team->work.count = count;
  team->work.work = work;
  team->work.context = context;
  for (int i = 0; i <= team->started; ++i)
    atomic_store(&team->members[i].held, false);
  atomic_store(&team->work.next, 0);
  atomic_store(&team->busy, team->started);
  begin_round(team);
  take_part(&team->members[0]);
  await_end(team);
}

void km_serially(void (*work)(void *context), void *context) {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  work(context);
  pthread_mutex_unlock(&mutex);
}

const void *km_thread_mark(void) {
  static _Thread_local char mark;
  return &mark;
}
