# find_package(kmech) gives kmech::kmech, the shared library. The static one needs its own libraries too, which
# pkg-config --static knows.
include(${CMAKE_CURRENT_LIST_DIR}/kmechTargets.cmake)
