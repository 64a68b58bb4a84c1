/* What the library exports: the shared library hides everything that isn't marked. */
#ifndef KMECH_API_H
#define KMECH_API_H

#if defined(__GNUC__)
#define KM_API __attribute__((visibility("default")))
#else
#define KM_API
#endif

#endif
