#ifndef KM_EXCHANGE_MJCF_H
#define KM_EXCHANGE_MJCF_H

#include "exchange/robot/robot.h"

void km_mjcf_read(km_robot *robot, km_xml *root);

#endif
