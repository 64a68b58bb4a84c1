#include "exchange/mjcf/mjcf.h"
void km_mjcf_read(km_robot *robot, km_xml *root) { (void)robot,(void)root; }
