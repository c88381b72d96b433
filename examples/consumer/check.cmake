# Installs a finished build into an empty prefix, runs the installed program, and builds and runs this example against it.
#   cmake -DBUILD_DIR=build/release -DCXX=g++ -P examples/consumer/check.cmake
set(prefix "${BUILD_DIR}/consumer_prefix")
set(build "${BUILD_DIR}/consumer_build")
file(REMOVE_RECURSE "${prefix}" "${build}")

macro(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endmacro()
run("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${prefix}")
run("${prefix}/bin/orasp" --version)
run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${build}" -G Ninja
    "-DCMAKE_PREFIX_PATH=${prefix}" "-DCMAKE_CXX_COMPILER=${CXX}")
run("${CMAKE_COMMAND}" --build "${build}")
run("${build}/consumer")
