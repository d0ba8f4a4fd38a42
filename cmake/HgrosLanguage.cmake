# What the suites of the languages in tests/ share.

# hgros_language_tests(suite SOURCES source... COMMAND word... [ENVIRONMENT variable...] [PROPERTIES property value...])
# An entry of ctest for the tests of each source, or of whatever else names tests: SUITE.STEM. Starting an interpreter takes
# longer than most tests. In COMMAND @source@ is the file and @stem@ its name without the extension. A source without tests
# must fail.
function(hgros_language_tests SUITE)
  cmake_parse_arguments(ARG "" "" "SOURCES;COMMAND;ENVIRONMENT;PROPERTIES" ${ARGN})
  math(EXPR seconds "3 * ${HGROS_TEST_SECONDS}")
  foreach(source IN LISTS ARG_SOURCES)
    cmake_path(GET source STEM stem)
    string(CONFIGURE "${ARG_COMMAND}" command @ONLY)
    add_test(NAME ${SUITE}.${stem} COMMAND ${command})
    set_tests_properties(${SUITE}.${stem} PROPERTIES ENVIRONMENT "${ARG_ENVIRONMENT}" TIMEOUT ${seconds} ${ARG_PROPERTIES})
  endforeach()
endfunction()

# hgros_readme_source(language program source): a program of the page of the language's binding.
function(hgros_readme_source LANGUAGE PROGRAM SOURCE)
  set(extract ${PROJECT_SOURCE_DIR}/tests/readme/extract.py)
  set(page ${PROJECT_SOURCE_DIR}/bindings/${LANGUAGE}/README.md)
  add_custom_command(OUTPUT ${SOURCE}
    COMMAND Python3::Interpreter -B ${extract} ${page} ${LANGUAGE}_${PROGRAM} ${SOURCE}
    DEPENDS ${extract} ${page} VERBATIM)
endfunction()

# hgros_program(file word...): a program that runs the command.
function(hgros_program FILE)
  list(JOIN ARGN "' '" command)
  file(GENERATE OUTPUT ${FILE} CONTENT "#!/bin/sh\nexec '${command}'\n"
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endfunction()

# hgros_readme_scripts(suite language extension word...): a test of the page's programs, which the command runs as they are.
function(hgros_readme_scripts SUITE LANGUAGE EXTENSION)
  set(sources)
  foreach(program IN ITEMS publisher subscriber)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${program}.${EXTENSION})
    hgros_readme_source(${LANGUAGE} ${program} ${source})
    list(APPEND sources ${source})
    hgros_program(${CMAKE_CURRENT_BINARY_DIR}/${program} ${ARGN} ${source})
  endforeach()
  add_custom_target(hgros_${LANGUAGE}_readme ALL DEPENDS ${sources})
  hgros_readme_test(${SUITE} ${CMAKE_CURRENT_BINARY_DIR}/publisher ${CMAKE_CURRENT_BINARY_DIR}/subscriber)
endfunction()

# hgros_readme_test(suite publisher subscriber): runs the two programs of the page as their reader does.
function(hgros_readme_test SUITE PUBLISHER SUBSCRIBER)
  add_test(NAME ${SUITE}.ReadmePublisherAndSubscriber
    COMMAND Python3::Interpreter -B ${PROJECT_SOURCE_DIR}/tests/readme/pair.py
      ${PUBLISHER} published ${SUBSCRIBER} "Hello")
endfunction()

# hgros_example_test(suite line PUBLISHER word... SUBSCRIBER word...)
# The subscriber knows the type from the channel alone, and prints the line. It ends after five messages, or the test
# times out.
function(hgros_example_test SUITE LINE)
  cmake_parse_arguments(ARG "" "" "PUBLISHER;SUBSCRIBER" ${ARGN})
  list(JOIN ARG_PUBLISHER "' '" publisher)
  list(JOIN ARG_SUBSCRIBER "' '" subscriber)
  string(TOLOWER ${SUITE} domain)
  add_test(NAME ${SUITE}.ExamplePublisherAndSubscriber COMMAND sh -c
    "export HGROS_DOMAIN=${domain}-examples-$$; '${publisher}' & '${subscriber}' greetings 5 && wait $!")
  set_tests_properties(${SUITE}.ExamplePublisherAndSubscriber PROPERTIES PASS_REGULAR_EXPRESSION "${LINE}")
endfunction()
