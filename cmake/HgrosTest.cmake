include(GoogleTest)
include(CheckLinkerFlag)
# Part of GNU binutils until 2.43; links a test in less than half of the time that GNU ld takes.
check_linker_flag(CXX -fuse-ld=gold HGROS_GOLD_LINKS)
# Programs of another processor are emulated, which takes several times as long.
set(HGROS_EMULATED ${CMAKE_CROSSCOMPILING})
# For tests that are no suite of hgros_test.
set(HGROS_TEST_SECONDS 60)
if(HGROS_EMULATED)
  set(HGROS_TEST_SECONDS 300)
endif()

# hgros_test(NAME name SOURCES ... LINK targets... [ALONE sources...] [TIMEOUT seconds] [PROPERTIES ctest properties...])
# One GoogleTest suite: an executable <name>, and one ctest entry per TEST. Links static modules (hgros::base ...) or
# the shared library (hgros::hgros), never both: two copies of one module in a process would register its protobuf
# files twice. Unity builds compile the sources in ALONE separately, because their names would collide with others.
function(hgros_test)
  cmake_parse_arguments(ARG "" "NAME;TIMEOUT" "SOURCES;LINK;ALONE;PROPERTIES" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  if(HGROS_SANITIZE OR HGROS_EMULATED)
    math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * 5")
  endif()
  add_executable(${ARG_NAME} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/support/alone.cpp)
  set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_include_directories(${ARG_NAME} PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/src/include ${PROJECT_SOURCE_DIR}/tests)
    # Compiling a test takes longer than running it. ThreadSanitizer has little to gain.
  if(NOT HGROS_SANITIZE STREQUAL "thread")
    target_compile_options(${ARG_NAME} PRIVATE -O0)
  endif()
  if(HGROS_GOLD_LINKS)
    target_link_options(${ARG_NAME} PRIVATE -fuse-ld=gold)
  endif()
  if(HGROS_EMULATED)
    target_compile_definitions(${ARG_NAME} PRIVATE HGROS_EMULATED)
  endif()
  # Sanitizers store many addresses, which a program at a fixed place need not relocate whenever it starts.
  if(HGROS_SANITIZE)
    target_link_options(${ARG_NAME} PRIVATE -no-pie)
  endif()
  target_link_libraries(${ARG_NAME} PRIVATE ${ARG_LINK} hgros_warnings GTest::gmock GTest::gtest_main)
  gtest_discover_tests(${ARG_NAME} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${ARG_TIMEOUT} ${ARG_PROPERTIES})
endfunction()

# hgros_test_path(source NAME="path") defines a macro for one source of a test, which is compiled by itself. The objects
# of the other sources are then the same in every folder, so ccache has them for each checkout.
function(hgros_test_path SOURCE DEFINITION)
  set_source_files_properties(${SOURCE} PROPERTIES COMPILE_DEFINITIONS ${DEFINITION} SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
