# cmake -DPROGRAM= -DPREFIX= -DLONG= -DLIST= -P ListSuites.cmake: writes LIST, the tests of ctest for the suites of PROGRAM.
cmake_minimum_required(VERSION 3.24)
set(shards 4)
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE output RESULT_VARIABLE status TIMEOUT 120)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed (${status}):\n${output}")
endif()

set(tests "")
# Where nothing passed and nothing failed, the last lines are the list of what was skipped, and nothing follows.
set(skipped "\\\\[  PASSED  \\\\] 0 tests\\\\.\n(\\\\[  SKIPPED \\\\][^\n]*\n)+$")
function(add name filter environment)
  string(APPEND tests "add_test([==[${PREFIX}${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
    "set_tests_properties([==[${PREFIX}${name}]==] PROPERTIES TIMEOUT 300 SKIP_REGULAR_EXPRESSION \"${skipped}\"${environment})\n")
  set(tests "${tests}" PARENT_SCOPE)
endfunction()

string(REGEX REPLACE "[][;]" "_" output "${output}") # a list must not break where a type's name has such
string(REPLACE "\n" ";" lines "${output}")
set(count 0)
foreach(line IN LISTS lines)
  if(NOT line MATCHES "^([^ #]+)\\.( +#.*)?$") # tests are indented, and "Running main() from ..." has blanks
    continue()
  endif()
  set(suite ${CMAKE_MATCH_1})
  math(EXPR count "${count} + 1")
  if(suite IN_LIST LONG)
    math(EXPR last "${shards} - 1")
    foreach(shard RANGE ${last})
      math(EXPR number "${shard} + 1")
      add("${suite} (${number} of ${shards})" "${suite}.*"
          " ENVIRONMENT \"GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${shard}\"")
    endforeach()
  else()
    add("${suite}" "${suite}.*" "")
  endif()
endforeach()
if(count EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests lists no suite:\n${output}")
endif()
file(WRITE ${LIST} "${tests}")
