# Before project(): the newest clang of those that were tried. clang compiles this in half of g++'s time. Where there is none,
# or another compiler is named, that is taken.
if(NOT CMAKE_CXX_COMPILER AND NOT DEFINED ENV{CXX})
  find_program(PALPATE_CLANG NAMES clang++-19 clang++-18 clang++-17 clang++-16)
  if(PALPATE_CLANG)
    set(CMAKE_CXX_COMPILER ${PALPATE_CLANG})
  endif()
endif()
if(NOT CMAKE_C_COMPILER AND NOT DEFINED ENV{CC})
  find_program(PALPATE_CLANG_C NAMES clang-19 clang-18 clang-17 clang-16)
  if(PALPATE_CLANG_C)
    set(CMAKE_C_COMPILER ${PALPATE_CLANG_C})
  endif()
endif()
