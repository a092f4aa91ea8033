# Writes OUT, the unit that knows the version: RELEASE and the commit of SOURCE. Untouched if it says so already.
execute_process(COMMAND git -C ${SOURCE} describe --always --exclude=* --abbrev=8 --dirty=.changed
  OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
set(version ${RELEASE})
if(commit)
  string(APPEND version "+${commit}")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
#include "shared/program/program.h"

const char* palpate::Version() {
  return "@version@";
}
]])
