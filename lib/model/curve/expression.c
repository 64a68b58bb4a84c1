/* Expressions of the time by recursive descent into a stack program, evaluated on jets (u, u̇, ü):
 *
 *   (u v)¨ = ü v + 2 u̇ v̇ + u v̈;    g(u)˙ = g′ u̇,  g(u)¨ = g″ u̇² + g′ ü
 *
 * sum     : product {("+" | "-") product}          product: signed {("*" | "/") signed}
 * signed  : ("-" | "+") signed | power              power  : atom ["^" signed]
 * atom    : number | name | function "(" sum {"," sum} ")" | "(" sum ")"
 *
 * A sign binds less than a power: −t^2 = −(t^2). Source of the derivatives: Griewank, Walther, Evaluating Derivatives
 * (forward mode). */
#include "model/curve/expression.h"

#include "base/text.h"

#include <math.h>
#include <string.h>

typedef enum operation {
  PUSH_NUMBER,
  PUSH_TIME,
  ADD,
  SUBTRACT,
  MULTIPLY,
  DIVIDE,
  POWER,
  NEGATE,
  SQRT,
  SIN,
  COS,
  TAN,
  ATAN2,
  ABS,
  MIN,
  MAX
} operation;

struct km_expression {
  int count, number_count;
  unsigned char *operations; /* [count] in reverse Polish order */
  double *numbers;           /* [number_count] operands of PUSH_NUMBER in their order */
};

static const struct {
  const char *name;
  operation operation;
  int least, most; /* number of arguments */
} functions[] = {{"sqrt", SQRT, 1, 1},   {"sin", SIN, 1, 1}, {"cos", COS, 1, 1},   {"tan", TAN, 1, 1},
                 {"atan2", ATAN2, 2, 2}, {"abs", ABS, 1, 1}, {"min", MIN, 1, 999}, {"max", MAX, 1, 999}};

typedef struct compiler {
  const char *at;
  km_name_value *values;
  const void *context;
  km_expression *out;
  bool failed;
} compiler;

static bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

size_t km_expression_name(const char *text) {
  size_t length = 0;
  while (is_letter(text[length]) || (length && is_digit(text[length])))
    ++length;
  return length;
}

size_t km_expression_number(const char *text) {
  char *end = NULL;
  if (!is_digit(text[0]) && text[0] != '.')
    return 0;
  km_number_read(text, &end);
  return (size_t)(end - text);
}

bool km_expression_uses(const char *text, const char *name) {
  for (const char *c = text; *c;) {
    size_t number = km_expression_number(c), length = km_expression_name(c);
    if (!number && length == strlen(name) && strncmp(c, name, length) == 0)
      return true;
    c += number ? number : length ? length : 1;
  }
  return false;
}

static void emit(compiler *c, operation next) {
  c->out->operations[c->out->count++] = (unsigned char)next;
}

static void emit_number(compiler *c, double number) {
  c->out->numbers[c->out->number_count++] = number;
  emit(c, PUSH_NUMBER);
}

/* True, past it, if the next character is `wanted`. */
static bool take(compiler *c, char wanted) {
  while (*c->at == ' ')
    ++c->at;
  bool found = !c->failed && *c->at == wanted;
  c->at += found;
  return found;
}

static void compile_sum(compiler *c);

static void compile_call(compiler *c, const char *name, size_t length) {
  for (size_t i = 0; i < sizeof functions / sizeof *functions; ++i) {
    if (length != strlen(functions[i].name) || strncmp(name, functions[i].name, length) != 0)
      continue;
    const bool folds = functions[i].most > 2;
    int arguments = 0;
    do {
      compile_sum(c);
      if (++arguments > 1 && folds)
        emit(c, functions[i].operation);
    } while (take(c, ','));
    c->failed = c->failed || arguments < functions[i].least || arguments > functions[i].most || !take(c, ')');
    if (!folds)
      emit(c, functions[i].operation);
    return;
  }
  c->failed = true;
}

static void compile_name(compiler *c) {
  const char *name = c->at;
  size_t length = km_expression_name(name);
  double value;
  c->at += length;
  if (take(c, '('))
    compile_call(c, name, length);
  else if (length == 1 && *name == 't')
    emit(c, PUSH_TIME);
  else if (length == 2 && strncmp(name, "pi", 2) == 0)
    emit_number(c, M_PI);
  else if (length == 3 && strncmp(name, "deg", 3) == 0)
    emit_number(c, M_PI / 180.0);
  else if (c->values && c->values(c->context, name, length, &value))
    emit_number(c, value);
  else
    c->failed = true;
}

static void compile_atom(compiler *c) {
  if (take(c, '(')) {
    compile_sum(c);
    c->failed = c->failed || !take(c, ')');
    return;
  }
  size_t number = km_expression_number(c->at);
  if (number) {
    emit_number(c, km_number_read(c->at, NULL));
    c->at += number;
  } else if (km_expression_name(c->at)) {
    compile_name(c);
  } else {
    c->failed = true;
  }
}

static void compile_signed(compiler *c) {
  if (c->failed)
    return;
  if (take(c, '-')) {
    compile_signed(c);
    emit(c, NEGATE);
  } else if (take(c, '+')) {
    compile_signed(c);
  } else {
    compile_atom(c);
    if (take(c, '^')) {
      compile_signed(c);
      emit(c, POWER);
    }
  }
}

static void compile_product(compiler *c) {
  compile_signed(c);
  while (!c->failed) {
    bool divides = take(c, '/');
    if (!divides && !take(c, '*'))
      return;
    compile_signed(c);
    emit(c, divides ? DIVIDE : MULTIPLY);
  }
}

static void compile_sum(compiler *c) {
  compile_product(c);
  while (!c->failed) {
    bool subtracts = take(c, '-');
    if (!subtracts && !take(c, '+'))
      return;
    compile_product(c);
    emit(c, subtracts ? SUBTRACT : ADD);
  }
}

const km_expression *km_expression_compile(const char *text, km_name_value *values, const void *context,
                                           km_arena *arena) {
  size_t length = strlen(text);
  if (length > KM_LONGEST_EXPRESSION)
    return NULL;
  km_expression *out = KM_ARENA_NEW(arena, km_expression, 1);
  if (!out)
    return NULL;
  /* A character emits at most one operation; a failed call emits one more at its end. */
  out->operations = KM_ARENA_NEW(arena, unsigned char, 2 * length + 2);
  out->numbers = KM_ARENA_NEW(arena, double, length + 1);
  if (!out->operations || !out->numbers)
    return NULL;
  compiler c = {.at = text, .values = values, .context = context, .out = out};
  compile_sum(&c);
  take(&c, ' ');
  return c.failed || *c.at ? NULL : out;
}

const double *km_expression_numbers(const km_expression *e, int *count) {
  *count = e->number_count;
  return e->numbers;
}

/* A value with its first and second derivative. */
typedef struct jet {
  double v, d, dd;
} jet;

/* g(u) by g, g′ and g″ at u. */
static jet chain(jet u, double g, double slope, double bend) {
  return (jet){g, slope * u.d, bend * u.d * u.d + slope * u.dd};
}

static jet product(jet a, jet b) {
  return (jet){a.v * b.v, a.d * b.v + a.v * b.d, a.dd * b.v + 2.0 * a.d * b.d + a.v * b.dd};
}

static jet quotient(jet a, jet b) {
  double inverse = 1.0 / b.v;
  jet out = product(a, chain(b, inverse, -inverse * inverse, 2.0 * inverse * inverse * inverse));
  out.v = a.v / b.v;
  return out;
}

/* u^p with a constant p: factors that are 0 don't meet a power of 0. */
static jet constant_power(jet u, double p) {
  double slope = p == 0.0 ? 0.0 : p * pow(u.v, p - 1.0);
  double bend = p == 0.0 || p == 1.0 ? 0.0 : p * (p - 1.0) * pow(u.v, p - 2.0);
  return chain(u, pow(u.v, p), slope, bend);
}

/* u^w = exp(w ln u). */
static jet power(jet u, jet w) {
  if (w.d == 0.0 && w.dd == 0.0)
    return constant_power(u, w.v);
  jet exponent = product(w, chain(u, log(u.v), 1.0 / u.v, -1.0 / (u.v * u.v)));
  double value = pow(u.v, w.v);
  return chain(exponent, value, value, value);
}

static jet angle(jet y, jet x) {
  double r = x.v * x.v + y.v * y.v;
  double rate = (x.v * y.d - y.v * x.d) / r;
  double acceleration = (x.v * y.dd - y.v * x.dd) / r - rate * 2.0 * (x.v * x.d + y.v * y.d) / r;
  return (jet){atan2(y.v, x.v), rate, acceleration};
}

static jet call(operation f, jet u) {
  double root, tangent;
  switch (f) {
  case NEGATE:
    return (jet){-u.v, -u.d, -u.dd};
  case SQRT:
    root = sqrt(u.v);
    return chain(u, root, 0.5 / root, -0.25 / (root * u.v));
  case SIN:
    return chain(u, sin(u.v), cos(u.v), -sin(u.v));
  case COS:
    return chain(u, cos(u.v), -sin(u.v), -cos(u.v));
  case TAN:
    tangent = tan(u.v);
    return chain(u, tangent, 1.0 + tangent * tangent, 2.0 * tangent * (1.0 + tangent * tangent));
  default: /* ABS */
    return u.v < 0.0 ? (jet){-u.v, -u.d, -u.dd} : u;
  }
}

static jet combine(operation f, jet a, jet b) {
  switch (f) {
  case ADD:
    return (jet){a.v + b.v, a.d + b.d, a.dd + b.dd};
  case SUBTRACT:
    return (jet){a.v - b.v, a.d - b.d, a.dd - b.dd};
  case MULTIPLY:
    return product(a, b);
  case DIVIDE:
    return quotient(a, b);
  case POWER:
    return power(a, b);
  case ATAN2:
    return angle(a, b);
  case MIN:
    return b.v < a.v ? b : a;
  default: /* MAX */
    return b.v > a.v ? b : a;
  }
}

void km_expression_at(const km_expression *e, double t, double out[3]) {
  jet stack[KM_LONGEST_EXPRESSION / 2 + 1]; /* operands that wait are apart by an operator at least */
  int top = 0, number = 0;
  for (int i = 0; i < e->count; ++i) {
    operation f = (operation)e->operations[i];
    if (f == PUSH_NUMBER) {
      stack[top++] = (jet){e->numbers[number++], 0.0, 0.0};
    } else if (f == PUSH_TIME) {
      stack[top++] = (jet){t, 1.0, 0.0};
    } else if (f == NEGATE || (f >= SQRT && f <= TAN) || f == ABS) {
      stack[top - 1] = call(f, stack[top - 1]);
    } else {
      stack[top - 2] = combine(f, stack[top - 2], stack[top - 1]);
      --top;
    }
  }
  out[0] = stack[0].v;
  out[1] = stack[0].d;
  out[2] = stack[0].dd;
}
