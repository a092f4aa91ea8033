# Headers that most sources include are parsed once: half of compiling is there. One set for each way of compiling, since
# a set fits only what is compiled as it was.
option(PALPATE_PRECOMPILED "Parse the headers of most sources once (clang)" OFF)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(PALPATE_PRECOMPILED OFF)
endif()

# palpate_precompiled(NAME HEADER [AS_RELEASED] [UNTUNED] LINKS ...): what targets take with palpate_take_precompiled(TARGET NAME).
function(palpate_precompiled name header)
  cmake_parse_arguments(PARSE_ARGV 2 ARG "AS_RELEASED;UNTUNED" "" "LINKS")
  if(NOT PALPATE_PRECOMPILED)
    return()
  endif()
  set(unit ${CMAKE_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${unit} CONTENT "" @ONLY)
  add_library(${name} OBJECT ${unit})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
  if(ARG_AS_RELEASED AND PALPATE_SANITIZE)
    set_target_properties(${name} PROPERTIES COMPILE_OPTIONS "-pthread")
  endif()
  if(ARG_UNTUNED)
    palpate_untuned(${name})
  endif()
  target_precompile_headers(${name} PRIVATE <${header}>)  # so that what CMake writes names no clone's folder
  # For ccache, whose clones hold the same below other paths: what the headers are, not how their folder is called.
  target_compile_options(${name} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")
  file(SHA256 ${CMAKE_SOURCE_DIR}/${header} text)
  file(SHA256 ${CMAKE_SOURCE_DIR}/cmake/precompiled.h common)
  file(SHA256 ${CMAKE_SOURCE_DIR}/cmake/precompiled_types.h types)
  get_target_property(options ${name} COMPILE_OPTIONS)
  string(GENEX_STRIP "${options}" options)
  string(SHA256 sum "${text} ${common} ${types} ${options} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_COMPILER_VERSION} ${Eigen3_VERSION}
    ${OpenCV_VERSION} ${nlohmann_json_VERSION} ${GTest_VERSION}")
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${name}.dir/cmake_pch.hxx.pch.sum CONTENT "${sum}" @ONLY)
endfunction()

function(palpate_take_precompiled target name)
  if(PALPATE_PRECOMPILED)
    target_precompile_headers(${target} REUSE_FROM ${name})
    # ccache has the preprocessor find them once more.
    target_include_directories(${target} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIR})
  endif()
endfunction()
