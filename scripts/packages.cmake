# Debian packages, by cpack in a build folder whose prefix is /usr (scripts/package does both).

# What the library loads when it is first needed, so that dpkg-shlibdeps can't see it: the packages that own the files.
foreach(name MUPARSER_MAJOR XLSXWRITER_MAJOR SPQR_MAJOR CHOLMOD_MAJOR LAPACKE_MAJOR)
  get_directory_property(${name} DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/lib DEFINITION ${name})
endforeach()
set(loaded libharfbuzz.so.0 libfreetype.so.6 libz.so.1 libpangocairo-1.0.so.0 libcairo.so.2 libpango-1.0.so.0 libgobject-2.0.so.0 libglib-2.0.so.0
  libmuparser.so.${MUPARSER_MAJOR} libxlsxwriter.so.${XLSXWRITER_MAJOR} libspqr.so.${SPQR_MAJOR} libcholmod.so.${CHOLMOD_MAJOR}
  liblapacke.so.${LAPACKE_MAJOR})
find_program(DPKG_QUERY dpkg-query)
set(KMECH_LOADED_PACKAGES "")
foreach(file ${loaded})
  if(DPKG_QUERY)
    execute_process(COMMAND ${DPKG_QUERY} -S "*/${file}" OUTPUT_VARIABLE owner ERROR_QUIET)
    string(REGEX MATCH "^[^:,]+" owner "${owner}")
    if(owner)
      list(APPEND KMECH_LOADED_PACKAGES ${owner})
    endif()
  endif()
endforeach()
list(REMOVE_DUPLICATES KMECH_LOADED_PACKAGES)
list(JOIN KMECH_LOADED_PACKAGES ", " KMECH_LOADED_PACKAGES)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kmech)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "the kmech authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Mobility, leverage, forces and motion of mechanisms and robots")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_COMPONENTS_ALL tools library development)

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME kmech)
set(CPACK_DEBIAN_TOOLS_DESCRIPTION "Tools for people who design mechanisms and robots
 Mobility numbers, redundant constraints, mechanical advantage, holding forces,
 simulation, studies of designs, redundant arms.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
# The tools hold the library, but not the program that reads meshes.
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS
  "libkmech${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}), ${KMECH_LOADED_PACKAGES}, fonts-dejavu-core")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libkmech${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "Library of kmech")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "${KMECH_LOADED_PACKAGES}")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_BINARY_DIR}/triggers")
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/triggers "activate-noawait ldconfig\n")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libkmech-dev)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Headers of kmech's library, its static form, and how CMake and pkg-config find it")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# The static library needs them, and pkg-config looks for what kmech.pc names.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${CPACK_DEBIAN_LIBRARY_PACKAGE_NAME} (= ${PROJECT_VERSION}), \
libjansson-dev, libgsl-dev, libnlopt-dev, libmd-dev, libexpat1-dev, libsqlite3-dev, libsuitesparse-dev, libsundials-dev")

if(TARGET kmech_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-kmech)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python package of kmech")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # What Python compiles when it is used belongs to no package: it goes before the package does.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/python-control/prerm)
  file(WRITE ${CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA}
    "#!/bin/sh\nset -e\nrm -rf /usr/lib/python3/dist-packages/kmech/__pycache__\n")
  file(CHMOD ${CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
    GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "${CPACK_DEBIAN_LIBRARY_PACKAGE_NAME} (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-cffi-backend, python3-numpy")
endif()
if(TARGET kview)
  list(APPEND CPACK_COMPONENTS_ALL view)
  set(CPACK_DEBIAN_VIEW_PACKAGE_NAME kmech-view)
  set(CPACK_DEBIAN_VIEW_DESCRIPTION "kview: the mechanism in your hand, in the browser")
  set(CPACK_DEBIAN_VIEW_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_VIEW_PACKAGE_DEPENDS "kmech (= ${PROJECT_VERSION}), ${KMECH_LOADED_PACKAGES}")
  set(CPACK_DEBIAN_VIEW_PACKAGE_RECOMMENDS "xdg-utils")
endif()
# Times of files are those of the last change of the sources, so that two builds give the same bytes.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/packages_times.cmake)
include(CPack)
