# SPDX-License-Identifier: GPL-3.0-only
# embed_texts(TARGET FOLDER): compiles the files FOLDER/*.html into a target, where embeddedText() of host/help.h finds them by
# their names without ending. A changed file makes CMake run again.

function(embed_texts TARGET FOLDER)
  file(GLOB files CONFIGURE_DEPENDS ${FOLDER}/*.html)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(cases "")
  foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} text)
    string(APPEND cases "  if (name == \"${name}\") return R\"html(${text})html\";\n")
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${TARGET}_texts.cpp)
  file(GENERATE OUTPUT ${source} CONTENT "// Made by cmake/EmbedTexts.cmake of ${FOLDER}.
#include \"host/help.h\"

std::string sphere_propagation::host::embeddedText(const std::string& name) {
${cases}  return {};
}
")
  target_sources(${TARGET} PRIVATE ${source})
  set_source_files_properties(${source} PROPERTIES GENERATED ON SKIP_AUTOMOC ON)
endfunction()
