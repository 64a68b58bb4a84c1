/* A four-bar of crank 1, rocker 3 and ground 3.5, its coupler as long as asked for, as the text of a model. */
#ifndef FOURBAR_H
#define FOURBAR_H

#include <kmech/kmech.h>
#include <stdio.h>

static inline km_status fourbar_open(double coupler, km_model **model, km_error *error) {
  static const char format[] =
      "{\"fixed\": {\"frames\": [{\"name\": \"ground\", \"T\": [3.5, 0, 0]}]},"
      "\"assemblies\": [{\"name\": \"fourbar\", \"bodies\": ["
      "{\"name\": \"crank\", \"frames\": [{\"name\": \"tip\", \"T\": [1, 0, 0]}]},"
      "{\"name\": \"coupler\", \"frames\": [{\"name\": \"tip\", \"T\": [%.17g, 0, 0]}]},"
      "{\"name\": \"rocker\", \"frames\": [{\"name\": \"tip\", \"T\": [3, 0, 0]}]}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"crank\"], \"initial_displacement\": 1},"
      "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"tip\"], \"coupler\"],"
      " \"initial_displacement\": -0.4},"
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"coupler\", \"tip\"], [\"rocker\", \"tip\"]],"
      " \"initial_displacement\": 1.2},"
      "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"ground\"], \"rocker\"],"
      " \"initial_displacement\": 1.8}]}]}";
  char text[2048];
  int size = snprintf(text, sizeof text, format, coupler);
  return km_model_read(text, (size_t)size, NULL, model, error);
}

#endif
