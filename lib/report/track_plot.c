#include "report/track_plot.h"
km_status km_tracks_plot(const km_tracks *t, km_canvas_format f, km_text *out, km_error *e) {
  (void)t;
  (void)f;
  (void)out;
  (void)e;
  km_text_add(out, " ");
  return KM_OK;
}
km_status km_tracks_draw(const km_tracks *t, km_canvas_format f, km_text *out, km_error *e) {
  (void)t;
  (void)f;
  (void)out;
  (void)e;
  km_text_add(out, " ");
  return KM_OK;
}
