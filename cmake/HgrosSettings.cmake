# Compiler settings that every target of this tree shares.
include(GNUInstallDirs)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

# With ccache a rebuild after a branch switch takes seconds. Nothing else depends on it.
if(PROJECT_IS_TOP_LEVEL AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(HGROS_CCACHE ccache)
  if(HGROS_CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${HGROS_CCACHE})
  endif()
endif()

# With one section per function the linker drops functions that no exported symbol reaches.
add_compile_options(-ffunction-sections -fdata-sections)

add_library(hgros_warnings INTERFACE)
target_compile_options(hgros_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor
                                                -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 falsely reports overlapping copies in std::string's operator+ (GCC bug 105651).
  target_compile_options(hgros_warnings INTERFACE -Wno-restrict)
endif()

if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  target_compile_options(hgros_warnings INTERFACE -Wno-ambiguous-reversed-operator)  # Iterators of RapidJSON 1.1.
endif()

if(HGROS_SANITIZE)
  add_compile_options(-fsanitize=${HGROS_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${HGROS_SANITIZE})
endif()
if(HGROS_SANITIZE MATCHES "address" AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  add_compile_definitions(__SANITIZE_ADDRESS__)  # As GCC defines it.
  # Programs in C need what checks the library's C++.
  add_link_options("$<$<LINK_LANGUAGE:C>:SHELL:-fsanitize-link-c++-runtime -Wl,--no-as-needed -lstdc++>")
endif()
# For sources that no message passes through. Instrumented, clang compiles them in half the time without optimization. For
# all sources, the tests would lose more time than that.
set(HGROS_COMPILES_FAST)
if(HGROS_SANITIZE MATCHES "address")
  set(HGROS_COMPILES_FAST -O0)
endif()
if(HGROS_SANITIZE MATCHES "undefined")
  # oneTBB 2021.8 ends a flow-graph task's life and then casts its address to free it (_flow_graph_impl.h, finalize).
  add_compile_options(-fno-sanitize=vptr)
endif()
if(HGROS_SANITIZE MATCHES "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC warns about every fence, because ThreadSanitizer does not model fences. The suites still run.
  add_compile_options(-Wno-tsan)
endif()
if(HGROS_BUILD_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "The fuzz targets need clang: libFuzzer comes with it. Use the preset `asan`, in a folder that no other compiler has used.")
  endif()
  # The coverage that guides libFuzzer must be in the library, not only in the target.
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
