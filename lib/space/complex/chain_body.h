/* Chains of a spatial program for one type of numbers; complex_chain.c includes it once for each (no include guard).
 * NUMBER is the complex type, REAL that of its parts, NUMBER_OF(re, im) makes one, POSE has them; OF(name) is a name of
 * this type. Functions of <tgmath.h> follow the type. */

static const POSE OF(identity) = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};

/* out = R a; out may be a. */
static void OF(rotate)(NUMBER (*R)[3], const NUMBER *a, NUMBER *out) {
  NUMBER x = a[0], y = a[1], z = a[2];
  for (int k = 0; k < 3; ++k)
    out[k] = x * R[0][k] + y * R[1][k] + z * R[2][k];
}

/* out = Rᵀ a; out must not be a. */
static void OF(rotate_back)(NUMBER (*R)[3], const NUMBER *a, NUMBER *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = R[k][0] * a[0] + R[k][1] * a[1] + R[k][2] * a[2];
}

/* Row k of R. */
static void OF(row)(NUMBER (*R)[3], int k, NUMBER *out) {
  for (int j = 0; j < 3; ++j)
    out[j] = R[j][k];
}

static void OF(rotate_real)(NUMBER (*R)[3], km_vec3 a, NUMBER *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = a.x * R[0][k] + a.y * R[1][k] + a.z * R[2][k];
}

static void OF(narrow)(const NUMBER *a, km_complex *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = (km_complex)a[k];
}

/* X · Y for a real pose Y. */
static void OF(pose_product)(POSE *X, const km_pose *Y, bool has_rotation, POSE *out) {
  POSE r;
  for (int k = 0; k < 3; ++k)
    if (has_rotation)
      OF(rotate_real)(X->R, Y->R.axis[k], r.R[k]);
    else
      memcpy(r.R[k], X->R[k], sizeof r.R[k]);
  OF(rotate_real)(X->R, Y->p, r.p);
  for (int k = 0; k < 3; ++k)
    r.p[k] += X->p[k];
  *out = r;
}

/* Rotation of a quaternion. The formula is homogeneous in Q: the error of Q·Q, a difference of large parts beside a
 * pole, scales the rotation and doesn't distort it. */
static void OF(quaternion_rotation)(const NUMBER *Q, NUMBER R[3][3]) {
  NUMBER w = Q[0], x = Q[1], y = Q[2], z = Q[3];
  NUMBER ww = w * w, xx = x * x, yy = y * y, zz = z * z, share = (REAL)1 / (ww + xx + yy + zz), twice = 2 * share;
  const NUMBER r[3][3] = {
      {share * (ww + xx - yy - zz), twice * (x * y + w * z), twice * (z * x - w * y)},
      {twice * (x * y - w * z), share * (ww - xx + yy - zz), twice * (y * z + w * x)},
      {twice * (z * x + w * y), twice * (y * z - w * x), share * (ww - xx - yy + zz)},
  };
  memcpy(R, r, sizeof r);
}

/* Unit twist of a rotation about `axis` through p, times sign. */
static void OF(turning_twist)(double sign, const NUMBER *axis, const NUMBER *p, km_complex *h) {
  km_complex through[3];
  OF(narrow)(p, through);
  for (int k = 0; k < 3; ++k)
    h[3 + k] = (km_complex)(sign * axis[k]);
  km_complex_cross(through, h + 3, h);
}

/* Applies the motion of a hinge or slide to the pose of its frame and computes its unit twist. */
static void OF(apply_motion)(const km_complex_closure *c, const km_step *step, const km_wide *x, POSE *X,
                             km_complex *h) {
  NUMBER number = (NUMBER)x[c->start_of[km_complex_column(c, step->coordinate)]];
  const NUMBER *axis = X->R[step->axis];
  if (step->primitive == KM_PRISMATIC) {
    for (int k = 0; k < 3; ++k) {
      h[k] = (km_complex)(step->sign * axis[k]);
      h[3 + k] = 0.0;
      X->p[k] += number * (step->sign * axis[k]);
    }
    return;
  }
  OF(turning_twist)(step->sign, axis, X->p, h);
  REAL angle = step->sign * creal(number), growth = exp(-step->sign * cimag(number)), half = (REAL)0.5;
  REAL cosine = cos(angle), sine = sin(angle), sum = half * (growth + 1 / growth),
       difference = half * (growth - 1 / growth);
  NUMBER C = NUMBER_OF(sum * cosine, difference * sine), S = NUMBER_OF(sum * sine, -difference * cosine);
  NUMBER *u = X->R[(step->axis + 1) % 3], *v = X->R[(step->axis + 2) % 3];
  for (int k = 0; k < 3; ++k) {
    NUMBER uk = C * u[k] + S * v[k];
    v[k] = C * v[k] - S * u[k];
    u[k] = uk;
  }
}

/* The displacement T from a ball to its hub. w != NULL: adds the angular velocity of the hub relative to the ball's
 * body, at the rates of the unknowns, along the axes of that body. */
static POSE OF(hub_displacement)(const km_complex_closure *c, const km_complex_hub *hub, const km_wide *x,
                                 const km_complex *rates, km_complex *w) {
  POSE T = OF(identity);
  for (int i = 0; i < hub->count; ++i) {
    const km_step *step = hub->steps[i];
    int unknown = c->unknown_of[km_complex_column(c, step->coordinate)];
    km_complex h[6];
    OF(pose_product)(&T, &step->before, step->has_rotation, &T);
    OF(apply_motion)(c, step, x, &T, h);
    for (int k = 0; w && unknown >= 0 && k < 3; ++k)
      w[k] += rates[unknown] * h[3 + k];
  }
  return T;
}

/* Rotation R(Q) of the ball at `column`. */
static void OF(ball_rotation)(const km_complex_closure *c, int column, const km_wide *x, NUMBER R[3][3]) {
  NUMBER Q[4];
  for (int k = 0; k < 4; ++k)
    Q[k] = (NUMBER)x[c->start_of[column] + k];
  OF(quaternion_rotation)(Q, R);
}

/* Applies a ball's motion to the pose of its frame, computes its unit twists, and places its hub among the slots. */
static void OF(apply_ball)(const km_complex_closure *c, const km_step *step, const km_wide *x, POSE *slot, POSE *X,
                           km_complex (*h)[6]) {
  int column = km_complex_column(c, step->coordinate);
  const km_complex_hub *hub = &c->hub[column];
  NUMBER Q[3][3], R[3][3], row[3], u[3];
  for (int k = 0; k < 3; ++k)
    OF(turning_twist)(1.0, X->R[k], X->p, h[k]);
  OF(ball_rotation)(c, column, x, Q);
  for (int k = 0; k < 3; ++k)
    OF(rotate)(X->R, Q[k], R[k]);
  if (hub->count == 0) {
    memcpy(X->R, R, sizeof R);
    return;
  }
  POSE T = OF(hub_displacement)(c, hub, x, NULL, NULL), *at = &slot[hub->steps[hub->count - 1]->to];
  OF(rotate_back)(T.R, T.p, u);
  memcpy(at->R, R, sizeof R);
  OF(rotate)(R, u, at->p);
  for (int k = 0; k < 3; ++k) {
    OF(row)(T.R, k, row);
    OF(rotate)(R, row, X->R[k]);
    at->p[k] += X->p[k];
  }
}

static void OF(compute_slots)(const km_complex_closure *c, const km_program *program, const km_wide *x, POSE *slot) {
  slot[0] = OF(identity);
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &c->m->steps[program->step_start + i];
    POSE X;
    OF(pose_product)(&slot[step->from], &step->before, step->has_rotation, &X);
    if (step->primitive == KM_BALL)
      OF(apply_ball)(c, step, x, slot, &X, &c->twist[3 * i]);
    else
      OF(apply_motion)(c, step, x, &X, c->twist[3 * i]);
    if (!c->is_hub[program->step_start + i])
      slot[step->to] = X;
  }
}

/* Gibbs vector of R Gᵀ. */
static void OF(gibbs_vector)(NUMBER (*R)[3], const km_complex *P, km_complex g[3]) {
  NUMBER G[3][3], T[3][3];
  if (P) {
    const NUMBER Q[4] = {P[0], P[1], P[2], P[3]};
    OF(quaternion_rotation)(Q, G);
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        T[j][k] = R[0][k] * G[0][j] + R[1][k] * G[1][j] + R[2][k] * G[2][j];
    R = T;
  }
  NUMBER share = (REAL)1 / ((REAL)1 + R[0][0] + R[1][1] + R[2][2]);
  g[0] = (km_complex)(share * (R[1][2] - R[2][1]));
  g[1] = (km_complex)(share * (R[2][0] - R[0][2]));
  g[2] = (km_complex)(share * (R[0][1] - R[1][0]));
}

/* Displacement and errors of positions of a loop that a joint closes. */
static void OF(compare_ends)(const km_loop *loop, const POSE *a, const POSE *b, km_loop_displacement *E) {
  const double offset[3] = {loop->origin_offset.x, loop->origin_offset.y, loop->origin_offset.z};
  OF(narrow)(a->p, E->image);
  OF(narrow)(b->p, E->o);
  for (int k = 0; k < 3; ++k)
    E->errors[k] = (km_complex)(a->p[k] - b->p[k] - offset[k]);
}

/* Displacement and errors of a loop with a fixed point. */
static void OF(displace)(km_complex_loop here, const POSE *a, const POSE *b, km_loop_displacement *E) {
  const km_loop *loop = here.loop;
  const double offset[3] = {loop->origin_offset.x, loop->origin_offset.y, loop->origin_offset.z};
  const double point[3] = {loop->point[0].x, loop->point[0].y, loop->point[0].z};
  NUMBER R[3][3], from[3], image[3];
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < 3; ++k) /* R = R_a R_bᵀ */
      R[j][k] = a->R[0][k] * b->R[0][j] + a->R[1][k] * b->R[1][j] + a->R[2][k] * b->R[2][j];
  for (int k = 0; k < 3; ++k)
    from[k] = point[k] - offset[k] - b->p[k];
  OF(rotate)(R, from, image);
  OF(gibbs_vector)(R, here.P, E->g);
  for (int k = 0; k < 3; ++k) {
    image[k] += a->p[k];
    E->errors[k] = (km_complex)(image[k] - point[k]);
    E->errors[3 + k] = 2.0 * E->g[k];
    E->o[k] = point[k] - offset[k];
    OF(narrow)(R[k], E->R[k]);
  }
  OF(narrow)(image, E->image);
}

static void OF(compute_chains)(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               const km_complex_values *out, POSE *slot) {
  OF(compute_slots)(c, program, x, slot);
  for (int i = 0; i < program->loop_count; ++i) {
    km_complex_loop here = km_complex_loop_at(c, program->loop_start + i, out);
    const km_loop *loop = here.loop;
    POSE a, b;
    OF(pose_product)(&slot[loop->slot[0]], &loop->closing_frame[0], !here.has_moving_point, &a);
    OF(pose_product)(&slot[loop->slot[1]], &loop->closing_frame[1], !here.has_moving_point, &b);
    if (here.has_moving_point)
      OF(compare_ends)(loop, &a, &b, &c->displacement[i]);
    else
      OF(displace)(here, &a, &b, &c->displacement[i]);
  }
}
