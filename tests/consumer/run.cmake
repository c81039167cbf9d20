# Installs the build to a prefix of its own, then configures, builds and runs the consumer against that prefix alone.
file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)

function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(flags "")
if(SANITIZE)
  set(flags -fsanitize=${SANITIZE})
endif()
step(${CMAKE_COMMAND} --install ${ISOPACH_BUILD} --prefix ${prefix})
step(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -DCMAKE_PREFIX_PATH=${prefix}
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${flags} -DCMAKE_BUILD_TYPE=Release)
step(${CMAKE_COMMAND} --build ${WORK}/build)
step(${WORK}/build/consumer)
message(STATUS "${output}")
if(NOT output MATCHES "^isopach [0-9.]+ rho 0.25 area 551")
  message(FATAL_ERROR "the consumer printed something else than rho 0.25 on area 551: ${output}")
endif()
if(EXISTS ${prefix}/bin/isopach)
  step(${prefix}/bin/isopach --version)
endif()

# The core alone: nothing else is installed, and none of what the other parts need can be found.
step(${CMAKE_COMMAND} --install ${ISOPACH_BUILD} --prefix ${WORK}/core --component core)
set(not_there)
foreach(package IN ITEMS GDAL LASzip PNG PkgConfig nlohmann_json FastFloat)
  list(APPEND not_there -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
step(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/core -B ${WORK}/build-core ${not_there}
  -DCMAKE_PREFIX_PATH=${WORK}/core -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${flags} -DCMAKE_BUILD_TYPE=Release)
step(${CMAKE_COMMAND} --build ${WORK}/build-core)
step(${WORK}/build-core/core)
message(STATUS "${output}")
if(NOT output STREQUAL "net 3 area 12 weighted 0.5 row field detected 12\n")
  message(FATAL_ERROR "the consumer of the core printed something else than a lift of 0.25 over 3 x 4: ${output}")
endif()
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${WORK}/build-core/core RESOLVED_DEPENDENCIES_VAR libraries
  UNRESOLVED_DEPENDENCIES_VAR unresolved)
if("${libraries};${unresolved}" MATCHES "/lib(gdal|laszip|png|cairo|muparser)[^/;]*")
  message(FATAL_ERROR "the core is linked with ${CMAKE_MATCH_0}")
endif()

# Built from source where they are not installed either. What is compiled is what the build at hand has compiled.
step(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/../.. -B ${WORK}/core-only ${not_there}
  -DISOPACH_CORE_ONLY=ON -DISOPACH_TESTS=OFF -DISOPACH_CLI=OFF -DCMAKE_CXX_COMPILER=${CXX})
step(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/../.. -B ${WORK}/without-gdal
  -DCMAKE_DISABLE_FIND_PACKAGE_GDAL=ON -DISOPACH_GDAL=OFF -DISOPACH_TESTS=OFF -DCMAKE_CXX_COMPILER=${CXX})
