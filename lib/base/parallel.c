#include "base/parallel.h"

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

void km_serially(void (*work)(void *context), void *context) {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  work(context);
  pthread_mutex_unlock(&mutex);
}
