# Files as text inside the program.
#
# swept_embed(OUTPUT HEADER FUNCTION FILE...): OUTPUT becomes a C++ source that defines what HEADER declares,
#   std::string_view swept::FUNCTION(std::string_view name);
# the content of the FILE of that name, without its folder; empty if there is none.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(swept_embed_script ${CMAKE_CURRENT_LIST_FILE})
  function(swept_embed output header function)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} "-DFILES=${ARGN}" -DOUTPUT=${output} -DHEADER=${header} -DFUNCTION=${function}
              -P ${swept_embed_script}
      DEPENDS ${ARGN} ${swept_embed_script}
      VERBATIM)
    # Longer than the standard asks a compiler to take; ours take it.
    set_source_files_properties(${output} PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
  endfunction()
  return()
endif()

set(text "#include \"${HEADER}\"\n\nnamespace swept {\n\nstd::string_view ${FUNCTION}(std::string_view name) {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} content)
  string(APPEND text "  if (name == \"${name}\")\n    return R\"embedded(${content})embedded\";\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace swept\n")
file(WRITE ${OUTPUT} "${text}")
