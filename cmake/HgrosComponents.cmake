# Adds to the list `found` the shared libraries of this build among the given ones, and among those that these link.
# `seen`: a list of those that were looked at.
function(_hgros_own_libraries found seen)
  set(own ${${found}})
  set(looked_at ${${seen}})
  foreach(library IN LISTS ARGN)
    if(NOT TARGET "${library}" OR library MATCHES "^hgros::" OR library IN_LIST looked_at)
      continue()
    endif()
    list(APPEND looked_at ${library})
    get_target_property(aliased ${library} ALIASED_TARGET)
    get_target_property(imported ${library} IMPORTED)
    get_target_property(kind ${library} TYPE)
    if(aliased)
      _hgros_own_libraries(own looked_at ${aliased})
    elseif(NOT imported)
      if(kind STREQUAL "SHARED_LIBRARY")
        list(APPEND own ${library})
      endif()
      foreach(property IN ITEMS LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
        get_target_property(links ${library} ${property})
        if(links)
          _hgros_own_libraries(own looked_at ${links})
        endif()
      endforeach()
    endif()
  endforeach()
  set(${found} ${own} PARENT_SCOPE)
  set(${seen} ${looked_at} PARENT_SCOPE)
endfunction()

# hgros_add_components(TARGET SOURCES file.cpp ... COMPONENTS package/Name ... [LINK library ...] [NO_INSTALL])
#
# Creates a shared library TARGET with components: classes that the sources name with HGROS_COMPONENT(Class,
# "package/Name"). COMPONENTS lists these names. After linking, `hgros components` checks that the library has each of them
# and can make it.
#
# Without NO_INSTALL it is installed with the shared libraries of this build that it links, such as one of
# hgros_add_messages, in one folder. The check is repeated there.
#
# Writes a manifest, by which programs find the library: share/hgros/components/TARGET.yaml in the build folder, with the
# path of the library there, and, without NO_INSTALL, in the install prefix. Programs find the first one if its folder is in HGROS_COMPONENT_PATH.
#
#     find_package(hgros REQUIRED)
#     hgros_add_components(words SOURCES counter.cpp source.cpp COMPONENTS words/Counter words/Source)
function(hgros_add_components target)
  include(GNUInstallDirs)
  cmake_parse_arguments(PARSE_ARGV 1 arg "NO_INSTALL" "" "SOURCES;COMPONENTS;LINK")
  set(call "hgros_add_components(${target})")
  if(TARGET ${target})
    message(FATAL_ERROR "${call}: there is already a target ${target}. Give one of them another name.")
  endif()
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "${call}: ${arg_UNPARSED_ARGUMENTS} belongs to nothing. Put source files behind SOURCES, names "
      "behind COMPONENTS and libraries behind LINK.")
  endif()
  if(NOT arg_SOURCES)
    message(FATAL_ERROR "${call}: no source file is given. List at least one behind SOURCES.")
  endif()
  if(NOT arg_COMPONENTS)
    message(FATAL_ERROR "${call}: no component is named. List the names of its HGROS_COMPONENT behind COMPONENTS.")
  endif()

  add_library(${target} SHARED ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE hgros::hgros ${arg_LINK})

  # A program of another architecture cannot run here; without the command there is nothing to check with.
  set(checks OFF)
  if(TARGET hgros::command AND NOT CMAKE_CROSSCOMPILING)
    set(checks ON)
    list(TRANSFORM arg_COMPONENTS PREPEND "--has;" OUTPUT_VARIABLE wanted)
    add_custom_command(TARGET ${target} POST_BUILD
      COMMAND hgros::command components --library $<TARGET_FILE:${target}> ${wanted}
      COMMENT "Checking the components of ${target}" VERBATIM)
    if(TARGET hgros_command)
      add_dependencies(${target} hgros_command)
    endif()
  endif()

  list(JOIN arg_COMPONENTS ", " names)
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/share/hgros/components/${target}.yaml
    CONTENT "library: \"$<TARGET_FILE:${target}>\"\ncomponents: [${names}]\n")
  if(arg_NO_INSTALL)
    return()
  endif()
  set(folder ${CMAKE_INSTALL_DATADIR}/hgros/components)
  file(RELATIVE_PATH to_libraries ${CMAKE_INSTALL_FULL_DATADIR}/hgros/components ${CMAKE_INSTALL_FULL_LIBDIR})
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${target}_installed.yaml
    CONTENT "library: \"${to_libraries}/$<TARGET_FILE_NAME:${target}>\"\ncomponents: [${names}]\n")
  set(own)
  set(seen)
  _hgros_own_libraries(own seen ${arg_LINK})
  set_property(TARGET ${target} ${own} APPEND PROPERTY INSTALL_RPATH "$ORIGIN")
  set_property(TARGET ${target} ${own} PROPERTY INSTALL_RPATH_USE_LINK_PATH ON)
  install(TARGETS ${target} ${own} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${target}_installed.yaml DESTINATION ${folder} RENAME ${target}.yaml)
  if(checks)
    set(libraries ${CMAKE_INSTALL_LIBDIR})
    if(NOT IS_ABSOLUTE "${libraries}")
      string(PREPEND libraries "\${CMAKE_INSTALL_PREFIX}/")
    endif()
    list(JOIN wanted "\" \"" words)
    set(script ${CMAKE_CURRENT_BINARY_DIR}/${target}_installed.cmake)
    file(GENERATE OUTPUT ${script} CONTENT "execute_process(COMMAND \"$<TARGET_FILE:hgros::command>\" components
  --library \"\$ENV{DESTDIR}${libraries}/$<TARGET_FILE_NAME:${target}>\" \"${words}\" COMMAND_ERROR_IS_FATAL ANY)\n")
    install(SCRIPT ${script})
  endif()
endfunction()
