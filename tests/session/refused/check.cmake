# Run by ctest with -P: every type in no_message.cpp is refused with the one sentence, and with no other error.
execute_process(COMMAND ${COMPILER} -std=c++20 -fsyntax-only -I${INCLUDE} ${SOURCE}
  RESULT_VARIABLE result ERROR_VARIABLE said)
string(REGEX MATCHALL "error: " errors "${said}")
string(REGEX MATCHALL "error: [^\n]*This type cannot be a message\\. A message is a class that protoc" sentences "${said}")
list(LENGTH errors error_count)
list(LENGTH sentences sentence_count)
if(result EQUAL 0 OR NOT error_count EQUAL ${TYPES} OR NOT sentence_count EQUAL ${TYPES})
  message(FATAL_ERROR "Wanted ${TYPES} errors, all of them the sentence; the compiler said:\n${said}")
endif()
