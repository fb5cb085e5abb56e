# How every library of Swept is built.
#
# swept_library(COMPONENT [TARGET]): the target (swept_COMPONENT) becomes swept::COMPONENT in this build and in an
# installed one. Shared, it has a versioned name, finds its neighbours beside itself, and shows what public headers
# declare: nothing of what it was built with, and nothing that the compiler made of others' templates.
set(swept_export_map ${CMAKE_CURRENT_LIST_DIR}/export.map)

function(swept_library component)
  set(target swept_${component})
  if(ARGC GREATER 1)
    set(target ${ARGV1})
  endif()
  if(NOT TARGET swept::${component})
    add_library(swept::${component} ALIAS ${target})
  endif()
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${component}
    OUTPUT_NAME swept_${component}
    DEFINE_SYMBOL ""
    POSITION_INDEPENDENT_CODE ON
    VERSION ${PROJECT_VERSION}
    # Before 1.0 a minor version may break its callers.
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH $ORIGIN)
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  # Tests call what is inside: a shared build with tests shows everything to them.
  if(NOT (BUILD_SHARED_LIBS AND SWEPT_BUILD_TESTS))
    set_target_properties(${target} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "SHARED_LIBRARY" AND NOT APPLE)
      target_link_options(${target} PRIVATE
        LINKER:--version-script=${swept_export_map} LINKER:--enable-new-dtags LINKER:--no-undefined)
      set_target_properties(${target} PROPERTIES LINK_DEPENDS ${swept_export_map})
    endif()
  endif()
endfunction()

# swept_compiled_alone(SOURCE...): what they name inside themselves, others do, too. Where CMAKE_UNITY_BUILD puts sources
# together (under sanitizers, whose builds are then half as long), these stay apart.
function(swept_compiled_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
