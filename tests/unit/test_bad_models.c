/* Errors and notes of the reader of the model format, each with its text. */
#include "support/refusals.h"

#include "kmech/arm.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define ASSEMBLY(inside)                                                                                               \
  "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}, {\"name\": \"c\"}], " inside "}]"
#define HINGE "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}"
#define HINGED(joint)                                                                                                  \
  "\"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"" joint                                                  \
  "\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]"
#define RIGID            "{\"name\": \"R\", \"type\": \"rigid\", \"body_frame_pairs\": [\"b\", \"c\"]}"
#define BALL(more)       "{\"name\": \"S\", \"type\": \"spherical\", \"body_frame_pairs\": [\"b\", \"c\"]" more "}"
#define TIED(more)       ASSEMBLY("\"joints\": [" HINGE ", " RIGID "]" more)
#define ANALYSIS(inside) TIED("") ", \"analysis\": {" inside "}}"
#define NEWER(more)      ", \"model_parameters\": {\"version\": \"1.1\"" more "}"

static const told_text refused[] = {
    {TIED("") ", \"model_parameters\": {\"characteristic_length\": 1e-200}}",
     "expected a length whose square is a number"},
    {ANALYSIS("\"sweep\": {\"joint\": \"R\", \"range\": [0, 1]}"),
     "joint \"R\" is rigid; expected a joint with a coordinate"},
    {ANALYSIS(
         "\"mechanical_advantage\": {\"input\": \"A\", \"output\": {\"frame\": [\"c\", \"origin\"], \"direction\": [0, 0, 0]}}"),
     "found no length; expected a direction"},
    {ANALYSIS("\"mechanical_advantage\": {\"input\": 3, \"output\": \"A\"}"), "found 3; expected a joint"},
    {ANALYSIS("\"mechanical_advantage\": {\"input\": [], \"output\": \"A\"}"), "found a list; expected a joint"},
    {ASSEMBLY("\"joints\": [" HINGE ", " BALL(", \"limits\": [1, 2]") "]") NEWER("") "}",
     "found [1, 2]; expected 0 and the largest angle of the ball's turn"},
    {TIED(
         ", \"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\"}, \"coefficients\": [[0, "
         "-1]]}]") "}",
     "\"joint\" is missing; expected the joint of this port"},
    {TIED(
         ", \"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"frame\"}, \"coefficients\": [[0, "
         "-1]]}]") "}",
     "\"body_frame_pair\" is missing; expected the two frames of this port"},
    {ASSEMBLY("\"joints\": [" HINGE ", " BALL("") "]")
         NEWER("") ", \"poses\": {\"p\": {\"S\": [0, 0, 0], \"S[0]\": 1}}}",
     "this coordinate is named twice; expected each once"},
    {"{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"shapes\": [{\"mesh\": \"m.stl\", \"scale\": 0}]}], \"joints\": [" HINGE
     "]}]" NEWER("") "}",
     "found 0; expected another number"},
    {TIED(
         "") ", \"parameters\": {\"p\": \"1 + "
             "an_identifier_of_more_than_sixty_four_characters_which_can_not_be_a_parameter_of_any_model_at_all\"}" NEWER(
                 "") "}",
     "there is no parameter \"an_identifier"},
    {"{\"assemblies\": [{\"name\": \"a\", " HINGED("b/J") ", \"assemblies\": [{\"name\": \"b\", " HINGED(
         "J") "}]}, "
              "{\"name\": \"y\", " HINGED("J") "}, {\"name\": \"z\", " HINGED("b/J") "}]}",
     "the label \"a/b/J\" is that of another joint; expected another name"},
};

static const told_text told[] = {
    {"{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}, {\"name\": \"c\", \"active\": false}], \"joints\": [" HINGE
     "], \"struts\": [{\"name\": \"s\", \"from\": \"fixed/origin\", \"to\": \"c/origin\"}]}]" NEWER("") "}",
     "strut \"s\" is left out with the body or frame that it is on"},
    {ASSEMBLY("\"joints\": [" HINGE ", " RIGID
              ", {\"name\": \"K\", \"active\": false, \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", "
              "\"b\"]}]") ", \"analysis\": {\"sweep\": {\"joint\": [\"a\", \"K\"], \"range\": [0, 1]}}}",
     "is left out of the model, and what is asked of it with it"},
};

static void models_are_refused(void **state) {
  (void)state;
  assert_models_told(refused, COUNT(refused), true);
}

static void what_is_left_out_is_told(void **state) {
  (void)state;
  assert_models_told(told, COUNT(told), false);
}

#define STUDY(path)     "{\"model\": \"m.json\", \"effector\": \"b/tip\", \"path\": {" path "}}"
#define SEGMENT(inside) STUDY("\"segments\": [{" inside "}]")
#define ALONG           "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [1, 0, 0], \"steps\": 4}]}"

static const told_text studies[] = {
    {STUDY(""), "expected either \"segments\" or \"csv\""},
    {SEGMENT("\"type\": \"helix\", \"center\": [0, 0, 0], \"axis\": [0, 0, 1], \"steps\": 4"),
     "\"pitch\" is missing; expected the travel"},
    {SEGMENT(
         "\"type\": \"arc\", \"center\": [0, 0, 0], \"axis\": [0, 0, 1], \"angle\": 1, \"turn\": true, \"R_to\": [[1, 0, 0], [0, 1, 0], "
         "[0, 0, 1]], \"steps\": 4"),
     "both \"turn\" and \"R_to\"; expected one of them"},
    {SEGMENT("\"type\": \"spline\", \"points\": [{\"T\": [1, 0, 0], \"time\": 1}, {\"T\": [2, 1, 0]}], \"steps\": 4"),
     "1 of 2 points have a \"time\"; expected all or none"},
    {SEGMENT("\"type\": \"line\", \"to\": [1, 0, 0], \"steps\": 0"), "steps"},
    {"{\"effector\": \"b/tip\", \"methods\": [], " ALONG "}", "found none; expected at least one method"},
    {"{\"effector\": \"b/tip\", \"objective\": {}, " ALONG "}", "expected an objective's name or {name: weight}"},
    {"{\"effector\": \"b/tip\", \"objective\": {\"manipulability\": 0}, " ALONG "}", "expected a weight other than 0"},
    {"{\"effector\": \"b/tip\", \"objective\": \"speed\", " ALONG "}", "\"speed\" is not an objective"},
    {"{\"effector\": \"b/tip\", \"methods\": [{\"method\": \"lookahead\", \"branches\": 9, \"angle\": 40}], " ALONG "}",
     "the outermost of 9 branches turns by 160 degrees; expected less than 90"},
};

static void path_studies_are_refused(void **state) {
  (void)state;
  for (size_t i = 0; i < COUNT(studies); ++i) {
    km_study_def def = km_study_def_default();
    km_error error = {.text = ""};
    km_messages *messages = km_messages_create();
    km_status status = km_study_read(studies[i].text, strlen(studies[i].text), "", messages, &def, &error);
    assert_words(&studies[i], status, KM_MODEL, messages, &error);
    km_study_def_free(&def);
    km_messages_free(messages);
  }
}

/* Files of poses. */
static void files_of_poses_are_refused(void **state) {
  (void)state;
  static const struct {
    const char *bytes;
    size_t size;
    const char *words;
  } files[] = {{"", 0, "is empty; expected poses"},
               {"x,y,z\0,rx,ry,rz\n", 16, "holds a NUL byte; expected text"},
               {"x,y,z,rx,ry,rz,w\n1,2,3,0,0,0,1\n2,2,3,0,0,0,1\n", 45, "expected x,y,z and a quaternion"},
               {"x,y,z,rx,ry,rz\n1,2,3,0,0,0\n", 27, "holds 1 pose; expected at least 2"}};
  for (size_t i = 0; i < COUNT(files); ++i) {
    char path[] = "/tmp/poses-XXXXXX";
    km_study_def def = km_study_def_default();
    km_error error = {.text = ""};
    km_messages *messages = km_messages_create();
    int file = mkstemp(path);
    assert_true(file >= 0 && write(file, files[i].bytes, files[i].size) == (ssize_t)files[i].size);
    close(file);
    const told_text told_of = {path, files[i].words};
    km_status status = km_study_read_poses(path, (km_study_place){"path", false}, messages, &def, &error);
    unlink(path);
    assert_words(&told_of, status, status, messages, &error);
    assert_int_not_equal(status, KM_OK);
    km_study_def_free(&def);
    km_messages_free(messages);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(models_are_refused), cmocka_unit_test(what_is_left_out_is_told),
                                     cmocka_unit_test(path_studies_are_refused),
                                     cmocka_unit_test(files_of_poses_are_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
