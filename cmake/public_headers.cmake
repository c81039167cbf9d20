cmake_policy(VERSION 3.24)  # as CMakeLists.txt; scripts of installation begin without
# What programs include, by part of the library; src/isopach/isopach.hpp includes all of it. These are installed with what
# they include themselves; the other headers are the library's own (scripts/checks/public_headers.py).
set(isopach_public_core
  base/option_key.hpp compare/compare.hpp compare/check.hpp match/match.hpp distance/distance.hpp
  delaunay/triangulate.hpp delaunay/validate.hpp measure/source.hpp measure/volume/budget.hpp simulate/scene.hpp
  apps/accuracy.hpp apps/asymmetry.hpp apps/combine.hpp apps/roughness.hpp apps/scanners.hpp apps/sequence.hpp)
set(isopach_public_io
  io/expression.hpp io/polygons.hpp io/raster_values.hpp io/read.hpp io/write.hpp)
set(isopach_public_report
  report/report.hpp report/accuracy.hpp report/asymmetry.hpp report/combine.hpp report/distance.hpp report/match.hpp
  report/roughness.hpp report/scanners.hpp report/sequence.hpp)

# While installing: the public headers of a part and what they include, but for those of other parts. `to`: the folder of
# headers, absolute or below the prefix.
function(isopach_install_headers source part to)
  cmake_path(ABSOLUTE_PATH to BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX})
  set(todo isopach.hpp ${isopach_public_core} ${isopach_public_io} ${isopach_public_report})
  set(seen)
  while(todo)
    list(POP_FRONT todo header)
    if(header IN_LIST seen OR NOT EXISTS ${source}/${header})  # version.hpp is made by the build
      continue()
    endif()
    list(APPEND seen ${header})
    file(STRINGS ${source}/${header} lines REGEX "^#include \"isopach/")
    list(TRANSFORM lines REPLACE "^#include \"isopach/([^\"]+)\".*" "\\1")
    list(APPEND todo ${lines})
  endwhile()
  foreach(header IN LISTS seen)
    get_filename_component(folder ${header} DIRECTORY)
    set(home core)
    if(folder MATCHES "^(io|report)$")
      set(home ${folder})
    endif()
    if(home STREQUAL part)
      file(INSTALL ${source}/${header} DESTINATION ${to}/isopach/${folder})
    endif()
  endforeach()
endfunction()
