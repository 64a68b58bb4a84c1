/* kredund track: follows a path. */
#include "kredund/tracks.h"

static kt_exit run(const kredund_request *request, kt_formats formats) {
  kredund_open open;
  kredund_tracks tracks = {.request = request, .open = &open, .formats = formats};
  kt_exit result = kredund_bring(request, true, &open);
  if (result == KT_DONE) {
    result = kredund_tracks_run(&tracks);
    if (result == KT_DONE || result == KT_PARTIAL)
      result = kt_worse(result, kredund_tracks_deliver(&tracks, request->base ? request->base : open.base));
  }
  kredund_tracks_free(&tracks);
  kredund_close(&open);
  return result;
}

kt_exit kredund_track(int argc, char **argv) {
  kredund_request request = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  kt_formats formats;
  if (!kredund_tracks_read(&all, "Follows an effector path with a redundant arm, by one or more methods.", argc, argv,
                           &request, &formats))
    return KT_USAGE;
  return run(&request, formats);
}
