# GDAL is not linked: io/gdal.cpp loads it when a file asks for it, from the shared library that is found here. Without
# ISOPACH_GDAL neither it nor its headers are needed. `target` compiles io/gdal*.cpp.
function(isopach_use_gdal target)
  set(room ${PROJECT_SOURCE_DIR}/src/isopach/io)
  get_target_property(library GDAL::GDAL LOCATION)
  file(REAL_PATH ${library} real)
  if(NOT real MATCHES "\\.(so|dylib)")
    message(FATAL_ERROR "GDAL is loaded while isopach runs, which needs a shared library, not ${library}: install one, "
      "or configure with -DISOPACH_GDAL=OFF")
  endif()
  # The name that the loader knows it by: "libgdal.so.32"; else that of the file.
  get_filename_component(name ${library} NAME)
  if(CMAKE_READELF)
    execute_process(COMMAND ${CMAKE_READELF} -d ${library} OUTPUT_VARIABLE dynamic ERROR_QUIET)
    if(dynamic MATCHES "SONAME[^\n]*\\[([^]\n]+)\\]")
      set(name ${CMAKE_MATCH_1})
    endif()
  endif()
  # Where the loader does not look by itself, the folder belongs to the name.
  get_filename_component(folder ${library} DIRECTORY)
  if(NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
    set(name ${folder}/${name})
  endif()
  set_source_files_properties(${room}/gdal.cpp PROPERTIES COMPILE_DEFINITIONS ISOPACH_GDAL_LIBRARY="${name}")
  target_include_directories(${target} SYSTEM PRIVATE
    $<BUILD_INTERFACE:$<TARGET_PROPERTY:GDAL::GDAL,INTERFACE_INCLUDE_DIRECTORIES>> $<BUILD_INTERFACE:${PROJ_INCLUDE_DIRS}>)
  target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  message(STATUS "GDAL is loaded on demand, as ${name}")
endfunction()
