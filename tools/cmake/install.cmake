# What a consumer gets: find_package(swept) and the targets swept::splat, swept::io, swept::abuffer and, where
# it was built, swept::gpu. find_package(swept COMPONENTS pcl) adds swept::pcl, and looks for PCL; components that
# were not built are not found.
include(CMakePackageConfigHelpers)

set(swept_include ${CMAKE_INSTALL_INCLUDEDIR}/swept)
set(swept_package ${CMAKE_INSTALL_LIBDIR}/cmake/swept)

# Public headers. Those of splat/ are, but for what its own sources share; of io and abuffer only these.
install(DIRECTORY splat/ DESTINATION ${swept_include}/splat
        FILES_MATCHING PATTERN "*.h" PATTERN "io" EXCLUDE PATTERN "instant.h" EXCLUDE PATTERN "flip.h" EXCLUDE
        PATTERN "srgb.h" EXCLUDE PATTERN "stopwatch.h" EXCLUDE)
foreach(header atomic_file cloud_source image_file point_file read_report scene_file sequence splat_file surfel_estimate)
  install(FILES splat/io/${header}.h DESTINATION ${swept_include}/splat/io)
endforeach()
install(FILES abuffer/abuffer.h abuffer/layers.h abuffer/sampled.h DESTINATION ${swept_include}/abuffer)
install(FILES abuffer/reference/reference.h DESTINATION ${swept_include}/abuffer/reference)

set(swept_libraries splat io abuffer)
if(SWEPT_GPU)
  install(FILES gpu_passes/gpu_renderer.h DESTINATION ${swept_include}/gpu_passes)
  list(APPEND swept_libraries gpu)
endif()

foreach(library IN LISTS swept_libraries)
  set_target_properties(swept_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS swept_${library} EXPORT sweptTargets)
endforeach()
install(EXPORT sweptTargets NAMESPACE swept:: DESTINATION ${swept_package})

# Apart from the others, so that who does not ask for it needs no PCL.
if(SWEPT_PCL)
  install(FILES splat/io/pcl/point_cloud.h DESTINATION ${swept_include}/splat/io/pcl)
  set_target_properties(swept_pcl PROPERTIES EXPORT_NAME pcl)
  install(TARGETS swept_pcl EXPORT sweptPclTargets)
  install(EXPORT sweptPclTargets NAMESPACE swept:: DESTINATION ${swept_package})
endif()

configure_package_config_file(tools/cmake/sweptConfig.cmake.in sweptConfig.cmake
                              INSTALL_DESTINATION ${swept_package})
# Before 1.0 a minor version may break its callers.
write_basic_package_version_file(sweptConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sweptConfig.cmake ${PROJECT_BINARY_DIR}/sweptConfigVersion.cmake
        DESTINATION ${swept_package})

if(SWEPT_BUILD_TOOLS)
  install(TARGETS swept_cli)
  install(FILES ${SWEPT_MAN_PAGES} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()
