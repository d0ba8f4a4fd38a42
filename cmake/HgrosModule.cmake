# hgros_module(NAME name SOURCES ... [SMALL sources...|ALL] [DEPENDS targets...] [PRIVATE targets...])
# One module of the tree: a static library hgros_<name>, known as hgros::<name>. Its public headers are
# include/hgros/<name>/ and include/hgros/internal/<name>/, those that only other modules include src/include/hgros/<name>/;
# its private ones lie beside its sources. SMALL names the sources that no message or lookup
# passes through: a release compiles them for size, as a library of objects of their own.
function(hgros_module)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;SMALL;DEPENDS;PRIVATE" ${ARGN})
  set(target hgros_${ARG_NAME})
  if(ARG_SMALL STREQUAL "ALL")
    set(ARG_SMALL ${ARG_SOURCES})
  endif()
  foreach(source IN LISTS ARG_SMALL)
    if(NOT source IN_LIST ARG_SOURCES)
      message(FATAL_ERROR "hgros_module(${ARG_NAME}): ${source} is in SMALL, but not in SOURCES.")
    endif()
  endforeach()
  set(parts ${target})
  if(CMAKE_BUILD_TYPE STREQUAL "Release" AND ARG_SMALL)
    list(REMOVE_ITEM ARG_SOURCES ${ARG_SMALL})
    add_library(${target}_small OBJECT ${ARG_SMALL})
    target_compile_options(${target}_small PRIVATE -Os)
    list(APPEND parts ${target}_small)
    list(APPEND ARG_SOURCES $<TARGET_OBJECTS:${target}_small>)
  endif()
  add_library(${target} STATIC ${ARG_SOURCES})
  if(ARG_SMALL AND ARG_SMALL STREQUAL ARG_SOURCES)  # Never in a release, which has them as objects.
    target_compile_options(${target} PRIVATE ${HGROS_COMPILES_FAST})
  endif()
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
  add_library(hgros::${ARG_NAME} ALIAS ${target})
  foreach(part IN LISTS parts)
    target_include_directories(${part}
      PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
      PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/src/include)
    target_link_libraries(${part} PUBLIC ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:hgros_warnings> ${ARG_PRIVATE})
  endforeach()
  set_property(GLOBAL APPEND PROPERTY HGROS_MODULES ${target})
  set_property(GLOBAL APPEND PROPERTY HGROS_MODULE_PARTS ${parts})
endfunction()

# hgros_pack_relocations(target): a shared library's relative relocations in a small part of the room, where the C
# library can read them so (glibc 2.36 and later).
include(CheckLinkerFlag)
include(CheckCXXSourceCompiles)
# For other processors than those of x86 the linker only warns.
check_linker_flag(CXX LINKER:--fatal-warnings,-z,pack-relative-relocs HGROS_LINKER_PACKS_RELOCATIONS)
check_cxx_source_compiles("#include <features.h>
  #if !__GLIBC_PREREQ(2, 36)
  #error too old
  #endif
  int main() { return 0; }" HGROS_LIBC_READS_PACKED_RELOCATIONS)
function(hgros_pack_relocations target)
  if(HGROS_LINKER_PACKS_RELOCATIONS AND HGROS_LIBC_READS_PACKED_RELOCATIONS)
    target_link_options(${target} PRIVATE LINKER:-z,pack-relative-relocs)
  endif()
endfunction()
