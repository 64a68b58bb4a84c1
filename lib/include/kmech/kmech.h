/* Every public header of the library. */
#ifndef KMECH_KMECH_H
#define KMECH_KMECH_H

#include "kmech/arm.h"
#include "kmech/base.h"
#include "kmech/build.h"
#include "kmech/clearance.h"
#include "kmech/continuation.h"
#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/exchange.h"
#include "kmech/inspect.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/question.h"
#include "kmech/report.h"
#include "kmech/rounding.h"
#include "kmech/space.h"
#include "kmech/statics.h"
#include "kmech/study.h"
#include "kmech/sweep.h"
#include "kmech/transfer.h"
#include "kmech/version.h"
#include "kmech/volume.h"

#endif
