/* kredund track: follows a path. */
#include "kredund/tracks.h"

kt_exit kredund_track(int argc, char **argv) {
  kredund_request request = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  kt_formats formats;
  const kt_option table[] = {
      {"animate", 0, NULL, "Write the arm along its path as a page for the browser, too: BASE.motion.html", KT_FLAG,
       &request.animate, KT_ABOUT_FILES},
  };
  KT_OPTIONS_ADD(&all, table);
  if (!kredund_tracks_read(&all, "Follows an effector path with a redundant arm, by one or more methods.", argc, argv,
                           &request, &formats))
    return KT_USAGE;
  return kredund_tracks_command(&request, formats, false);
}
