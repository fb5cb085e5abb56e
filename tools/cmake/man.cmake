# Writes the man page of `COMMAND SUBCOMMAND` (or of COMMAND itself, without SUBCOMMAND) to PAGE, by HELP2MAN.
set(name swept)
if(SUBCOMMAND)
  set(name swept-${SUBCOMMAND})
endif()
execute_process(
  COMMAND ${HELP2MAN} --no-info --locale=C.UTF-8 --version-string=${VERSION} --name=${SUMMARY}
          "${COMMAND} ${SUBCOMMAND}"
  OUTPUT_VARIABLE page COMMAND_ERROR_IS_FATAL ANY)
# The page's own name: help2man takes that of the program.
string(REPLACE ".TH SWEPT " ".TH ${name} " page "${page}")
string(REGEX REPLACE "\nswept[a-z ]* \\\\- " "\n${name} \\\\- " page "${page}")
file(WRITE ${PAGE} "${page}")
