#include "exchange/sdf/sdf.h"
void km_sdf_read(km_robot *robot, km_xml *root) { (void)robot,(void)root; }
