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

/* Half a unit in the last digit of a number; 0 for a number with few digits, which is taken as exact. */
static double half_unit(const char *number, size_t length) {
  int digits = 0, decimals = 0;
  bool point = false;
  const char *c = number;
  for (; c < number + length && *c != 'e' && *c != 'E'; ++c) {
    if (*c == '.')
      point = true;
    else if (*c >= '0' && *c <= '9') {
      digits += digits > 0 || *c != '0';
      decimals += point;
    }
  }
  double power = c < number + length ? km_number_read(c + 1, NULL) : 0.0;
  return digits >= 5 && point ? 0.5 * pow(10.0, power - decimals) : 0.0;
}

void km_robot_judge_digits(const char *text, double period, double *worst) {
  for (const char *rest = text; !is_empty(rest);) {
    double value;
    rest += strspn(rest, blanks);
    const char *start = rest;
    if (!read_one(&rest, &value))
      return;
    double rounding = half_unit(start, (size_t)(rest - start));
    double off = period > 0.0 ? fabs(value - period * round(value / period)) : (double)INFINITY;
    rounding = fmin(rounding, off); /* π/2 is known exactly, however it is written */
    if (rounding > *worst && rounding < 1e-3)
      *worst = rounding;
  }
}

void km_robot_judge_origin(km_robot *robot, const km_xml *element) {
  km_robot_judge_digits(km_xml_attribute_of(element, "rpy"), M_PI / 12.0, &robot->angle_rounding);
  km_robot_judge_digits(km_xml_attribute_of(element, "xyz"), 0.0, &robot->length_rounding);
}

km_rotation km_rotation_rpy(const double rpy[3]) {
  km_rotation R = km_rotation_identity();
  for (int k = 2; k >= 0; --k)
    R = km_rotation_about_axis(&R, k, cos(rpy[k]), sin(rpy[k]));
  return R;
}
