# Writes OUTPUT, a C++ source that holds the text of every file of the list SHADERS.
set(text "#include \"gpu_passes/shaders.h\"\n\nnamespace swept {\n\nstd::string_view shader_source(std::string_view name) {\n")
foreach(file IN LISTS SHADERS)
  get_filename_component(name ${file} NAME)
  file(READ ${file} source)
  string(APPEND text "  if (name == \"${name}\")\n    return R\"glsl(${source})glsl\";\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace swept\n")
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${text}" @ONLY)
