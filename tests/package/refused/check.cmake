# Run by ctest with -P: each wrong call stops CMake with an error that says what is wrong.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${SCRATCH})
foreach(expected IN ITEMS
    "sources: no source file is given"
    "names: no component is named"
    "behind: a\\.cpp belongs to nothing"
    "components: there is already a target words"
    "missing: b\\.proto does not exist"
    "none: no \\.proto file is given"
    "target: there is already a target messages"
    "twice: two files are imported as a\\.proto"
    "folder: the import folder .*nowhere does not exist"
    "protoc: protoc or the protobuf library was not found")
  string(REGEX MATCH "^[a-z]+" wrong "${expected}")
  string(REGEX REPLACE "^[a-z]+: " "" sentence "${expected}")
  execute_process(COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${SCRATCH}/${wrong} -D WRONG=${wrong}
      -D MODULES=${MODULES}
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE text)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  if(result EQUAL 0 OR NOT text MATCHES "${sentence}")
    message(FATAL_ERROR "The wrong call \"${wrong}\" must report \"${sentence}\", but reported: ${text}")
  endif()
endforeach()
