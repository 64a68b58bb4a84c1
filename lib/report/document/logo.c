/* Logos of reports: PNG files that are checked before anything is computed. */
#include "base/arguments.h"
#include "kmech/report.h"
#include "report/canvas/png.h"

enum { MOST_BYTES = 4 << 20 }; /* a report holds them, and is to be sent on */

km_status km_logo_read(const char *file, km_text *out, km_error *error) {
  int width, height;
  km_status status = km_check_given(file && out, "file or place for the result", error);
  if (!status)
    status = km_file_read(file, out, error);
  if (status)
    return status;
  const char *fault = out->size > MOST_BYTES ? "it has more than 4 MB" : km_png_fault(out, &width, &height);
  if (!fault)
    return KM_OK;
  km_text_free(out);
  return km_fail(error, KM_USAGE, "logo %.300s: %s; expected a PNG file of at most 4096 pixels a side and 4 MB", file,
                 fault);
}
