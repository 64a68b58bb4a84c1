/* Long chains of loops. */
#include "support/chains.h"

void write_separate(km_text *t, int n) {
  km_text_add(t, "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [0.4, 0, 0]}]}, \"assemblies\": [");
  for (int i = 0; i < n; ++i)
    km_text_format(
        t,
        "%s{\"name\": \"n%d\", \"bodies\": [{\"name\": \"l\", \"frames\": [{\"name\": \"t\", \"T\": [0.15, 0, 0]}]},"
        "{\"name\": \"c\", \"frames\": [{\"name\": \"t\", \"T\": [0.5, 0, 0]}]},"
        "{\"name\": \"r\", \"frames\": [{\"name\": \"t\", \"T\": [0.45, 0, 0]}]}], \"joints\": ["
        "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"l\"], \"initial_displacement\": "
        "1.5707963267948966},"
        "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l\", \"t\"], \"c\"], \"initial_displacement\": "
        "-0.9272952180016122},"
        "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c\", \"t\"], [\"r\", \"t\"]], "
        "\"initial_displacement\": 0.9272952180016122},"
        "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"r\"], "
        "\"initial_displacement\": 1.5707963267948966}]}",
        i ? ", " : "", i);
  km_text_add(t, "]}");
}

void write_chain(km_text *t, int n) {
  km_text_add(t, "{\"fixed\": {\"frames\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t, "%s{\"name\": \"p%d\", \"T\": [%d, 0, 0]}", i ? ", " : "", i, 2 * i);
  km_text_add(t, "]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t,
                   "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}, {\"name\": \"c%d\", "
                   "\"frames\": [{\"name\": \"t\", \"T\": [2, 0, 0]}]}",
                   i ? ", " : "", i, i);
  km_text_add(t, "], \"joints\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t,
                   "%s{\"name\": \"P%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p%d\"], \"b%d\"], "
                   "\"initial_displacement\": 1},"
                   "{\"name\": \"Q%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b%d\", \"t\"], \"c%d\"], "
                   "\"initial_displacement\": -1}",
                   i ? ", " : "", i, i, i, i, i, i);
  for (int i = 0; i < n; ++i)
    km_text_format(t,
                   ", {\"name\": \"R%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c%d\", \"t\"], [\"b%d\", "
                   "\"t\"]], \"initial_displacement\": 1}",
                   i, i, i + 1);
  km_text_add(t, "]}]}");
}
