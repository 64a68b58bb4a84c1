/* Format table of studies of designs. */
#include "exchange/json/format/format_rows.h"

static const km_field axis_fields[] = {{"values", "The values, instead of a range.", SHAPE(NUMBERS)},
                                       {"from", "First value of a range.", NUMBER},
                                       {"to", "Last value of a range.", NUMBER},
                                       {"count", "How many values the range has, both ends among them.", NUMBER},
                                       {0}};
static const km_object_format axis_format = {"axis", axis_fields};

static const km_field spread_fields[] = {
    {"uniform", "Evenly between [low, high].", SHAPE(RANGE)},
    {"normal", "Normal distribution: [mean, standard deviation].", SHAPE(RANGE)},
    {"within", "Of a normal distribution: nothing outside [low, high].", SHAPE(RANGE)},
    {0}};
static const km_object_format spread_format = {"spread", spread_fields};

static const km_field accuracy_fields[] = {
    {"figure", "The figure whose mean is to be known.", STRING, REQUIRED},
    {"half_width", "Half width of its 95 % confidence interval at which the sample stops.", NUMBER, REQUIRED},
    {0}};
static const km_object_format accuracy_format = {"accuracy", accuracy_fields};

static const km_field sample_fields[] = {
    {"count", "Designs; with `indices` the rows of its matrices.", NUMBER},
    {"method", "\"sobol\", \"latin\" or \"random\".", STRING, UNSTATED("sobol")},
    {"seed", "Whole number from which the sample follows.", NUMBER, UNSTATED("1")},
    {"parameters", "The parameters that spread, by name or path.", .shape = KM_SHAPE_MAP, .object = &spread_format},
    {"csv", "A file instead: one column a parameter, one row a design.", STRING},
    {"indices",
     "Saltelli's scheme, from which Sobol's indices of sensitivity follow: count times (parameters + 2) designs.",
     BOOLEAN, UNSTATED("false")},
    {"accuracy", "Stops before `count` is reached.", OBJECT(accuracy_format)},
    {0}};
static const km_object_format sample_format = {"sample", sample_fields};

static const km_field variable_fields[] = {
    {"low", "Lower bound.", NUMBER, REQUIRED},
    {"high", "Upper bound.", NUMBER, REQUIRED},
    {"start", "Where the first start begins.", NUMBER, UNSTATED("the model's own value, or the middle")},
    {0}};
static const km_object_format variable_format = {"variable", variable_fields};

static const km_field optimise_fields[] = {
    {"variables", "What may change, by parameter.", REQUIRED, .shape = KM_SHAPE_MAP, .object = &variable_format},
    {"minimise", "Figure that is to be least.", SHAPE(STRINGS)},
    {"maximise", "Figure that is to be greatest. Two goals in all give a front.", SHAPE(STRINGS)},
    {"algorithm", "See the table of algorithms.", STRING, UNSTATED("cobyla")},
    {"evaluations", "Most designs of each start, those by which gradients are measured among them.", NUMBER,
     UNSTATED("200")},
    {"tolerance", "Change of the variables, over the width of their bounds, below which a start ends.", NUMBER,
     UNSTATED("1e-6")},
    {"starts", "How many starts; with two goals: how many points of the front are looked for.", NUMBER, UNSTATED("1")},
    {"seed", "Whole number from which further starts and random searches follow.", NUMBER, UNSTATED("1")},
    {0}};
static const km_object_format optimise_format = {"optimise", optimise_fields};

static const km_field figure_fields[] = {
    {"figure",
     "\"min\", \"max\", \"span\", \"mean\", \"rms\", \"peak\" (largest magnitude), \"last\" (value of the last row), "
     "\"settling\", \"at\", \"where min\", \"where max\", \"where peak\" of a column; \"reached\", \"toggles\"; "
     "\"distance\" of given points from a traced one; \"formula\". Mean and rms (root mean square) are those over the driver, the arc "
     "length or the time, by the trapezoidal rule.",
     STRING, REQUIRED},
    {"column", "Column of the answer's table, without its unit.", STRING},
    {"at",
     "Of \"at\": the driver's value, the arc length or the time. Between two rows the figure lies on the straight line between "
     "them.",
     NUMBER},
    {"within",
     "Of \"settling\": the part of the largest distance from the last value within which the column stays from that time on.",
     NUMBER, UNSTATED("0.02")},
    {"point", "The traced point of \"distance\", \"body/frame\".", STRING},
    {"through", "The points that it should pass, [x, y] or [x, y, z] each.", SHAPE(ROWS)},
    {"formula",
     "Of \"formula\": an expression of figures of the same question before it, such as \"end/start\"; a text with an operator "
     "alone stands for the object.",
     STRING},
    {"low", "Least value that is good enough.", NUMBER},
    {"high", "Greatest value that is good enough.", NUMBER},
    {"better", "\"larger\" or \"smaller\": which design is the best.", STRING},
    {0}};
static const km_object_format figure_format = {"figure", figure_fields};

static const km_field question_fields[] = {
    {"name", "Of its files.", STRING, UNSTATED("the question's own word")},
    {"question", "\"mobility\", \"advantage\", \"forces\", \"track\", \"run\", \"inverse\", \"motion\", \"allowance\", \"clearance\", \"modes\", \"map\", \"turning\" or \"volume\".", STRING,
     REQUIRED},
    {"options",
     "The options of the sweep commands, but mode, pose and float: {\"joint\": \"A\", \"range\": [0, 6.28], \"steps\": 100, …}; of a track: "
     "{\"study\": a path study's file, \"method\": \"greedy\"}; of a run: {\"until\": 5, \"rate\": {\"A\": 3}, \"stop\": {\"C\": 0.2}, …}; "
     "of inverse: {\"rate\": {\"A\": 3}, \"steps\": 360, …}.",
     SHAPE(ANY)},
    {"hold", "Joints that are kept at a value.", SHAPE(COORDINATE_MAP)},
    {"set", "Joints that are moved to a value first.", SHAPE(COORDINATE_MAP)},
    {"figures", "Figures of merit by name; \"min ma.A/B\" stands for its object.", .shape = KM_SHAPE_WORD_MAP,
     .object = &figure_format},
    {"bands", "Columns of which every row is kept, for quantiles along the motion.", SHAPE(STRINGS)},
    {0}};
static const km_object_format question_format = {"question", question_fields};

static const km_field designs_fields[] = {
    {"model", "The model's file, seen from the study's folder.", STRING, REQUIRED},
    {"parameters", "Names for numbers of the model by their paths. A parameter of the model needs none.",
     .shape = KM_SHAPE_TEXT_MAP},
    {"variants", "Designs by name, each with the parameters that differ.", .shape = KM_SHAPE_VALUE_MAPS},
    {"grid", "All combinations of values.", .shape = KM_SHAPE_LIST_MAP, .object = &axis_format},
    {"sample", "Designs that spread.", OBJECT(sample_format)},
    {"optimise", "Looks for the best design.", OBJECT(optimise_format)},
    {"ask", "The questions.", OBJECTS(question_format), REQUIRED},
    {"source", "What the study is about, for people.", SHAPE(ANY)},
    {0}};
const km_object_format km_format_designs = {"study", designs_fields};
