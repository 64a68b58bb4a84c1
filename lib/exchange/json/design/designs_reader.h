/* Reader of studies of designs. Private to exchange/json/design. */
#ifndef KM_EXCHANGE_JSON_DESIGN_DESIGNS_READER_H
#define KM_EXCHANGE_JSON_DESIGN_DESIGNS_READER_H

#include "base/memory.h"
#include "base/value.h"
#include "exchange/json/format/format.h"
#include "kmech/study.h"

typedef struct km_designs_reader {
  km_design_study_def *def;
  km_design_parameter *parameters; /* the definition's */
  km_arena *arena;
  km_messages *messages;
  bool too_many; /* parameters */
} km_designs_reader;

/* The index of a parameter by its name; a name that isn't declared is its own path. */
int km_designs_parameter(km_designs_reader *reader, const char *name);
void km_designs_error(km_designs_reader *reader, const km_place *place, const char *what);
/* Members of a checked object. */
int km_designs_whole(km_designs_reader *reader, const km_value *object, const km_place *place, const char *key,
                     int otherwise);
double km_designs_number(const km_value *object, const char *key, double otherwise);
const char *km_designs_text(const km_value *object, const char *key);
const char *const *km_designs_texts(km_designs_reader *reader, const km_value *value, int *count);

void km_designs_read_sample(km_designs_reader *reader, const km_value *object);
void km_designs_read_optimise(km_designs_reader *reader, const km_value *object);
void km_designs_read_questions(km_designs_reader *reader, const km_value *list);

#endif
