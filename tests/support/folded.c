/* The chain of support/chains.h, with all coordinates at 0. */
#include "support/folded.h"

#include "support/chains.h"

#include "base/memory.h"

fixture folded_chain(int n) {
  fixture f = fixture_written(write_chain, n);
  double *zero = KM_NEW(double, (size_t)f.mechanism->coordinate_count);
  assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, zero, NULL), KM_OK);
  km_free(zero);
  return f;
}
