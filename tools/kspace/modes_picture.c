/* Picture of kspace modes: a small drawing of each mode, circuits in colours. */
#include "kspace/modes_answer.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/report.h"

/* Writes the drawings of all modes: circuit, mobility number of the driver and leverage below each. */
km_status kspace_add_picture(const kspace_modes_answer *a, km_text *out, km_arena *arena, km_error *error) {
  int count = a->modes.count, coordinates = km_model_coordinate_count(a->pose->model);
  km_gallery_caption *captions = KM_ARENA_NEW(arena, km_gallery_caption, (size_t)count + 1);
  km_text title = {0}, name = {0}, words = {0};
  km_text_format(&title, "%d assembly mode%s", count, count == 1 ? "" : "s");
  if (a->circuits.count > 0)
    km_text_format(&title, " in %d circuit%s", a->circuits.count, a->circuits.count == 1 ? "" : "s");
  km_text_add(&name, a->o->model);
  kspace_print_locked(a, &name);
  for (int i = 0; captions && i < count; ++i) {
    words.size = 0;
    km_text_format(&words, "%d", i + 1);
    if (a->circuits.count > 0)
      km_text_format(&words, " · circuit %d", a->circuits.circuit[i]);
    captions[i].title = words.data ? km_arena_string(arena, words.data) : NULL;
    captions[i].group = a->circuits.count > 0 ? a->circuits.circuit[i] : 0;
    words.size = 0;
    km_text_format(&words, "mobility %d", a->modes.evidence[i].mobility);
    if (a->locked_count > 0)
      km_text_format(&words, " · m(%s) %.3g", km_model_coordinate_label(a->pose->model, a->locked[0]),
                     a->modes.mobility_numbers[i * coordinates + a->locked[0]]);
    if (a->has_leverage) {
      km_text_add(&words, " · leverage ");
      kspace_print_leverage(a, i, &words);
    }
    captions[i].text = words.data ? km_arena_string(arena, words.data) : NULL;
  }
  const km_picture_format format = a->o->format == KSPACE_PDF   ? KM_PICTURE_PDF
                                   : a->o->format == KSPACE_PNG ? KM_PICTURE_PNG
                                                                : KM_PICTURE_SVG;
  km_status status = KM_OK;
  if (!captions || arena->failed || title.failed || name.failed || words.failed)
    status = km_fail(error, KM_MEMORY, "out of memory for the drawings");
  else
    status = km_drawing_gallery(a->drawing, &(km_drawing_look){.title = title.data, .name = name.data}, captions,
                                format, out, error);
  km_text_free(&title);
  km_text_free(&name);
  km_text_free(&words);
  return status;
}
