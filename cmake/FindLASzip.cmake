# Finds LASzip's C interface, from the distribution (liblaszip-dev) or from the prefix that scripts/setup.sh fills when it
# may not install packages. Defines the imported target LASzip::LASzip.
set(_laszip_prefix ${CMAKE_CURRENT_LIST_DIR}/../build/deps/laszip)

find_path(LASzip_INCLUDE_DIR laszip/laszip_api.h HINTS ${_laszip_prefix}/include)
find_library(LASzip_LIBRARY laszip HINTS ${_laszip_prefix}/lib PATH_SUFFIXES ${CMAKE_LIBRARY_ARCHITECTURE})

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LASzip
  REQUIRED_VARS LASzip_LIBRARY LASzip_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run scripts/setup.sh, or install liblaszip-dev")

if(LASzip_FOUND AND NOT TARGET LASzip::LASzip)
  add_library(LASzip::LASzip UNKNOWN IMPORTED)
  set_target_properties(LASzip::LASzip PROPERTIES
    IMPORTED_LOCATION ${LASzip_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${LASzip_INCLUDE_DIR})
endif()
mark_as_advanced(LASzip_INCLUDE_DIR LASzip_LIBRARY)
