# Builds Swept as shared libraries, without tests, in BUILD, and checks and uses what it installs as run.cmake does.
# The compiler sees the very same text and flags as for static ones, so that a cache has most of it.
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${BUILD} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${CONFIG}
  -DBUILD_SHARED_LIBS=ON -DSWEPT_BUILD_TESTS=OFF -DSWEPT_GPU=${WITH_GPU} -DSWEPT_PYTHON=OFF -DSWEPT_HELP2MAN=OFF
  -DSWEPT_EMBREE=OFF -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} --log-level=WARNING
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} COMMAND_ERROR_IS_FATAL ANY OUTPUT_FILE ${BUILD}/log)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
