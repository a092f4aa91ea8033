# Writes OUT, the unit that knows the version: RELEASE, and the commit of SOURCE unless it is that of the tag vRELEASE.
# Untouched if it says so already.
execute_process(COMMAND git -C ${SOURCE} describe --always --exclude=* --abbrev=8 --dirty=.changed
  OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND git -C ${SOURCE} describe --tags --exact-match --match v${RELEASE} --dirty=.changed
  OUTPUT_VARIABLE tag ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
set(version ${RELEASE})
if(commit AND NOT tag STREQUAL "v${RELEASE}")
  string(APPEND version "+${commit}")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
#include "shared/program/program.h"

const char* palpate::Version() {
  return "@version@";
}
]])
