# The plotting library that reports carry (MIT licence). Sets swept_plotly to the file, or to nothing: then
# reports have their tables and pictures, and say that the plots are left out.
set(SWEPT_PLOTLY "" CACHE FILEPATH "A plotly-basic.min.js for reports; left empty, npm is asked for it")

set(swept_plotly_package plotly.js-basic-dist-min)
set(swept_plotly_version 4.1.1)
set(swept_plotly_sha512
    d68345f0f790c7686fff2eeda84556283dc91b09ff30610c43c98bf47530b1aa86f451b2fce539147507bf3a9bab13789a7c19188f5a6d3884efbe42e2492331)

# Sets `output` to the library with its licence before it, or `reason` to why there is none.
function(swept_fetch_plotly output reason)
  set(folder ${PROJECT_BINARY_DIR}/${swept_plotly_package}-${swept_plotly_version})
  if(NOT EXISTS ${folder}/plotly.js)
    find_program(SWEPT_NPM npm)
    mark_as_advanced(SWEPT_NPM)
    if(NOT SWEPT_NPM)
      set(${reason} "npm was not found" PARENT_SCOPE)
      return()
    endif()
    file(MAKE_DIRECTORY ${folder})
    execute_process(
      COMMAND ${SWEPT_NPM} pack ${swept_plotly_package}@${swept_plotly_version} --silent --prefer-offline
              --fetch-retries=1 --fetch-timeout=20000
      WORKING_DIRECTORY ${folder} RESULT_VARIABLE failed ERROR_QUIET OUTPUT_QUIET TIMEOUT 60)
    set(archive ${folder}/${swept_plotly_package}-${swept_plotly_version}.tgz)
    if(failed OR NOT EXISTS ${archive})
      set(${reason} "npm pack ${swept_plotly_package}@${swept_plotly_version} failed" PARENT_SCOPE)
      return()
    endif()
    file(SHA512 ${archive} found)
    if(NOT found STREQUAL swept_plotly_sha512)
      set(${reason} "${archive} is not the package that was reviewed (SHA-512)" PARENT_SCOPE)
      return()
    endif()
    file(ARCHIVE_EXTRACT INPUT ${archive} DESTINATION ${folder})
    file(READ ${folder}/package/LICENSE licence)
    file(READ ${folder}/package/plotly-basic.min.js source)
    file(WRITE ${folder}/plotly.js "/*!\n${licence}*/\n${source}")
  endif()
  set(${output} ${folder}/plotly.js PARENT_SCOPE)
endfunction()

set(swept_plotly "")
if(SWEPT_PLOTLY)
  if(EXISTS ${SWEPT_PLOTLY})
    configure_file(${SWEPT_PLOTLY} ${PROJECT_BINARY_DIR}/given-plotly/plotly.js COPYONLY)
    set(swept_plotly ${PROJECT_BINARY_DIR}/given-plotly/plotly.js)
  else()
    message(FATAL_ERROR "SWEPT_PLOTLY: there is no file ${SWEPT_PLOTLY}")
  endif()
else()
  swept_fetch_plotly(swept_plotly swept_no_plotly)
  if(NOT swept_plotly)
    # Without npm it is a choice, and the report says it too.
    if(SWEPT_NPM)
      set(level WARNING)
    else()
      set(level STATUS)
    endif()
    message(${level} "Reports will have no plots: ${swept_no_plotly}. -DSWEPT_PLOTLY=plotly-basic.min.js gives the "
                     "library by hand.")
  endif()
endif()
