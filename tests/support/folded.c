/* The chain of support/chains.h, with all coordinates at 0. */
#include "support/folded.h"

#include "support/chains.h"

#include "base/memory.h"

fixture folded_chain(int n) {
  km_text text = {0};
  write_chain(&text, n);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  double *zero = KM_NEW(double, (size_t)f.mechanism->coordinate_count);
  assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, zero, NULL), KM_OK);
  km_free(zero);
  return f;
}
