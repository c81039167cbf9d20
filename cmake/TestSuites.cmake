# isopach_add_suites(target [PREFIX prefix] [LONG suite...]): one test of ctest for each suite of a GoogleTest program.
#
# A test of ctest is a process, which loads the libraries of GDAL; one for each TEST() takes minutes for that alone. The
# program is asked for its suites when it has been built. A suite of LONG is run as four tests, "Suite (2 of 4)", each
# with a quarter of its tests. A suite of which every test is skipped is reported as skipped.
#
# Single tests: PROGRAM --gtest_filter='Suite.Name'.
function(isopach_add_suites target)
  cmake_parse_arguments(arg "" "PREFIX" "LONG" ${ARGN})
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  set(script ${PROJECT_SOURCE_DIR}/cmake/ListSuites.cmake)
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM BYPRODUCTS ${list}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DPREFIX=${arg_PREFIX} "-DLONG=${arg_LONG}" -DLIST=${list}
            -P ${script})
  # Where the program was not built, ctest says so instead of running fewer tests.
  set(include ${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake)
  file(CONFIGURE OUTPUT ${include} @ONLY CONTENT [[
if(EXISTS "@list@")
  include("@list@")
else()
  add_test("@target@_NOT_BUILT" "@target@_NOT_BUILT")
endif()
]])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script})
endfunction()
