# Installs BUILD to a prefix in WORK, checks what arrived, and builds and runs a consumer against it.
#
# Every public header may include the standard library, Eigen and other public headers, and nothing else:
# on a machine that has all the libraries no compiler would notice. Those of the component pcl include PCL too.
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${WORK})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${result}\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix} --config ${CONFIG})

# The manifest. The name of the library folder is the system's.
file(GLOB_RECURSE installed RELATIVE ${prefix} ${prefix}/*)
string(REPLACE "${LIBDIR}/" "lib/" installed "${installed}")
list(TRANSFORM installed REPLACE "(swept[A-Za-z]*Targets)-[a-z]+" "\\1-CONFIG")
list(SORT installed)
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/manifest.txt expected)
if(NOT WITH_GPU)
  list(FILTER expected EXCLUDE REGEX gpu)
endif()
if(NOT WITH_MAN)
  list(FILTER expected EXCLUDE REGEX "/man/")
endif()
if(NOT WITH_PCL)
  list(FILTER expected EXCLUDE REGEX "[pP]cl")
endif()
list(SORT expected)
if(NOT installed STREQUAL expected)
  list(JOIN installed "\n  " text)
  message(FATAL_ERROR "what is installed is not what manifest.txt lists; installed:\n  ${text}")
endif()

# What the headers include.
file(GLOB_RECURSE headers ${prefix}/include/*.h)
foreach(header ${headers})
  file(STRINGS ${header} includes REGEX "^ *# *include")
  foreach(line ${includes})
    if(line MATCHES "\"(.*)\"")
      if(NOT EXISTS ${prefix}/include/swept/${CMAKE_MATCH_1})
        message(FATAL_ERROR "${header} includes ${CMAKE_MATCH_1}, which is not installed")
      endif()
    elseif(header MATCHES "/pcl/" AND line MATCHES "<pcl/[a-z_]+\\.h>")
    elseif(NOT line MATCHES "<([a-z_]+|Eigen/[A-Za-z]+)>")
      message(FATAL_ERROR "${header} includes neither the standard library nor Eigen: ${line}")
    endif()
  endforeach()
endforeach()

run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/consumer -G ${GENERATOR}
    -DWITH_PCL=${WITH_PCL} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${CONFIG}
    "-DCMAKE_EXE_LINKER_FLAGS=${LINK_FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/consumer --config ${CONFIG})
find_program(consumer consumer PATHS ${WORK}/consumer ${WORK}/consumer/${CONFIG} NO_DEFAULT_PATH REQUIRED)
run(${consumer} ${WORK}/picture.exr)
