/* Numbers in attributes and texts, and how coarsely they are rounded. */
#include "exchange/robot/robot.h"

#include <string.h>

static const char blanks[] = " \t\r\n,";

static bool read_one(const char **text, double *out) {
  char *end;
  *text += strspn(*text, blanks);
  *out = km_number_read(*text, &end);
  bool ended = *end == '\0' || strchr(blanks, *end);
  if (end == *text || !ended)
    return false;
  *text = end;
  return true;
}

static bool is_empty(const char *text) {
  return !text || text[strspn(text, blanks)] == '\0';
}

int km_robot_count(const char *text) {
  int count = 0;
  for (text += strspn(text, blanks); *text; text += strspn(text, blanks), ++count)
    text += strcspn(text, blanks);
  return count;
}

int km_robot_parse_some(km_robot *robot, const km_xml *at, const char *what, const char *text, double *out, int least,
                        int most) {
  int count = 0;
  if (is_empty(text))
    return -1;
  for (const char *rest = text; !is_empty(rest); ++count) {
    double value;
    const char *here = rest;
    if (count == most || !read_one(&rest, &value) || !(fabs(value) <= 1e60)) {
      km_robot_error(robot, at, "%s: found \"%.60s\"%s; expected %s%d finite number%s", what, here,
                     strstr(text, "${") ? " (an expression of xacro, which has to be expanded first)" : "",
                     least < most ? "up to " : "", most, most == 1 ? "" : "s");
      return -1;
    }
    out[count] = value;
  }
  if (count < least) {
    km_robot_error(robot, at, "%s: found %d number%s, \"%.60s\"; expected %d", what, count, count == 1 ? "" : "s", text,
                   least);
    return -1;
  }
  return count;
}

bool km_robot_parse(km_robot *robot, const km_xml *at, const char *what, const char *text, double *out, int count) {
  return km_robot_parse_some(robot, at, what, text, out, count, count) == count;
}

bool km_robot_numbers(km_robot *robot, const km_xml *element, const char *attribute, double *out, int count) {
  const char *text = km_xml_attribute_of(element, attribute);
  return text && km_robot_parse(robot, element, attribute, text, out, count);
}

double km_robot_number(km_robot *robot, const km_xml *element, const char *attribute, double otherwise) {
  double value = otherwise;
  km_robot_numbers(robot, element, attribute, &value, 1);
  return value;
}

double km_robot_bound(km_robot *robot, const km_xml *at, const char *what, const char *text, double otherwise) {
  double value;
  const char *rest = text;
  if (is_empty(text))
    return otherwise;
  if (read_one(&rest, &value) && is_empty(rest) && !isnan(value))
    return fabs(value) < 1e15 ? value : copysign(HUGE_VAL, value);
  km_robot_error(robot, at, "%s: found \"%.60s\"; expected a number", what, text);
  return otherwise;
}

/* Half a unit in the last digit of a number with a point; *digits: number of its digits from the first that isn't 0. */
static double half_unit(const char *number, size_t length, int *digits) {
  int decimals = 0;
  bool point = false;
  const char *c = number;
  for (; c < number + length && *c != 'e' && *c != 'E'; ++c) {
    if (*c == '.')
      point = true;
    else if (*c >= '0' && *c <= '9') {
      *digits += *digits > 0 || *c != '0';
      decimals += point;
    }
  }
  double power = c < number + length ? km_number_read(c + 1, NULL) : 0.0;
  return point ? 0.5 * pow(10.0, power - decimals) : 0.0;
}

void km_robot_judge_digits(const char *text, double period, km_robot_digits *worst) {
  enum { SEVERAL = 5, WRITTEN = 4 };                  /* digits of a number that is rounded */
  static const double nearly = 0.03, off_unit = 1e-9; /* relative to the length 1 of a direction */
  double finest = HUGE_VAL, square = 0.0;
  int count = 0;
  for (const char *rest = text; !is_empty(rest);) {
    double value;
    rest += strspn(rest, blanks);
    const char *start = rest;
    if (!read_one(&rest, &value))
      return;
    int digits = 0;
    double rounding = half_unit(start, (size_t)(rest - start), &digits);
    ++count;
    square += value * value;
    if (rounding > 0.0)
      finest = fmin(finest, rounding);
    double off = period > 0.0 ? fabs(value - period * round(value / period)) : (double)INFINITY;
    rounding = fmin(rounding, off); /* π/2 is known exactly, however it is written */
    if (digits >= SEVERAL && rounding < 1e-3)
      worst->several = fmax(worst->several, rounding);
    if (digits >= WRITTEN && rounding < 1e-3)
      worst->written = fmax(worst->written, rounding);
  }
  double off = fabs(sqrt(square) - 1.0);
  bool is_direction = period == 0.0 && (count == 3 || count == 4);
  if (is_direction && off > off_unit && off < nearly && isfinite(finest))
    worst->written = fmax(worst->written, count == 4 ? 2.0 * finest : finest); /* a quaternion turns by 2 |dq| */
}

void km_robot_judge_origin(km_robot *robot, const km_xml *element) {
  km_robot_judge_digits(km_xml_attribute_of(element, "rpy"), M_PI / 12.0, &robot->angles);
  km_robot_judge_digits(km_xml_attribute_of(element, "xyz"), 0.0, &robot->lengths);
}

km_rotation km_rotation_rpy(const double rpy[3]) {
  km_rotation R = km_rotation_identity();
  for (int k = 2; k >= 0; --k)
    R = km_rotation_about_axis(&R, k, cos(rpy[k]), sin(rpy[k]));
  return R;
}
