/* Configurations and evaluation of the complex closure system (complex_closure.h). */
#include "space/complex/complex_closure.h"

#include "space/complex/complex_chain.h"

#include <string.h>

/* ---- Configurations. */

/* Quaternion of a ball from the frame before it to that behind it. It is inverted if the joint is reversed. */
static km_quaternion oriented(km_quaternion Q, double sign) {
  return (km_quaternion){Q.w, sign * Q.x, sign * Q.y, sign * Q.z};
}

void km_complex_from_state(const km_complex_closure *c, const km_state *s, km_wide *x) {
  for (int k = 0; k < c->sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[c->sub->column_start + k];
    if (km_complex_begins_ball(c, k)) {
      km_complex_set_quaternion(oriented(s->ball[c->m->ball_of[coordinate]], c->hub[k].ball->sign), &x[c->start_of[k]]);
    } else if (!km_complex_is_ball(c, k)) {
      x[c->start_of[k]] = s->q[coordinate] / c->m->unit[coordinate];
    }
  }
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->hub[k].count > 0)
      km_complex_set_quaternion(km_complex_hub_quaternion(c, k, x), &x[c->start_of[k]]);
}

/* Sets the joints that close loops. */
static void set_closing_joints(const km_complex_closure *c, km_wide *x) {
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      int place = program->loop_start + j, step = c->closing_step[place - c->sub->loop_start];
      const km_loop *loop = &c->m->loops[c->m->loop_order[place]];
      if (step >= 0)
        (program->planar ? km_complex_close_planar : km_complex_close_spatial)(c, program, loop, step, x);
    }
  }
}

static double real_part(km_wide z) {
  return (double)creall(z);
}

void km_complex_to_state(const km_complex_closure *c, km_wide *x, km_state *s) {
  set_closing_joints(c, x);
  for (int k = 0; k < c->sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[c->sub->column_start + k];
    const km_wide *number = &x[c->start_of[k]];
    if (s->locked[coordinate])
      continue;
    if (km_complex_begins_ball(c, k)) {
      km_quaternion Q = {real_part(number[0]), real_part(number[1]), real_part(number[2]), real_part(number[3])};
      if (c->hub[k].count > 0)
        Q = km_complex_ball_quaternion(c, k, x);
      km_state_set_ball(c->m, s, c->m->ball_of[coordinate], oriented(Q, c->hub[k].ball->sign));
    } else if (!km_complex_is_ball(c, k)) {
      s->q[coordinate] =
          c->m->unit[coordinate] *
          (km_coordinate_turns(c->m, coordinate) ? remainder(real_part(*number), 2.0 * M_PI) : real_part(*number));
    }
  }
}

/* True if `column` is the first one of a ball whose quaternion changes. */
static bool begins_moving_ball(const km_complex_closure *c, int column) {
  return c->hub[column].ball && (c->hub[column].count > 0 || c->unknown_of[column] >= 0 ||
                                 c->unknown_of[column + 1] >= 0 || c->unknown_of[column + 2] >= 0);
}

void km_complex_normalise(const km_complex_closure *c, km_wide *x) {
  for (int k = 0; k < c->sub->columns; ++k)
    if (begins_moving_ball(c, k)) {
      km_wide *Q = &x[c->start_of[k]];
      km_wide share = 1.0L / csqrtl(Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3]);
      for (int i = 0; i < 4; ++i)
        Q[i] *= share;
    }
}

/* Q̇ = ½ ω Q of the ball at a configuration's numbers Q, ω along the parent frame's axes. */
static void quaternion_rate(const km_wide *Q, const km_complex *w, km_complex *out) {
  km_wide r[4] = {-w[0] * Q[1] - w[1] * Q[2] - w[2] * Q[3], w[0] * Q[0] + w[1] * Q[3] - w[2] * Q[2],
                  w[1] * Q[0] + w[2] * Q[1] - w[0] * Q[3], w[2] * Q[0] + w[0] * Q[2] - w[1] * Q[1]};
  for (int i = 0; i < 4; ++i)
    out[i] = (km_complex)(0.5L * r[i]);
}

void km_complex_rate(const km_complex_closure *c, const km_wide *x, const km_complex *rates, km_complex *out) {
  memset(out, 0, (size_t)c->length * sizeof *out);
  for (int k = 0; k < c->sub->columns; ++k) {
    km_complex w[3];
    if (begins_moving_ball(c, k)) {
      km_complex_hub_velocity(c, k, x, rates, w);
      quaternion_rate(&x[c->start_of[k]], w, &out[c->start_of[k]]);
    } else if (!km_complex_is_ball(c, k) && c->unknown_of[k] >= 0) {
      out[c->start_of[k]] = rates[c->unknown_of[k]];
    }
  }
}

static double square(km_complex z) {
  return creal(z) * creal(z) + cimag(z) * cimag(z);
}

/* Size of a rate of the numbers at a configuration. */
static double rate_size(const km_complex_closure *c, const km_complex *rate, const km_wide *x) {
  double largest = 0.0; /* squared */
  for (int k = 0; k < c->sub->columns; ++k) {
    const km_complex *own = &rate[c->start_of[k]];
    double size = km_complex_is_ball(c, k) ? 0.0 : square(own[0]);
    if (begins_moving_ball(c, k)) {
      double change = 0.0, length = 0.0;
      for (int i = 0; i < 4; ++i) {
        change += square(own[i]);
        length += square((km_complex)x[c->start_of[k] + i]);
      }
      size = 4.0 * change / length;
    }
    largest = size > largest || isnan(size) ? size : largest;
  }
  return sqrt(largest);
}

double km_complex_move(const km_complex_closure *c, const km_complex *step, km_wide *x) {
  km_complex_rate(c, x, step, c->rate);
  double size = rate_size(c, c->rate, x);
  for (int i = 0; i < c->length; ++i)
    x[i] += c->rate[i];
  km_complex_normalise(c, x);
  return size;
}

void km_complex_randomise(const km_complex_closure *c, const km_wide *centre, double distance, uint64_t *random,
                          km_wide *x) {
  memmove(x, centre, (size_t)c->length * sizeof *x);
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->unknown_of[k] >= 0)
      c->step[c->unknown_of[k]] = distance * km_complex_random(random);
  km_complex_move(c, c->step, x);
}

/* ---- Evaluation. */

/* Coefficients of one program, whose first step is the `step`-th one of all. */
static km_program_weight weight_of_program(const km_complex_closure *c, int functional, const km_program *program,
                                           int step) {
  const km_slot_weight *all = c->weight[functional];
  return (km_program_weight){all + step, all + c->end_start + 2 * (program->loop_start - c->sub->loop_start)};
}

void km_complex_evaluate(const km_complex_closure *c, const km_wide *x, km_complex_values *out) {
  bool has_functional = out->functional >= 0;
  int rows = 0, columns = 0;
  for (int k = 0; k < c->sub->columns; ++k)
    columns += c->unknown_of[k] >= 0;
  for (int r = 0; r < c->sub->rows; ++r)
    rows += c->equation_of[r] >= 0;
  for (int r = 0; out->J && r < rows; ++r)
    memset(out->J + r * out->stride, 0, (size_t)columns * sizeof *out->J);
  out->value = 0.0;
  if (has_functional && out->gradient)
    memset(out->gradient, 0, (size_t)columns * sizeof *out->gradient);
  for (int i = 0, step = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    km_program_weight weight =
        has_functional ? weight_of_program(c, out->functional, program, step) : (km_program_weight){NULL, NULL};
    if (program->planar)
      km_complex_planar(c, program, x, weight, out);
    else
      km_complex_spatial(c, program, x, weight, out);
    step += program->step_count;
  }
}

void km_complex_fingerprint(const km_complex_closure *c, const km_wide *x, km_complex *y) {
  for (int k = 0; k < KM_FINGERPRINT; ++k) {
    km_complex_values values = {.functional = k};
    km_complex_evaluate(c, x, &values);
    y[k] = values.value;
  }
}

km_complex_extent km_complex_pose_extent(const km_complex_closure *c, const km_wide *x) {
  km_complex_extent extent = {0.0, 0.0};
  for (int i = 0, step = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    (program->planar ? km_complex_planar_extent
                     : km_complex_spatial_extent)(c, program, x, weight_of_program(c, 0, program, step), &extent);
    step += program->step_count;
  }
  return extent;
}

km_complex km_complex_trace(const km_complex_closure *c, const km_wide *x) {
  km_complex_values values = {.functional = KM_TRACE};
  km_complex_evaluate(c, x, &values);
  return values.value;
}

bool km_complex_is_same_mode(const km_complex_closure *c, const km_wide *x, const km_wide *other, double tolerance) {
  km_complex y[2][KM_FINGERPRINT];
  km_complex_fingerprint(c, x, y[0]);
  km_complex_fingerprint(c, other, y[1]);
  for (int k = 0; k < KM_FINGERPRINT; ++k)
    if (!(cabs(y[0][k] - y[1][k]) <= tolerance * (1.0 + cabs(y[0][k]))))
      return false;
  return true;
}
