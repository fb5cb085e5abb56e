# What a consumer gets: find_package(swept) and the targets swept::splat, swept::abuffer, swept::io, swept::datasets
# and, where they were built, swept::gpu_passes and swept::pcl. Each is a component with dependencies of its own.
include(CMakePackageConfigHelpers)

set(swept_package ${CMAKE_INSTALL_LIBDIR}/cmake/swept)
set(swept_components splat abuffer io datasets)
if(SWEPT_GPU)
  list(APPEND swept_components gpu_passes)
endif()
if(SWEPT_PCL)
  list(APPEND swept_components pcl)
endif()

# Public headers. Those of splat/ are, but for what its own sources share; of other folders only these.
file(GLOB_RECURSE swept_headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} splat/*.h)
list(FILTER swept_headers EXCLUDE REGEX "/io/|/(cut|turns|instant|look|path|rims|bernstein|fixed_bernstein|only_root|edge_function|kernel_maker|kernel_order|bent_kernel|turning_kernel|scene_filter|flip|srgb|stopwatch|without_throwing)\\.h$")
foreach(header atomic_file cloud_scene cloud_source image_file point_file read_report scene_file sequence splat_file
        stitch_exr surfel_estimate texture_file)
  list(APPEND swept_headers splat/io/${header}.h)
endforeach()
list(APPEND swept_headers abuffer/abuffer.h abuffer/layers.h abuffer/sampled.h abuffer/reference/reference.h
     abuffer/stochastic/stochastic.h abuffer/visibility.h datasets/generators.h)
if(SWEPT_GPU)
  list(APPEND swept_headers gpu_passes/gpu_renderer.h)
endif()
if(SWEPT_PCL)
  list(APPEND swept_headers splat/io/pcl/point_cloud.h)
endif()
# In the repository they include each other as "splat/scene.h"; installed, as <swept/splat/scene.h>.
install(CODE "
  set(source \"${PROJECT_SOURCE_DIR}\")
  set(work \"${PROJECT_BINARY_DIR}/installed_headers\")
  set(folder \"${CMAKE_INSTALL_INCLUDEDIR}/swept\")
  set(headers \"${swept_headers}\")
  include(\"${CMAKE_CURRENT_LIST_DIR}/install_headers.cmake\")")
install(FILES ${PROJECT_BINARY_DIR}/include/swept/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/swept)

set(swept_pc_splat_requires "eigen3 >= 3.4")
set(swept_pc_abuffer_requires "swept-splat = ${PROJECT_VERSION}")
set(swept_pc_abuffer_private tbb)
set(swept_pc_io_requires "swept-splat = ${PROJECT_VERSION}")
set(swept_pc_io_private "OpenEXR libpng zlib libzstd libzip libwebp")
set(swept_pc_io_libraries -llzf)
if(SWEPT_OPENMESH)
  string(APPEND swept_pc_io_private " openmesh")
endif()
set(swept_pc_datasets_requires "swept-splat = ${PROJECT_VERSION}")
set(swept_pc_gpu_passes_requires "swept-splat = ${PROJECT_VERSION}")
set(swept_pc_gpu_passes_private epoxy)
set(swept_pc_gpu_passes_libraries -ldl)
set(swept_pc_pcl_requires "swept-io = ${PROJECT_VERSION} pcl_common")

file(RELATIVE_PATH SWEPT_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" SWEPT_PC_PREFIX "${SWEPT_PC_PREFIX}")
foreach(component IN LISTS swept_components)
  set(target swept_${component})
  if(component STREQUAL "gpu_passes")
    set(target swept_gpu)
  endif()
  install(TARGETS ${target} EXPORT swept-${component})
  install(EXPORT swept-${component} NAMESPACE swept:: DESTINATION ${swept_package} FILE sweptTargets-${component}.cmake)

  set(SWEPT_PC_NAME ${component})
  set(SWEPT_PC_REQUIRES "${swept_pc_${component}_requires}")
  set(SWEPT_PC_LIBRARIES "-lswept_${component}")
  # A static library needs what it was built with wherever it is linked.
  if(NOT BUILD_SHARED_LIBS)
    string(APPEND SWEPT_PC_REQUIRES " ${swept_pc_${component}_private}")
    string(APPEND SWEPT_PC_LIBRARIES " ${swept_pc_${component}_libraries}")
  endif()
  string(STRIP "${SWEPT_PC_REQUIRES}" SWEPT_PC_REQUIRES)
  string(STRIP "${SWEPT_PC_LIBRARIES}" SWEPT_PC_LIBRARIES)
  configure_file(tools/cmake/swept.pc.in ${PROJECT_BINARY_DIR}/swept-${component}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/swept-${component}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

set(SWEPT_IS_STATIC TRUE)
if(BUILD_SHARED_LIBS)
  set(SWEPT_IS_STATIC FALSE)
endif()
configure_package_config_file(tools/cmake/sweptConfig.cmake.in sweptConfig.cmake
                              INSTALL_DESTINATION ${swept_package} NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break its callers.
write_basic_package_version_file(sweptConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sweptConfig.cmake ${PROJECT_BINARY_DIR}/sweptConfigVersion.cmake
        DESTINATION ${swept_package})

if(SWEPT_BUILD_TOOLS)
  if(BUILD_SHARED_LIBS)
    file(RELATIVE_PATH swept_libraries_from_bin /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
    set_target_properties(swept_cli PROPERTIES INSTALL_RPATH $ORIGIN/${swept_libraries_from_bin})
    target_link_options(swept_cli PRIVATE LINKER:--enable-new-dtags)
  endif()
  install(TARGETS swept_cli)
  install(FILES ${SWEPT_MAN_PAGES} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(uninstall VERBATIM
    COMMAND ${CMAKE_COMMAND} -DMANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt
            -P ${CMAKE_CURRENT_LIST_DIR}/uninstall.cmake)
endif()
