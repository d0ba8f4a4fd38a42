# hgros_module(NAME name SOURCES ... [SMALL sources...|ALL] [DEPENDS targets...] [PRIVATE targets...])
# One module of the tree: a static library hgros_<name>, known as hgros::<name>. Its public headers are
# include/hgros/<name>/, its private ones lie beside its sources. SMALL names the sources that no message or look-up passes
# through, and those of calls: a release has them compiled for size.
function(hgros_module)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;SMALL;DEPENDS;PRIVATE" ${ARGN})
  add_library(hgros_${ARG_NAME} STATIC ${ARG_SOURCES})
  add_library(hgros::${ARG_NAME} ALIAS hgros_${ARG_NAME})
  target_include_directories(hgros_${ARG_NAME}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(hgros_${ARG_NAME} PUBLIC ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:hgros_warnings> ${ARG_PRIVATE})
  if(ARG_SMALL STREQUAL "ALL")
    target_compile_options(hgros_${ARG_NAME} PRIVATE $<$<CONFIG:Release>:-Os>)
  elseif(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT CMAKE_UNITY_BUILD)
    set_source_files_properties(${ARG_SMALL} PROPERTIES COMPILE_OPTIONS -Os)
  endif()
  set_property(GLOBAL APPEND PROPERTY HGROS_MODULES hgros_${ARG_NAME})
endfunction()

# hgros_pack_relocations(target): a shared library's relative relocations in a small part of the room, where the C
# library can read them so (glibc 2.36 and later).
include(CheckLinkerFlag)
include(CheckCXXSourceCompiles)
check_linker_flag(CXX LINKER:-z,pack-relative-relocs HGROS_LINKER_PACKS_RELOCATIONS)
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
