/* kredund compare: comparison of methods. */
#include "kredund/tracks.h"

kt_exit kredund_compare(int argc, char **argv) {
  kredund_request request = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  kt_formats formats;
  if (!kredund_tracks_read(&all,
                           "Several methods on one path: their tracks, a table, and the map of self-motions with the "
                           "tracks on it. Without methods in the study: greedy, lookahead, fixed, dls, gradient, dp, "
                           "global.",
                           argc, argv, &request, &formats))
    return KT_USAGE;
  request.everything = true;
  return kredund_tracks_command(&request, formats, true);
}
