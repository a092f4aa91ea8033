# The station's page as data of the program: the assembler takes the files as they are, so that nothing is copied into
# a source and compiling costs nothing. What npm brings is taken where deploy/page.sh has put it.
set(PALPATE_PAGE_LIBRARIES ${CMAKE_SOURCE_DIR}/build/page/node_modules CACHE PATH "three.js and uPlot, if they are there")

# palpate_page(FILE.cpp): writes the source that holds the files of master/station/page, and those libraries.
function(palpate_page source)
  set(folder ${CMAKE_SOURCE_DIR}/master/station/page)
  file(GLOB own CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.html ${folder}/*.css ${folder}/*.js ${folder}/*.svg)
  set(names "")
  set(files "")
  foreach(name IN LISTS own)
    list(APPEND names ${name})
    list(APPEND files ${folder}/${name})
  endforeach()
  set(libraries three/build/three.module.js three/build/three.core.js uplot/dist/uPlot.esm.js uplot/dist/uPlot.min.css)
  foreach(library IN LISTS libraries)
    if(EXISTS ${PALPATE_PAGE_LIBRARIES}/${library})
      cmake_path(GET library FILENAME name)
      list(APPEND names lib/${name})
      list(APPEND files ${PALPATE_PAGE_LIBRARIES}/${library})
    endif()
  endforeach()

  set(types_html "text/html; charset=utf-8")
  set(types_css "text/css; charset=utf-8")
  set(types_js "text/javascript; charset=utf-8")
  set(types_svg "image/svg+xml")
  set(data "")
  set(hashes "")
  set(declarations "")
  set(rows "")
  set(number 0)
  foreach(name file IN ZIP_LISTS names files)
    string(REGEX MATCH "[a-z]+$" type ${name})
    string(APPEND data "    \"palpate_page_${number}: .incbin \\\"${file}\\\"\\npalpate_page_${number}_end: .byte 0\\n\"\n")
    file(SHA256 ${file} hash)
    string(APPEND hashes "// ${name} ${hash}\n")
    string(APPEND declarations "extern const char palpate_page_${number}[], palpate_page_${number}_end[];\n")
    string(APPEND rows "      {\"/${name}\", \"${types_${type}}\",\n       {palpate_page_${number}, static_cast<std::size_t>(palpate_page_${number}_end - palpate_page_${number})}},\n")
    math(EXPR number "${number} + 1")
  endforeach()
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT
"// Made by cmake/PalpatePage.cmake. The hashes of the files let ccache see that one has changed.
@hashes@#include \"master/station/server/page_files.h\"

#include <array>

asm(\".pushsection .rodata\\n\"
@data@    \".popsection\\n\");
extern \"C\" {
@declarations@}

namespace palpate {

std::span<const PageFile> PageFiles() {
  static const std::array<PageFile, @number@> files{{
@rows@  }};
  return files;
}

}  // namespace palpate
")
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${files}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
endfunction()
