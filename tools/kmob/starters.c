/* Small models to start from, one of each kind. In their texts ' stands for ", <20 mm> for a number in the model's
 * units, <units> for the units, and <in rad> after a parameter for what makes radians of the model's angle. */
#include "kmob/starters.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char fourbar[] =
    "{\n 'source': 'A crank-rocker. Its points follow from the lengths of its links; D is at (ground, 0).',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>},\n"
    " 'parameters': {\n"
    "  'ground': {'value': <80 mm>, 'high': 'crank+coupler+rocker'}, 'crank': {'value': <20 mm>, 'high': "
    "'ground+coupler+rocker'},\n"
    "  'coupler': {'value': <70 mm>, 'high': 'ground+crank+rocker'}, 'rocker': {'value': <50 mm>, 'high': "
    "'ground+crank+coupler'},\n"
    "  'angle': <60 deg>,\n"
    "  'Bx': 'crank*cos(angle<in rad>)', 'By': 'crank*sin(angle<in rad>)', 'x': 'ground-Bx', 'square': 'x^2+By^2',\n"
    "  'u': '(coupler^2-rocker^2)/(2*square)+1/2',\n"
    "  'v': {'value': 'sqrt(coupler^2/square-u^2)', 'note': 'coupler and rocker do not meet at this angle of the crank'},\n"
    "  'Cx': 'Bx+u*x+v*By', 'Cy': 'By-u*By+v*x'},\n"
    " 'assemblies': [{'name': 'linkage', 'drawn': 'assembled',\n"
    "  'bodies': [\n"
    "   {'name': 'crank'},\n"
    "   {'name': 'coupler', 'frames': [{'name': 'tip', 'T': ['(3*Cx-Bx)/2', '(3*Cy-By)/2']}]},\n"
    "   {'name': 'rocker'}],\n"
    "  'joints': [\n"
    "   {'name': 'A', 'type': 'revolute', 'bodies': ['fixed', 'crank'], 'at': [0, 0], 'initial_displacement': 'angle'},\n"
    "   {'name': 'B', 'type': 'revolute', 'bodies': ['crank', 'coupler'], 'at': ['Bx', 'By']},\n"
    "   {'name': 'C', 'type': 'revolute', 'bodies': ['coupler', 'rocker'], 'at': ['Cx', 'Cy']},\n"
    "   {'name': 'D', 'type': 'revolute', 'bodies': ['fixed', 'rocker'], 'at': ['ground', 0]}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'A', 'range': [0, <360 deg>], 'steps': 180},\n"
    "  'mechanical_advantage': {'input': 'A', 'output': 'D'},\n"
    "  'actuators': ['A'],\n"
    "  'loads': [{'name': 'load', 'frame': 'coupler/tip', 'force': [0, <-10 N>]}]}\n}\n";

static const char slider_crank[] =
    "{\n 'source': 'A slider-crank. D is the place of the piston, counted from the crank axis.',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>},\n"
    " 'parameters': {\n"
    "  'crank': <30 mm>, 'rod': {'value': <90 mm>, 'low': 'abs(By-offset)'}, 'offset': 0, 'angle': <60 deg>,\n"
    "  'Bx': 'crank*cos(angle<in rad>)', 'By': 'crank*sin(angle<in rad>)',\n"
    "  'Cx': {'value': 'Bx+sqrt(rod^2-(By-offset)^2)', 'note': 'the rod does not reach the piston'}},\n"
    " 'assemblies': [{'name': 'engine', 'drawn': 'assembled',\n"
    "  'bodies': [\n"
    "   {'name': 'crank'}, {'name': 'rod'},\n"
    "   {'name': 'piston', 'frames': [{'name': 'pin', 'T': ['Cx', 'offset']}]}],\n"
    "  'joints': [\n"
    "   {'name': 'A', 'type': 'revolute', 'bodies': ['fixed', 'crank'], 'at': [0, 0], 'initial_displacement': 'angle'},\n"
    "   {'name': 'B', 'type': 'revolute', 'bodies': ['crank', 'rod'], 'at': ['Bx', 'By']},\n"
    "   {'name': 'C', 'type': 'revolute', 'bodies': ['rod', 'piston'], 'at': ['Cx', 'offset']},\n"
    "   {'name': 'D', 'type': 'prismatic', 'bodies': ['fixed', 'piston'], 'at': [0, 'offset'], 'axis': [1, 0],\n"
    "    'initial_displacement': 'Cx'}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'A', 'range': [0, <360 deg>], 'steps': 180},\n"
    "  'mechanical_advantage': {'input': 'A', 'output': 'D'},\n"
    "  'actuators': ['A'],\n"
    "  'loads': [{'name': 'pressure', 'frame': 'piston/pin', 'force': [<-100 N>, 0]}]}\n}\n";

static const char cylinder[] =
    "{\n 'source': 'A boom that a cylinder lifts. Drawn level.',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>, 'gravity': [0, <-9.80665 m/s2>]},\n"
    " 'parameters': {'reach': <1500 mm>, 'eye': <600 mm>, 'foot_x': <200 mm>, 'foot_y': <-500 mm>},\n"
    " 'fixed': {'frames': [{'name': 'foot', 'T': ['foot_x', 'foot_y']}]},\n"
    " 'assemblies': [{'name': 'crane', 'drawn': 'assembled',\n"
    "  'bodies': [\n"
    "   {'name': 'boom', 'mass': <40 kg>, 'center_of_mass': ['reach/2', 0],\n"
    "    'frames': [{'name': 'eye', 'T': ['eye', 0]}, {'name': 'tip', 'T': ['reach', 0]}]}],\n"
    "  'joints': [{'name': 'A', 'type': 'revolute', 'bodies': ['fixed', 'boom'], 'at': [0, 0]}],\n"
    "  'struts': [\n"
    "   {'name': 'lift', 'from': 'fixed/foot', 'to': 'boom/eye', 'planar': true, 'cylinder': true,\n"
    "    'limits': [<550 mm>, <950 mm>]}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'lift', 'range': [<550 mm>, <950 mm>], 'steps': 100},\n"
    "  'mechanical_advantage': {'input': 'lift', 'output': 'A'},\n"
    "  'loads': [{'name': 'payload', 'frame': 'boom/tip', 'force': [0, <-1000 N>]}]}\n}\n";

static const char six_bar[] =
    "{\n 'source': 'A six-bar linkage (Watt II), by the points of a drawing: A, D and G stand on the ground.',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>},\n"
    " 'parameters': {\n"
    "  'Bx': <15 mm>, 'By': <26 mm>, 'Cx': <85 mm>, 'Cy': <45 mm>, 'Dx': <80 mm>,\n"
    "  'Ex': <100 mm>, 'Ey': <40 mm>, 'Fx': <160 mm>, 'Fy': <65 mm>, 'Gx': <155 mm>},\n"
    " 'assemblies': [{'name': 'linkage', 'drawn': 'assembled',\n"
    "  'bodies': [\n"
    "   {'name': 'crank'}, {'name': 'coupler'}, {'name': 'rocker'}, {'name': 'link'},\n"
    "   {'name': 'output', 'frames': [{'name': 'tip', 'T': ['2*Fx-Gx', '2*Fy']}]}],\n"
    "  'joints': [\n"
    "   {'name': 'A', 'type': 'revolute', 'bodies': ['fixed', 'crank'], 'at': [0, 0]},\n"
    "   {'name': 'B', 'type': 'revolute', 'bodies': ['crank', 'coupler'], 'at': ['Bx', 'By']},\n"
    "   {'name': 'C', 'type': 'revolute', 'bodies': ['coupler', 'rocker'], 'at': ['Cx', 'Cy']},\n"
    "   {'name': 'D', 'type': 'revolute', 'bodies': ['fixed', 'rocker'], 'at': ['Dx', 0]},\n"
    "   {'name': 'E', 'type': 'revolute', 'bodies': ['rocker', 'link'], 'at': ['Ex', 'Ey']},\n"
    "   {'name': 'F', 'type': 'revolute', 'bodies': ['link', 'output'], 'at': ['Fx', 'Fy']},\n"
    "   {'name': 'G', 'type': 'revolute', 'bodies': ['fixed', 'output'], 'at': ['Gx', 0]}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'A', 'range': [0, <360 deg>], 'steps': 180},\n"
    "  'mechanical_advantage': {'input': 'A', 'output': 'G'},\n"
    "  'actuators': ['A'],\n"
    "  'loads': [{'name': 'load', 'frame': 'output/tip', 'force': [<-10 N>, 0]}]}\n}\n";

static const char parallel[] =
    "{\n 'source': 'A Stewart platform: six legs carry a platform, drawn level. The joint pose tells where it is.',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>, 'gravity': [0, 0, <-9.80665 m/s2>]},\n"
    " 'parameters': {\n"
    "  'base': <500 mm>, 'top': <300 mm>, 'height': <600 mm>, 'least': <500 mm>, 'most': <900 mm>,\n"
    "  'half_base': '12*deg', 'half_top': '15*deg'},\n"
    " 'fixed': {'frames': [\n"
    "  {'name': 'b1', 'T': ['base*cos(-half_base)', 'base*sin(-half_base)', 0]},\n"
    "  {'name': 'b2', 'T': ['base*cos(half_base)', 'base*sin(half_base)', 0]},\n"
    "  {'name': 'b3', 'T': ['base*cos(120*deg-half_base)', 'base*sin(120*deg-half_base)', 0]},\n"
    "  {'name': 'b4', 'T': ['base*cos(120*deg+half_base)', 'base*sin(120*deg+half_base)', 0]},\n"
    "  {'name': 'b5', 'T': ['base*cos(240*deg-half_base)', 'base*sin(240*deg-half_base)', 0]},\n"
    "  {'name': 'b6', 'T': ['base*cos(240*deg+half_base)', 'base*sin(240*deg+half_base)', 0]}]},\n"
    " 'assemblies': [{'name': 'stage', 'drawn': 'assembled',\n"
    "  'bodies': [{'name': 'platform', 'mass': <10 kg>, 'center_of_mass': [0, 0, 'height'], 'frames': [\n"
    "   {'name': 'middle', 'T': [0, 0, 'height']},\n"
    "   {'name': 'p1', 'T': ['top*cos(-60*deg+half_top)', 'top*sin(-60*deg+half_top)', 'height']},\n"
    "   {'name': 'p2', 'T': ['top*cos(60*deg-half_top)', 'top*sin(60*deg-half_top)', 'height']},\n"
    "   {'name': 'p3', 'T': ['top*cos(60*deg+half_top)', 'top*sin(60*deg+half_top)', 'height']},\n"
    "   {'name': 'p4', 'T': ['top*cos(180*deg-half_top)', 'top*sin(180*deg-half_top)', 'height']},\n"
    "   {'name': 'p5', 'T': ['top*cos(180*deg+half_top)', 'top*sin(180*deg+half_top)', 'height']},\n"
    "   {'name': 'p6', 'T': ['top*cos(300*deg-half_top)', 'top*sin(300*deg-half_top)', 'height']}]}],\n"
    "  'joints': [{'name': 'pose', 'type': 'float', 'bodies': ['fixed', 'platform'], 'at': [0, 0, 'height']}],\n"
    "  'struts': [\n"
    "   {'name': 'L1', 'from': 'fixed/b1', 'to': 'platform/p1', 'cylinder': true, 'limits': ['least', 'most']},\n"
    "   {'name': 'L2', 'from': 'fixed/b2', 'to': 'platform/p2', 'cylinder': true, 'limits': ['least', 'most']},\n"
    "   {'name': 'L3', 'from': 'fixed/b3', 'to': 'platform/p3', 'cylinder': true, 'limits': ['least', 'most']},\n"
    "   {'name': 'L4', 'from': 'fixed/b4', 'to': 'platform/p4', 'cylinder': true, 'limits': ['least', 'most']},\n"
    "   {'name': 'L5', 'from': 'fixed/b5', 'to': 'platform/p5', 'cylinder': true, 'limits': ['least', 'most']},\n"
    "   {'name': 'L6', 'from': 'fixed/b6', 'to': 'platform/p6', 'cylinder': true, 'limits': ['least', 'most']}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'pose[2]', 'range': [<-50 mm>, <150 mm>], 'steps': 100},\n"
    "  'mechanical_advantage': {'input': 'L1', 'output': 'pose[2]'},\n"
    "  'loads': [{'name': 'payload', 'frame': 'platform/middle', 'force': [0, 0, <-500 N>]}]}\n}\n";

static const char arm[] =
    "{\n 'source': 'An arm of six hinges. Drawn with the upper arm upright, the forearm level, the hand down.',\n"
    " 'model_parameters': {'version': '1.1', 'units': <units>, 'gravity': [0, 0, <-9.80665 m/s2>]},\n"
    " 'parameters': {\n"
    "  'shoulder': <400 mm>, 'upper': <450 mm>, 'fore': <400 mm>, 'hand': <100 mm>, 'elbow': 'shoulder+upper'},\n"
    " 'assemblies': [{'name': 'robot', 'drawn': 'assembled',\n"
    "  'bodies': [\n"
    "   {'name': 'turret', 'mass': <20 kg>, 'center_of_mass': [0, 0, 'shoulder/2']},\n"
    "   {'name': 'upper_arm', 'mass': <12 kg>, 'center_of_mass': [0, 0, 'shoulder+upper/2']},\n"
    "   {'name': 'forearm', 'mass': <6 kg>, 'center_of_mass': ['fore/4', 0, 'elbow']},\n"
    "   {'name': 'roll', 'mass': <3 kg>, 'center_of_mass': ['3*fore/4', 0, 'elbow']},\n"
    "   {'name': 'pitch', 'mass': <1 kg>, 'center_of_mass': ['fore', 0, 'elbow']},\n"
    "   {'name': 'hand', 'mass': <1 kg>, 'center_of_mass': ['fore', 0, 'elbow-hand/2'],\n"
    "    'frames': [{'name': 'tool', 'T': ['fore', 0, 'elbow-hand']}]}],\n"
    "  'joints': [\n"
    "   {'name': 'A1', 'type': 'revolute', 'bodies': ['fixed', 'turret'], 'at': [0, 0, 0],\n"
    "    'limits': [<-170 deg>, <170 deg>]},\n"
    "   {'name': 'A2', 'type': 'revolute', 'bodies': ['turret', 'upper_arm'], 'at': [0, 0, 'shoulder'],\n"
    "    'axis': [0, 1, 0], 'limits': [<-120 deg>, <120 deg>]},\n"
    "   {'name': 'A3', 'type': 'revolute', 'bodies': ['upper_arm', 'forearm'], 'at': [0, 0, 'elbow'],\n"
    "    'axis': [0, 1, 0], 'limits': [<-80 deg>, <150 deg>]},\n"
    "   {'name': 'A4', 'type': 'revolute', 'bodies': ['forearm', 'roll'], 'at': ['fore/2', 0, 'elbow'],\n"
    "    'axis': [1, 0, 0], 'limits': [<-170 deg>, <170 deg>]},\n"
    "   {'name': 'A5', 'type': 'revolute', 'bodies': ['roll', 'pitch'], 'at': ['fore', 0, 'elbow'],\n"
    "    'axis': [0, 1, 0], 'limits': [<-110 deg>, <110 deg>]},\n"
    "   {'name': 'A6', 'type': 'revolute', 'bodies': ['pitch', 'hand'], 'at': ['fore', 0, 'elbow'],\n"
    "    'axis': [0, 0, -1], 'limits': [<-170 deg>, <170 deg>]}]}],\n"
    " 'analysis': {\n"
    "  'sweep': {'joint': 'A2', 'range': [<-60 deg>, <60 deg>], 'steps': 120},\n"
    "  'mechanical_advantage': {'input': 'A2', 'output': {'frame': 'hand/tool', 'direction': [0, 0, 1]}},\n"
    "  'actuators': ['A1', 'A2', 'A3', 'A4', 'A5', 'A6'],\n"
    "  'loads': [{'name': 'payload', 'frame': 'hand/tool', 'force': [0, 0, <-50 N>]}]}\n}\n";

/* Starter models in the order of KMOB_KINDS. */
static const char *const starters[] = {fourbar, slider_crank, cylinder, six_bar, parallel, arm};

/* Size as a round number in the given unit. */
static double rounded(const km_unit *unit, double size, const char *odd, double odd_size) {
  return strcmp(unit->suffix, odd) == 0 ? size / odd_size : size / unit->si;
}

/* A value with a unit of the texts above, in other units. */
static double in_units(double value, const char *unit, const km_units *to) {
  if (strcmp(unit, "mm") == 0)
    return rounded(to->length, 1e-3 * value, "in", 0.025);
  if (strcmp(unit, "kg") == 0)
    return rounded(to->mass, value, "lb", 0.5);
  if (strcmp(unit, "N") == 0)
    return rounded(to->force, value, "lbf", 5.0);
  if (strcmp(unit, "deg") == 0)
    return value * (M_PI / 180.0) / to->angle->si;
  return value / km_units_factor(to, (km_dimension){.length = 1, .time = -2});
}

static void write_units(const km_units *units, km_text *out) {
  const char *before = "{";
  km_units copy = *units;
  for (int q = 0; q < KM_QUANTITIES; ++q, before = ", ")
    km_text_format(out, "%s\"%s\": \"%s\"", before, km_quantity_name((km_quantity)q),
                   (*km_units_slot(&copy, (km_quantity)q))->suffix);
  km_text_add(out, "}");
}

/* Replaces the text between < and >. */
static void write_placeholder(const char *text, size_t size, const km_units *units, km_text *out) {
  char word[32], *unit;
  snprintf(word, sizeof word, "%.*s", (int)size, text);
  if (strcmp(word, "units") == 0) {
    write_units(units, out);
  } else if (strcmp(word, "in rad") == 0) {
    km_text_add(out, units->angle->si == 1.0 ? "" : "*deg");
  } else {
    double value = strtod(word, &unit), rounded_value;
    char digits[KM_NUMBER_TEXT];
    snprintf(digits, sizeof digits, "%.8g", in_units(value, unit + 1, units));
    rounded_value = strtod(digits, NULL);
    km_text_number(out, rounded_value);
  }
}

void kmob_starter_write(int kind, const km_units *units, km_text *out) {
  for (const char *c = starters[kind]; *c; ++c) {
    const char *end = *c == '<' ? strchr(c, '>') : NULL;
    if (end)
      write_placeholder(c + 1, (size_t)(end - c) - 1, units, out);
    else
      km_text_bytes(out, *c == '\'' ? "\"" : c, 1);
    c = end ? end : c;
  }
}
