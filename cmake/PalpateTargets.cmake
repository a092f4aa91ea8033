# How every target is compiled, and the helpers that declare one.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

# -fPIC: the Python module is a shared library and contains the slave's libraries. One option for all, since precompiled
# headers fit only code with the same. clang calls functions as directly as without it.
add_compile_options(-pthread -fPIC)
if(PALPATE_NATIVE)
  # g++ 12 warns of its own AVX-512 headers: _mm512_undefined_pd() is uninitialised on purpose.
  add_compile_options(-march=native -Wno-uninitialized $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(PALPATE_SANITIZE)
  # PCL allocates with malloc, which Eigen does not use under the address sanitizer unless told to: one frees what the
  # other allocated.
  add_compile_options(-O1 -g1 -UNDEBUG -DPALPATE_SANITIZED -DEIGEN_MALLOC_ALREADY_ALIGNED=1
    -fsanitize=${PALPATE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${PALPATE_SANITIZE})
endif()

# Linking against a hundred shared libraries takes gold a fifth of the time that ld takes.
find_program(PALPATE_GOLD ld.gold)
if(PALPATE_GOLD)
  add_link_options(-fuse-ld=gold)
endif()

add_library(palpate_warnings INTERFACE)
target_compile_options(palpate_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow
  $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion> $<$<BOOL:${PALPATE_WERROR}>:-Werror>)
# Designated initializers name what differs from the default. Only newer clangs warn of the other fields.
include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-Wmissing-designated-field-initializers PALPATE_WARNS_OF_DESIGNATED)
if(PALPATE_WARNS_OF_DESIGNATED)
  target_compile_options(palpate_warnings INTERFACE -Wno-missing-designated-field-initializers)
endif()
if(CMAKE_UNITY_BUILD)
  # A source inside a unit looks like a header to g++, where unnamed namespaces would be a mistake.
  target_compile_options(palpate_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# g++ takes precompiled headers only for the very options they were made with; clang wants the same macros, of which
# __OPTIMIZE__ is one.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()

# palpate_precompiled(NAME HEADER LEVEL LINKS...): headers of cmake/HEADER, for targets compiled at -O0 (LEVEL O0) or above.
function(palpate_precompiled name header level)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cpp)
  palpate_level(${name} ${level})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARGN})
  target_precompile_headers(${name} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/${header})
endfunction()

# palpate_level(TARGET O0|O1|O3): the level of optimisation of a release build without sanitizers.
function(palpate_level target level)
  if(NOT PALPATE_SANITIZE AND NOT level STREQUAL O3)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-${level}>)
  endif()
endfunction()

# palpate_library(NAME SOURCES a.cpp ... LINKS x y ... [PRIVATE_LINKS ...] [OPTIONS o ...] [UNHURRIED]): one static library per
# folder; includes start at the root. A folder of headers only gives no SOURCES. UNHURRIED: no loop in real time waits for
# it: compiled at -O1, which takes a quarter less.
function(palpate_library name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "UNHURRIED" "" "SOURCES;LINKS;PRIVATE_LINKS;OPTIONS")
  if(NOT ARG_SOURCES)
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(${name} INTERFACE ${ARG_LINKS})
    return()
  endif()
  add_library(${name} STATIC ${ARG_SOURCES})
  if(ARG_UNHURRIED)
    palpate_level(${name} O1)
  endif()
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} REUSE_FROM palpate_precompiled)
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS} palpate_warnings)
endfunction()

# palpate_program(NAME SOURCES a.cpp ... LINKS x y ...): what people or tests start; the work is in its libraries.
function(palpate_program name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "SOURCES;LINKS")
  add_executable(${name} ${ARG_SOURCES})
  palpate_level(${name} O1)
  target_precompile_headers(${name} REUSE_FROM palpate_precompiled)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} palpate_warnings)
endfunction()

# palpate_test(NAME SOURCES ... LINKS ... [SLOW FILTER ...] [FULL] [OPTIMISED] [SANITIZE] [RACES] [THREADS]): one program
# of tests per module.
#   SLOW       the cases that these GoogleTest filters name run as NAME_slow, with `--full` alone
#   FULL       the whole program is built and run with `--full` alone
#   OPTIMISED  its code, or templates of libraries in it, takes longer to run at -O0 than to compile at -O1
#   SANITIZE   parses or speaks: CI runs it under the address and undefined-behaviour sanitizers, too
#   RACES      link and loop: CI runs it under the thread sanitizer, too
#   THREADS    runs threads: `--full` runs it under the thread sanitizer, too
function(palpate_test name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "FULL;OPTIMISED;SANITIZE;RACES;THREADS" "" "SOURCES;LINKS;SLOW")
  add_executable(${name} ${ARG_SOURCES})
  if(ARG_OPTIMISED OR PALPATE_SANITIZE)
    palpate_level(${name} O1)
    target_precompile_headers(${name} REUSE_FROM palpate_precompiled)
  else()
    palpate_level(${name} O0)
    target_precompile_headers(${name} REUSE_FROM palpate_precompiled_tests)
  endif()
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} palpate_test_paths GTest::gtest_main GTest::gmock palpate_warnings)

  set(labels "")
  foreach(label IN ITEMS SANITIZE RACES THREADS)
    if(ARG_${label})
      string(TOLOWER ${label} lower)
      list(APPEND labels ${lower})
      add_dependencies(${lower}_tests ${name})
    endif()
  endforeach()
  if(ARG_FULL)
    palpate_test_entry(${name} ${name} "" "slow;${labels}")
    return()
  endif()
  add_dependencies(quick_tests ${name})
  if(ARG_SLOW)
    list(JOIN ARG_SLOW ":" slow)
    palpate_test_entry(${name} ${name} "--gtest_filter=-${slow}" "${labels}")
    palpate_test_entry(${name}_slow ${name} "--gtest_filter=${slow}" slow)
    if(ARG_THREADS)
      set_tests_properties(${name}_slow PROPERTIES RUN_SERIAL TRUE)  # in real time
    endif()
  else()
    palpate_test_entry(${name} ${name} "" "${labels}")
  endif()
  # The longest first: those with most sources.
  list(LENGTH ARG_SOURCES cost)
  set_tests_properties(${name} PROPERTIES COST ${cost})
endfunction()

# palpate_test_entry(ENTRY PROGRAM ARGUMENT LABELS): one test of ctest.
function(palpate_test_entry entry program argument labels)
  add_test(NAME ${entry} COMMAND ${program} ${argument})
  # Against hanging: a busy machine or a sanitizer takes ten times as long.
  set_tests_properties(${entry} PROPERTIES TIMEOUT 7200 LABELS "${labels}")
  if(PALPATE_SANITIZE STREQUAL "thread")
    # Without a symbolizer frames have no names, and known findings in libraries are reported as ours.
    file(GLOB symbolizers /usr/bin/llvm-symbolizer*)
    set(options "suppressions=${CMAKE_SOURCE_DIR}/tests/tsan.supp")
    if(symbolizers)
      list(GET symbolizers 0 symbolizer)
      string(APPEND options " external_symbolizer_path=${symbolizer}")
    endif()
    set_tests_properties(${entry} PROPERTIES ENVIRONMENT "TSAN_OPTIONS=${options}")
  endif()
endfunction()
