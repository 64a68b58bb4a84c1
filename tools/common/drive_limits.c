/* Warnings about actuator forces beyond the limits of the drives. */
#include "common/drive_limits.h"

void kt_report_drive(const kt_common *common, const char *name, const kt_pose *pose, const km_port *actuator,
                     double force, const char *where) {
  km_text unit = {0};
  if (!km_actuator_passes(pose->mechanism, actuator, force))
    return;
  km_push_unit(pose->model, actuator, &unit);
  kt_print_message(common, KM_WARNING, "%s: actuator %s must give %.6g %s%s, more than its max_force of %.6g", name,
                   actuator->name, force, unit.data ? unit.data : "", where,
                   km_actuator_most(pose->mechanism, actuator));
  km_text_free(&unit);
}
