include(CheckLinkerFlag)
find_package(Python3 REQUIRED COMPONENTS Interpreter)  # Many tests in the folders below use it.
# These link a test in less than half of the time that GNU ld takes. gold, part of GNU binutils until 2.43, warns about
# what clang's AddressSanitizer exports.
set(HGROS_LINKER gold)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(HGROS_LINKER lld)
endif()
check_linker_flag(CXX -fuse-ld=${HGROS_LINKER} HGROS_LINKS_FAST)
# Programs of another processor are emulated, which takes several times as long.
set(HGROS_EMULATED ${CMAKE_CROSSCOMPILING})
# Compiling a test takes longer than running it, and clang without optimization needs half to two thirds of the time of g++.
# So clang compiles the tests if it is installed, and g++ what they test. With sanitizers, one compiler compiles all.
if(NOT HGROS_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  find_program(HGROS_TEST_COMPILER clang++)
endif()
# How long a test may take, in seconds: at least three times as long as anything that it waits for (kPatience in
# tests/support/await.hpp). Those of suites, below, take this too.
set(HGROS_TEST_SECONDS 180)
if(HGROS_SANITIZE)
  set(HGROS_TEST_SECONDS 360)
elseif(HGROS_EMULATED)
  set(HGROS_TEST_SECONDS 600)
endif()

# Every test has the label of its suite, a folder in tests/, and one that says what its result depends on:
#   pure    nothing: one process, no thread that it waits for, no clock. It never runs again: a failure is a fault.
#   timed   threads or time
#   system  other processes, network namespaces, compilers, a display
# Most tests that take ten seconds or more, flood, or try what others try with more participants, have the label `deep` as
# well: `./dev check`.
#
# hgros_suite_label(variable): the label of the suite in whose folder this is called.
function(hgros_suite_label variable)
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR}/tests OUTPUT_VARIABLE folder)
  string(REGEX REPLACE "/.*" "" folder "${folder}")
  set(${variable} ${folder} PARENT_SCOPE)
endfunction()

# hgros_discover(target label [TIMED|SYSTEM|DEEP|SERIAL|NETWORK name...] [PROPERTIES ctest properties...])
# Entries of ctest for the tests of a GoogleTest program, with the label: one for each suite, since starting a process
# takes longer than most tests, or one for each test of a program labelled system, except in suites that SYSTEM or TIMED
# names. The lists name tests that are timed, system or deep, that run while no other test runs (SERIAL), or one after another
# because they make network namespaces (NETWORK). A name is that of a suite, or a regular expression for the beginning of
# suite.test; a test that is deep, SERIAL or NETWORK has its own entry. TIMED and SYSTEM name whole suites. The name of a
# suite is that of one program only. Values of PROPERTIES have no spaces. The targets tests_pure, tests_timed and
# tests_<suite> build the program.
set(HGROS_TEST_LISTS TIMED SYSTEM DEEP SERIAL NETWORK)
function(hgros_discover TARGET LABEL)
  cmake_parse_arguments(ARG "" "" "${HGROS_TEST_LISTS};PROPERTIES" ${ARGN})
  hgros_suite_label(suite)
  set(ARG_ALONE ${ARG_DEEP} ${ARG_SERIAL} ${ARG_NETWORK})
  foreach(list IN LISTS HGROS_TEST_LISTS ITEMS ALONE)
    list(TRANSFORM ARG_${list} REPLACE "^[^.]+$" "\\0[.]")
    list(JOIN ARG_${list} "|" names)
    set(${list} "^$")
    if(names)
      set(${list} "^(.*/)?(${names})")
    endif()
  endforeach()
  list(JOIN ARG_PROPERTIES " " properties)
  set(excluded "^$")
  if(HGROS_EMULATED)
    file(STRINGS ${PROJECT_SOURCE_DIR}/tests/arm64/excluded.txt excluded REGEX "^[^#]")
    list(TRANSFORM excluded REPLACE "  # .*" "")
    list(JOIN excluded "|" excluded)
  endif()
  # The names are known when ctest starts, so a script adds them then.
  set(script ${CMAKE_CURRENT_BINARY_DIR}/${TARGET}_tests.cmake)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/HgrosTests.cmake.in ${script} @ONLY)
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${script})
  set(groups ${LABEL} ${suite})
  if(ARG_TIMED)
    list(APPEND groups timed)
  endif()
  foreach(group IN LISTS groups)
    if(NOT TARGET tests_${group})
      add_custom_target(tests_${group})
    endif()
    add_dependencies(tests_${group} ${TARGET})
  endforeach()
endfunction()

# hgros_label_tests(label...): more labels for all tests that this folder has added with add_test, and their time.
function(hgros_label_tests)
  hgros_suite_label(suite)
  get_property(tests DIRECTORY PROPERTY TESTS)
  foreach(test IN LISTS tests)
    set_property(TEST ${test} APPEND PROPERTY LABELS ${ARGN} ${suite})
    get_property(seconds TEST ${test} PROPERTY TIMEOUT)
    if(NOT seconds)
      set_property(TEST ${test} PROPERTY TIMEOUT ${HGROS_TEST_SECONDS})
    endif()
  endforeach()
endfunction()

# hgros_deep(program...): only deep tests use these programs, so the target `all` does not build them, but `tests_deep` does.
function(hgros_deep)
  set_target_properties(${ARGN} PROPERTIES EXCLUDE_FROM_ALL ON)
  if(NOT TARGET tests_deep)
    add_custom_target(tests_deep)
  endif()
  add_dependencies(tests_deep ${ARGN})
endfunction()

# hgros_test(NAME name LABEL label SOURCES ... LINK targets... [PATHS name=path...]
#            [TIMED|SYSTEM|DEEP|SERIAL|NETWORK name...] [PROPERTIES ctest properties...])
# One GoogleTest suite: an executable <name>, and its tests (hgros_discover). Links static modules (hgros::base ...) or
# the shared library (hgros::hgros), never both: two copies of one module in a process would register its protobuf
# files twice. The test gets a path by test::Path(name) of tests/support/path.hpp. Paths are in a file beside the program, so
# that objects are the same in each checkout and ccache has them. Sources are compiled in groups: a name that another source
# of the program uses too needs a namespace, that of the file.
function(hgros_test)
  cmake_parse_arguments(ARG "" "NAME;LABEL" "SOURCES;LINK;PATHS;${HGROS_TEST_LISTS};PROPERTIES" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/support/alone.cpp)
  target_include_directories(${ARG_NAME} PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/src/include ${PROJECT_SOURCE_DIR}/tests)
  if(HGROS_BUILD_FUZZ)
    target_compile_options(${ARG_NAME} PRIVATE -fno-sanitize=fuzzer-no-link)  # Only the library's coverage guides it.
  endif()
  if(HGROS_LINKS_FAST)
    target_link_options(${ARG_NAME} PRIVATE -fuse-ld=${HGROS_LINKER})
  endif()
  if(HGROS_EMULATED)
    target_compile_definitions(${ARG_NAME} PRIVATE HGROS_EMULATED)
  endif()
  # Sanitizers store many addresses, which a program at a fixed place need not relocate whenever it starts.
  if(HGROS_SANITIZE)
    target_link_options(${ARG_NAME} PRIVATE -no-pie)
  endif()
  target_link_libraries(${ARG_NAME} PRIVATE ${ARG_LINK} hgros_warnings GTest::gmock GTest::gtest_main)
  if(ARG_PATHS)
    list(JOIN ARG_PATHS "\n" paths)
    file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${ARG_NAME}.paths CONTENT "${paths}\n")
    target_sources(${ARG_NAME} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/path.cpp)
  endif()
  set(filters)
  foreach(list IN LISTS HGROS_TEST_LISTS)
    list(APPEND filters ${list} ${ARG_${list}})
  endforeach()
  hgros_discover(${ARG_NAME} ${ARG_LABEL} ${filters} PROPERTIES ${ARG_PROPERTIES})
endfunction()
