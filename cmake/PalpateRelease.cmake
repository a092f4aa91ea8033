# palpate_release(FALLBACK OUT): the release of these sources: the newest tag vX.Y.Z that the commit contains, or FALLBACK
# without git or tags.
function(palpate_release fallback out)
  execute_process(COMMAND git -C ${CMAKE_SOURCE_DIR} describe --tags --match v[0-9]* --abbrev=0
    OUTPUT_VARIABLE tag ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(tag MATCHES "^v([0-9]+\\.[0-9]+\\.[0-9]+)$")
    set(${out} ${CMAKE_MATCH_1} PARENT_SCOPE)
  else()
    set(${out} ${fallback} PARENT_SCOPE)
  endif()
endfunction()
