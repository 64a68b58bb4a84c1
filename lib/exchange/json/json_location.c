#include "exchange/json/json_location.h"

#include <stdio.h>
#include <string.h>

static size_t append(const km_place *place, char *out) {
  size_t used = place->parent ? append(place->parent, out) : 0;
  size_t room = KM_PLACE_TEXT - used;
  int length = place->key ? snprintf(out + used, room, "%s%s", used ? "." : "", place->key)
                          : snprintf(out + used, room, "[%zu]", place->index);
  size_t wanted = length > 0 ? (size_t)length : 0;
  return used + (wanted < room ? wanted : room - 1);
}

const char *km_place_text(const km_place *place, char out[KM_PLACE_TEXT]) {
  out[0] = '\0';
  if (place)
    append(place, out);
  if (!out[0])
    strcpy(out, "the file");
  return out;
}
