/* Cycles of loads and drivers, and the speed of a driver over its last cycle (docs/theory.md 11.11).
 *
 *   P      longest period of the laws over a coordinate, such as 4π of a four-stroke engine; else a turn of a hinge
 *   t0     time at which |q(T) − q(t0)| = P; the start where q moves by less. T: end
 *   mean = (q(T) − q(t0)) / (T − t0)
 *   δ    = (max v − min v) / |mean|     coefficient of fluctuation (Norton, Design of Machinery, 11.11)
 *
 * Between rows q is the cubic Hermite polynomial of q and v; max and min are those of the rows. */
#ifndef KM_HISTORY_MOTION_CYCLE_H
#define KM_HISTORY_MOTION_CYCLE_H

#include "base/table.h"
#include "kmech/dynamics.h"

/* The longest time that the model's periodic loads and force modules need for one period, model's time unit: over time,
 * and over coordinates with a rate, which is that of `rates` or else the model's initial one. *over_joint: true if one
 * is over a coordinate. 0: no law is periodic. */
double km_longest_period(const km_model *model, const km_constant_rate *rates, int rate_count, bool *over_joint);
/* As km_history_default, for initial rates that replace the model's. */
km_history_def km_history_default_at(const km_model *model, const km_constant_rate *rates, int rate_count);

/* Coordinate that drives a motion over time: the first that is prescribed, else the first hinge on the ground that
 * turns by at least one turn without a stop. −1: none. */
int km_history_driver(const km_mechanism *mechanism, const km_table *table);
/* Value of a coordinate between rows, its file's unit. */
double km_history_value(const km_table *table, int coordinate, double time);

/* Speed over the last cycle; rates in the coordinate's unit per time unit. */
typedef struct km_driver_speed {
  int coordinate;
  double cycle; /* length of the cycle, the coordinate's unit */
  double from;  /* time at which it begins */
  double mean, least, greatest, fluctuation;
  double least_at, greatest_at; /* values of the coordinate there */
} km_driver_speed;

/* False: no coordinate drives the motion, it isn't a hinge, it moves by less than a turn, or its rate changes sign. */
bool km_driver_speed_find(const km_mechanism *mechanism, const km_table *table, km_driver_speed *out);

#endif
