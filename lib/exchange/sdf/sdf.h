#ifndef KM_EXCHANGE_SDF_H
#define KM_EXCHANGE_SDF_H

#include "exchange/robot/robot.h"

void km_sdf_read(km_robot *robot, km_xml *root);

#endif
