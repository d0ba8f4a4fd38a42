# Run by ctest with -P: each wrong call stops CMake with an error that says what is wrong.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${SCRATCH})
foreach(expected IN ITEMS
    "sources: hgros_add_components(words COMPONENTS words/Counter): no source file is given"
    "names: hgros_add_components(words SOURCES a.cpp): no component is named"
    "behind: hgros_add_components(words a.cpp COMPONENTS words/Counter): a\\.cpp belongs to nothing"
    "components: hgros_add_components(taken SOURCES a.cpp COMPONENTS words/Counter): there is already a target taken"
    "missing: hgros_add_messages(messages b.proto): b\\.proto does not exist"
    "none: hgros_add_messages(messages): no \\.proto file is given"
    "target: hgros_add_messages(taken \${file}): there is already a target taken"
    "twice: hgros_add_messages(messages \${file} \${file}): two files are imported as a\\.proto"
    "folder: hgros_add_messages(messages \${file} IMPORT_DIRS nowhere): the import folder .*nowhere does not exist"
    "protoc: hgros_add_messages(messages \${file}): protoc or the protobuf library was not found")
  string(REGEX MATCH "^([a-z]+): (.*\\)): (.*)$" matched "${expected}")
  set(wrong ${CMAKE_MATCH_1})
  set(call "${CMAKE_MATCH_2}")
  set(sentence "${CMAKE_MATCH_3}")
  execute_process(COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${SCRATCH}/${wrong} -D WRONG=${wrong}
      -D CALL=${call} -D MODULES=${MODULES}
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE text)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  if(result EQUAL 0 OR NOT text MATCHES "${sentence}")
    message(FATAL_ERROR "The wrong call \"${wrong}\" must report \"${sentence}\", but reported: ${text}")
  endif()
endforeach()
