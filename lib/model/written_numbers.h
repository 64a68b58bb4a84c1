/* Numbers of a file that place frames, as they are written, and the change of a frame that each of them causes. Files
 * round them; rounding/ finds how far the numbers of a movable mechanism are from those written.
 *
 *   dT = move dp      dR = [turn]x R dp      T, R: pose of the frame in its body; p: the number */
#ifndef KM_MODEL_WRITTEN_NUMBERS_H
#define KM_MODEL_WRITTEN_NUMBERS_H

#include "model/model.h"

/* A number of a file. */
struct km_written_number {
  int frame[2];    /* frames that it places; the second one is -1 unless a point of a drawing places two */
  const char *key; /* "T", "R", "at" …, static */
  int index;       /* index in the list of that key, by rows; -1: the file states it in another form */
  double value;    /* value as written, in the file's unit; NaN: the file states it in another form */
  double half;     /* half a unit of its last digit; 0: that of `value` */
  km_vec3 move;    /* per unit of the number, in the body's axes */
  km_vec3 turn;    /* radians per unit of the number, in the body's axes */
};

/* Adds a number. The model's arena fails when out of memory. */
void km_model_add_written(km_model *model, const km_written_number *number);
/* Half a unit of the last digit of the shortest decimal number that equals x; *digits: number of its digits between
 * the first and the last that isn't 0 (0 for x = 0). */
double km_half_digit(double x, int *digits);

#endif
