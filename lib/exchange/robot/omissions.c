/* Counts omitted elements, and reports them by kind. */
#include "exchange/robot/omissions.h"

#include <stdbool.h>
#include <string.h>

void km_omissions_add(km_omissions *o, const char *kind, const char *name) {
  int k = 0;
  while (k < o->count && strcmp(o->items[k].kind, kind) != 0)
    k++;
  if (k == KM_MAX_OMISSIONS)
    return;
  if (k == o->count)
    o->items[o->count++] = (km_omission){kind, name ? name : "", 0};
  o->items[k].count++;
}

void km_omissions_report(const km_omissions *o, km_messages *messages) {
  for (int k = 0; k < o->count; ++k) {
    const km_omission *item = &o->items[k];
    bool named = item->first[0] != '\0';
    km_messages_add(messages, KM_NOTE, "%s: %d%s%.80s%s", item->kind, item->count,
                    named ? (item->count > 1 ? ", the first is \"" : ", \"") : "", item->first, named ? "\"" : "");
  }
}
