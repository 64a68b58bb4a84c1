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
  struct argp argp = kredund_tracks_argp;
  argp.args_doc = "STUDY";
  argp.doc = "Follows an effector path with a redundant arm, by one or more methods.";
  kredund_request request;
  kt_formats formats;
  if (!kredund_tracks_read(&argp, argc, argv, &request, &formats))
    return KT_USAGE;
  return run(&request, formats);
}
