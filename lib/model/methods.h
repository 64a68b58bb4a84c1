/* The methods of path studies as data: their words, and their settings with the ranges in which they work. */
#ifndef KM_MODEL_METHODS_H
#define KM_MODEL_METHODS_H

#include "base/text.h"
#include "kmech/track.h"

/* The default method of a word. KM_USAGE: there is none of that name; `out` is then greedy. */
km_status km_method_of_word(const char *word, km_method *out, km_error *error);

/* Has a method a setting of that name; and which methods have ("dp, global"; nothing: it is no setting)? */
bool km_method_has(km_method_kind kind, const char *key);
void km_method_owners(const char *key, km_text *out);

/* The settings that are numbers, as a study writes them: angles in degrees. */
int km_method_setting_count(void);
const char *km_method_setting(int index);
/* KM_USAGE: the value is out of the setting's range; the method stays as it is. */
km_status km_method_set(km_method *method, const char *key, double value, km_error *error);
/* What a leaf of look-ahead counts: "min" or "sum". KM_USAGE: another word. */
km_status km_method_set_leaf(km_method *method, const char *word, km_error *error);

/* KM_USAGE: a setting is out of its range, or doesn't fit the others; *key is then the setting. */
km_status km_method_check(const km_method *method, const char **key, km_error *error);

#endif
