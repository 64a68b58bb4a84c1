/* Poses by name, and the values of joints by their labels. */
#include "exchange/json/read/reader.h"

int km_reader_values(km_reader *reader, const km_value *value, const km_place *place, int *first,
                     const km_value **item) {
  const km_model *model = reader->model;
  int coordinate = km_names_get(&reader->labels, KM_LABEL_COORDINATE, value->key);
  int joint = km_names_get(&reader->labels, KM_LABEL_JOINT, value->key);
  size_t given = value->kind == KM_LIST ? value->count : 1;
  *item = value->kind == KM_LIST ? value->first : value;
  *first = -1;
  if (coordinate < 0 && joint < 0) {
    if (km_names_get(&reader->labels, KM_LABEL_LEFT_OUT, value->key) >= 0)
      km_reader_note(reader, place, "joint \"%.80s\" is left out of the model, and its value with it", value->key);
    else if (km_names_get(&reader->labels, KM_LABEL_FAULTY, value->key) < 0)
      km_reader_error(reader, place, "\"%.80s\" names no joint; expected a joint's label", value->key);
    return 0;
  }
  int freedom = coordinate >= 0 ? 1 : km_model_freedom(model, joint);
  if ((size_t)freedom != given) {
    km_reader_error(reader, place, "found %zu values; expected %d", given, freedom);
    return 0;
  }
  *first = coordinate >= 0 ? coordinate : model->joints[joint].first_coordinate;
  return freedom;
}

static void read_pose(km_reader *reader, const km_value *value, const km_place *place) {
  km_model *model = reader->model;
  km_model_pose *pose = &model->poses[model->pose_count];
  *pose = (km_model_pose){.name = value->key,
                          .coordinates = KM_ARENA_NEW(&model->arena, int, (size_t)model->coordinate_count),
                          .values = KM_ARENA_NEW(&model->arena, double, (size_t)model->coordinate_count)};
  bool *named = KM_NEW(bool, (size_t)model->coordinate_count);
  if (!named || model->arena.failed) {
    model->arena.failed = true;
    km_free(named);
    return;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    const km_value *item;
    km_place at = {place, v->key, 0};
    int first, freedom = km_reader_values(reader, v, &at, &first, &item);
    for (int k = 0; k < freedom; ++k, item = item->next) {
      if (named[first + k]) {
        km_reader_error(reader, &at, "this coordinate is named twice; expected each once");
        continue;
      }
      named[first + k] = true;
      pose->coordinates[pose->count] = first + k;
      pose->values[pose->count++] = item->number;
    }
  }
  km_free(named);
  model->pose_count++;
}

void km_read_poses(km_reader *reader, const km_value *root) {
  const km_value *poses = km_value_get(root, "poses");
  km_place place = {NULL, "poses", 0};
  reader->model->poses = KM_ARENA_NEW(&reader->model->arena, km_model_pose, poses ? poses->count : 0);
  for (const km_value *v = poses ? poses->first : NULL; v && !reader->model->arena.failed; v = v->next) {
    km_place at = {&place, v->key, 0};
    read_pose(reader, v, &at);
  }
}
