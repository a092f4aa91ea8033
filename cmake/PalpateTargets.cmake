# How every target is compiled, and the helpers that declare one.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

include(PalpateUnity)
include(PalpatePrecompiled)

# Clones in other folders share what was compiled: paths below the root count as relative to it. What a source includes is
# known from compiling it; to have the preprocessor tell it before is a twentieth of a cold build.
find_program(PALPATE_CCACHE ccache)
if(PALPATE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
    "CCACHE_IGNOREOPTIONS=--param=ggc-*" CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=1 CCACHE_DEPEND=1
    ${CMAKE_SOURCE_DIR}/cmake/ccache.sh)
endif()
# Left to itself g++ collects its garbage several times in each unit: a tenth of its time, to save 0.15 GB of 1.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=800000>)

# One way of compiling for all that takes what was precompiled.
add_compile_options(-pthread)

if(PALPATE_NATIVE)
  # g++ 12 warns of its own AVX-512 headers: _mm512_undefined_pd() is uninitialised on purpose.
  add_compile_options(-march=native -Wno-uninitialized $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(PALPATE_SANITIZE)
  # Eigen does not trust the address sanitizer's malloc; libraries that stay as released do, and both free what the
  # other took.
  add_compile_options(-O${PALPATE_SANITIZE_LEVEL} -g$<BOOL:${PALPATE_SANITIZE_LINES}> -UNDEBUG -DPALPATE_SANITIZED -DEIGEN_MALLOC_ALREADY_ALIGNED=1 -fsanitize=${PALPATE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(PALPATE_SANITIZE_PASS_OVER)
    # Named from the build's folder: other clones have it there too.
    add_compile_options(-fsanitize-ignorelist=../../${PALPATE_SANITIZE_PASS_OVER})
  endif()
  add_link_options(-fsanitize=${PALPATE_SANITIZE})
  if(PALPATE_SANITIZE_EXCEPT)
    add_compile_options(-fno-sanitize=${PALPATE_SANITIZE_EXCEPT})
  endif()
endif()

# Linking against a hundred shared libraries takes gold a fifth of the time that ld takes.
find_program(PALPATE_GOLD ld.gold)
if(PALPATE_GOLD)
  add_link_options(-fuse-ld=gold)
endif()

add_library(palpate_warnings INTERFACE)
# Instrumented code makes g++ 12 see what is not there: only what is compiled as for the release must be without warnings.
set(palpate_werror $<BOOL:${PALPATE_WERROR}>)
if(PALPATE_SANITIZE)
  set(palpate_werror $<AND:${palpate_werror},$<BOOL:$<TARGET_PROPERTY:PALPATE_AS_RELEASED>>>)
endif()
target_compile_options(palpate_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow
  $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion> $<${palpate_werror}:-Werror>)
if(PALPATE_UNITY)
  # A source inside a unit looks like a header to the compiler, where unnamed namespaces would be a mistake.
  target_compile_options(palpate_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# palpate_compiled_like(TARGET WAY): RELEASED: as it is released, whatever the sanitizers; BUILT: as this build compiles.
function(palpate_compiled_like target way)
  if(way STREQUAL RELEASED AND PALPATE_SANITIZE)
    set_target_properties(${target} PROPERTIES COMPILE_OPTIONS "-pthread" PALPATE_AS_RELEASED ON)
    palpate_take_precompiled(${target} palpate_precompiled)
  elseif(PALPATE_SANITIZE)
    palpate_take_precompiled(${target} palpate_precompiled_watched)
  else()
    palpate_take_precompiled(${target} palpate_precompiled)
  endif()
endfunction()

# What waits for people or runs once is compiled at -O1: that takes a quarter less.
function(palpate_unhurried target)
  get_target_property(as_released ${target} PALPATE_AS_RELEASED)
  if(NOT PALPATE_SANITIZE OR as_released)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()

# The code of tests is compiled at -O0, which takes less than half of the time of -O1. What they call is compiled as ever.
function(palpate_untuned target)
  if(NOT PALPATE_SANITIZE OR NOT PALPATE_SANITIZE_TESTS)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
  endif()
endfunction()

# palpate_released(NAME OUT): whether the library NAME of this folder is taken from the build PALPATE_RELEASED. Declares it then.
function(palpate_released name out)
  set(${out} FALSE PARENT_SCOPE)
  if(PALPATE_RELEASED AND NOT PALPATE_SANITIZE_NUMERIC)
    file(RELATIVE_PATH folder ${CMAKE_BINARY_DIR} ${CMAKE_CURRENT_BINARY_DIR})
    add_library(${name} STATIC IMPORTED GLOBAL)
    set_target_properties(${name} PROPERTIES IMPORTED_LOCATION ${PALPATE_RELEASED}/${folder}/lib${name}.a)
    set(${out} TRUE PARENT_SCOPE)
  endif()
endfunction()

# palpate_library(NAME SOURCES a.cpp ... LINKS x y ... [OPTIONS o ...] [NUMERIC] [UNHURRIED]): one static library per folder;
# includes start at the root. A folder of headers only gives no SOURCES. NUMERIC: computes or simulates; it parses nothing that
# others sent and does not speak. Unless PALPATE_SANITIZE_NUMERIC, sanitizers leave it as it is released: most of compiling is
# there. UNHURRIED: no loop in real time waits for it.
function(palpate_library name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "NUMERIC;UNHURRIED" "" "SOURCES;APART;LINKS;PRIVATE_LINKS;OPTIONS")
  if(NOT ARG_SOURCES)
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(${name} INTERFACE ${ARG_LINKS})
    return()
  endif()
  if(ARG_NUMERIC)
    palpate_released(${name} released)
    if(released)
      target_include_directories(${name} INTERFACE ${CMAKE_SOURCE_DIR})
      target_link_libraries(${name} INTERFACE ${ARG_LINKS} ${ARG_PRIVATE_LINKS})
      return()
    endif()
  endif()
  palpate_units(${name} units SOURCES ${ARG_SOURCES} APART ${ARG_APART})
  add_library(${name} STATIC ${units})
  if(ARG_NUMERIC AND NOT PALPATE_SANITIZE_NUMERIC)
    palpate_compiled_like(${name} RELEASED)
  else()
    palpate_compiled_like(${name} BUILT)
  endif()
  if(ARG_UNHURRIED)
    palpate_unhurried(${name})
  endif()
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS} palpate_warnings)
endfunction()

# palpate_program(NAME SOURCES a.cpp ... LINKS x y ... [FULL]): what people or tests start; the work is in its libraries.
# FULL: built by `--full`, or where it is named.
function(palpate_program name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "FULL" "" "SOURCES;LINKS")
  palpate_units(${name} units SOURCES ${ARG_SOURCES})
  add_executable(${name} ${units})
  if(ARG_FULL AND NOT PALPATE_FULL_TESTS)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  if(PALPATE_SANITIZE_NUMERIC)
    palpate_compiled_like(${name} BUILT)
  else()
    palpate_compiled_like(${name} RELEASED)
  endif()
  palpate_unhurried(${name})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} palpate_warnings)
endfunction()

# palpate_test(NAME SOURCES ... LINKS ... [LABELS ...] [SLOW FILTER] [ALONE FILTER] [FULL] [SANITIZE] [THREADS] [RACES] [COMPUTES]): one test
# executable per folder of tests, run by ctest as NAME. Those of its tests that a GoogleTest FILTER names are run as NAME_slow, with the
# label `slow`: `tests/run.sh --full` alone runs them. Those that a FILTER names ALONE run in real time: as NAME_alone, beside no other test. SANITIZE: parses or speaks, so that every
# `tests/run.sh` runs it under the address and undefined-behaviour sanitizers too; with `--full` they run everything.
# FULL: of what no session runs on (simulated worlds, training, reports of studies), or long sweeps: built and run by `--full`. THREADS: runs threads, which `--full` has the thread sanitizer watch. RACES: so does every `tests/run.sh`.
# COMPUTES: its own code, or templates of libraries in it, takes longer to run at -O0 than to compile at -O1.
# PALPATE_SANITIZED_APART: tests with SANITIZE or RACES are left out here, because the sanitizers' builds run them.
# PALPATE_SANITIZE_TESTS off: what tests call is watched, their own code is not.
function(palpate_test name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "FULL;SANITIZE;THREADS;RACES;COMPUTES" "SLOW;ALONE" "SOURCES;APART;LINKS;LABELS")
  if((PALPATE_SANITIZED_APART AND NOT PALPATE_SANITIZE AND (ARG_SANITIZE OR ARG_RACES)) OR (ARG_FULL AND NOT PALPATE_FULL_TESTS))
    return()
  endif()
  palpate_units(${name} units SOURCES ${ARG_SOURCES} APART ${ARG_APART})
  add_executable(${name} ${units})
  if(NOT ARG_COMPUTES)
    palpate_take_precompiled(${name} palpate_precompiled_tests)
  endif()
  if(PALPATE_SANITIZE AND NOT PALPATE_SANITIZE_TESTS)
    set_target_properties(${name} PROPERTIES COMPILE_OPTIONS "-pthread;-Wno-missing-field-initializers" PALPATE_AS_RELEASED ON)
  endif()
  if(ARG_COMPUTES)
    palpate_unhurried(${name})
  else()
    palpate_untuned(${name})
  endif()
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} palpate_test_paths GTest::gtest_main GTest::gmock palpate_warnings)
  if(ARG_SANITIZE)
    list(APPEND ARG_LABELS sanitize)
    add_dependencies(sanitized_tests ${name})
  endif()
  if(ARG_THREADS OR ARG_RACES)
    list(APPEND ARG_LABELS threads)
    add_dependencies(threaded_tests ${name})
  endif()
  if(ARG_RACES)
    list(APPEND ARG_LABELS races)
    add_dependencies(raced_tests ${name})
  endif()
  set(timeout 1800)  # against hanging: a busy machine takes ten times as long
  set(apart ${ARG_SLOW} ${ARG_ALONE})
  if(apart)
    list(JOIN apart ":" apart)
    palpate_test_entry(${name} ${name} "--gtest_filter=-${apart}" ${timeout} "${ARG_LABELS}")
  else()
    palpate_test_entry(${name} ${name} "" ${timeout} "${ARG_LABELS}")
  endif()
  if(ARG_SLOW)
    palpate_test_entry(${name}_slow ${name} "--gtest_filter=${ARG_SLOW}" 7200 "slow")
  endif()
  if(ARG_ALONE)
    palpate_test_entry(${name}_alone ${name} "--gtest_filter=${ARG_ALONE}" ${timeout} "${ARG_LABELS}")
    set_tests_properties(${name}_alone PROPERTIES RUN_SERIAL TRUE)
  endif()
endfunction()

function(palpate_test_entry entry program filter timeout labels)
  add_test(NAME ${entry} COMMAND ${program} ${filter})
  if(PALPATE_SANITIZE)
    math(EXPR timeout "10 * ${timeout}")  # instrumented code takes its time
  endif()
  set_tests_properties(${entry} PROPERTIES TIMEOUT ${timeout} LABELS "${labels}")
  if(PALPATE_SANITIZE STREQUAL "thread")
    # Without a symbolizer frames have no names, and what is known of the libraries is told as ours.
    find_program(PALPATE_SYMBOLIZER NAMES llvm-symbolizer-16 llvm-symbolizer)
    set(options "suppressions=${CMAKE_SOURCE_DIR}/tests/tsan.supp")
    if(PALPATE_SYMBOLIZER)
      string(APPEND options " external_symbolizer_path=${PALPATE_SYMBOLIZER}")
    endif()
    set_tests_properties(${entry} PROPERTIES ENVIRONMENT "TSAN_OPTIONS=${options}")
  endif()
endfunction()
