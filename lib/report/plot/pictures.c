/* Answers as pictures, for programs. */
#include "kmech/pictures.h"

#include "analysis/question.h"
#include "base/check.h"
#include "report/plot/question_plot.h"
#include "report/plot/track_plot.h"

_Static_assert((int)KM_PICTURE_SVG == (int)KM_CANVAS_SVG && (int)KM_PICTURE_PDF == (int)KM_CANVAS_PDF &&
                   (int)KM_PICTURE_PNG == (int)KM_CANVAS_PNG,
               "formats of pictures stand in the order of those of canvases");

static km_status check(const char *name, km_picture_format format, km_bytes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_bytes){0};
  if ((int)format < KM_PICTURE_SVG || (int)format > KM_PICTURE_PNG)
    return km_fail(error, KM_USAGE, "found no format of pictures; expected SVG, PDF or PNG");
  return km_check_given(name != NULL, "name", error);
}

/* Hands over what was drawn. */
static km_status deliver(km_status status, km_text *text, km_bytes *out, km_error *error) {
  if (!status)
    return km_text_give(text, out, error);
  km_text_free(text);
  return status;
}

km_status km_question_picture(const km_question *question, const char *name, km_picture_format format, km_bytes *out,
                              km_error *error) {
  km_text text = {0};
  km_status status = check(name, format, out, error);
  if (!status)
    status = km_check_given(km_question_table(question) != NULL, "answer to draw", error);
  if (status)
    return status;
  km_answered answer = {.mechanism = question->m, .question = question, .name = name};
  status = km_question_plot(&(km_comparison){&answer, 1, false}, (km_canvas_format)format, &text, error);
  return deliver(status, &text, out, error);
}

km_status km_track_picture(const km_study *study, km_track *track, const char *name, km_picture_format format,
                           km_bytes *out, km_error *error) {
  km_text text = {0};
  km_status status = check(name, format, out, error);
  if (!status)
    status = km_check_given(study && track, "study or track", error);
  if (status)
    return status;
  km_tracks tracks = {study, name, name, &track, 1};
  status = km_tracks_plot(&tracks, (km_canvas_format)format, &text, error);
  return deliver(status, &text, out, error);
}
