/* Restricts OpenMP to the calling thread. CHOLMOD uses four threads in blocks of 64 rows, which wait for each other
 * longer than they compute, and a study has a worker on every core already. Private to linalg/. */
#ifndef KM_LINALG_SPARSE_OPENMP_THREADS_H
#define KM_LINALG_SPARSE_OPENMP_THREADS_H

/* Makes parallel regions of this thread run on it alone until km_openmp_single_thread_end, which needs the returned
 * value. */
int km_openmp_single_thread_begin(void);
void km_openmp_single_thread_end(int levels);

#endif
