/* Which keys a path study may have. */
#include "exchange/json/study.h"

static const km_field pose_fields[] = {{"T", .shape = KM_SHAPE_VECTOR}, {"R", .shape = KM_SHAPE_MATRIX}, {0}};
static const km_object_format pose_format = {"pose", pose_fields};

static const km_field point_fields[] = {{"T", .shape = KM_SHAPE_VECTOR, .required = true},
                                        {"R", .shape = KM_SHAPE_MATRIX},
                                        {"time", .shape = KM_SHAPE_NUMBER},
                                        {0}};
static const km_object_format point_format = {"point", point_fields};

static const km_field segment_fields[] = {{"type", .shape = KM_SHAPE_STRING, .required = true},
                                          {"steps", .shape = KM_SHAPE_NUMBER},
                                          {"to", .shape = KM_SHAPE_VECTOR},
                                          {"R_to", .shape = KM_SHAPE_MATRIX},
                                          {"center", .shape = KM_SHAPE_VECTOR},
                                          {"axis", .shape = KM_SHAPE_VECTOR},
                                          {"angle", .shape = KM_SHAPE_NUMBER},
                                          {"pitch", .shape = KM_SHAPE_NUMBER},
                                          {"turn", .shape = KM_SHAPE_BOOLEAN},
                                          {"points", .shape = KM_SHAPE_OBJECTS, .object = &point_format},
                                          {"amplitude", .shape = KM_SHAPE_NUMBER},
                                          {"waves", .shape = KM_SHAPE_NUMBER},
                                          {"sideways", .shape = KM_SHAPE_VECTOR},
                                          {0}};
static const km_object_format segment_format = {"segment", segment_fields};

static const km_field path_fields[] = {{"start", .shape = KM_SHAPE_OBJECT, .object = &pose_format},
                                       {"segments", .shape = KM_SHAPE_OBJECTS, .object = &segment_format},
                                       {"csv", .shape = KM_SHAPE_STRING},
                                       {"speed", .shape = KM_SHAPE_NUMBER},
                                       {"turn_speed", .shape = KM_SHAPE_NUMBER},
                                       {0}};
const km_object_format km_format_path = {"path", path_fields};

static const km_field method_fields[] = {{"method", .shape = KM_SHAPE_STRING, .required = true},
                                         {"branches", .shape = KM_SHAPE_NUMBER},
                                         {"levels", .shape = KM_SHAPE_NUMBER},
                                         {"angle", .shape = KM_SHAPE_NUMBER},
                                         {"stride", .shape = KM_SHAPE_NUMBER},
                                         {"value", .shape = KM_SHAPE_STRING},
                                         {"joints", .shape = KM_SHAPE_STRINGS},
                                         {"joint", .shape = KM_SHAPE_STRING},
                                         {"damping", .shape = KM_SHAPE_NUMBER},
                                         {"below", .shape = KM_SHAPE_NUMBER},
                                         {"gain", .shape = KM_SHAPE_NUMBER},
                                         {"spacing", .shape = KM_SHAPE_NUMBER},
                                         {"knots", .shape = KM_SHAPE_NUMBER},
                                         {"evaluations", .shape = KM_SHAPE_NUMBER},
                                         {0}};
const km_object_format km_format_method = {"method", method_fields};

static const km_field study_fields[] = {{"model", .shape = KM_SHAPE_STRING},
                                        {"effector", .shape = KM_SHAPE_PATH},
                                        {"coordinates", .shape = KM_SHAPE_STRINGS},
                                        {"q0", .shape = KM_SHAPE_NUMBERS},
                                        {"path", .shape = KM_SHAPE_OBJECT, .object = &km_format_path},
                                        {"task", .shape = KM_SHAPE_STRING},
                                        {"methods", .shape = KM_SHAPE_ANY},
                                        {"objective", .shape = KM_SHAPE_ANY},
                                        {"rates", .shape = KM_SHAPE_NUMBERS},
                                        {"source", .shape = KM_SHAPE_ANY},
                                        {0}};
const km_object_format km_format_study = {"study", study_fields};
