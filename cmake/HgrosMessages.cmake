# hgros_add_messages(TARGET [STATIC | SHARED] my.proto ... [IMPORT_DIRS folder ...])
#
# Creates a library TARGET of the C++ classes that protoc generates from the files. It is shared by default, so that all
# programs and plugins of a process register each descriptor once. Targets that link TARGET include the headers by the
# path with which other files import them: `#include <my.pb.h>`.
#
# Files may be relative to the current source folder. The name of a file is its path below the first folder in
# IMPORT_DIRS that contains it, otherwise below the current source folder, otherwise its file name. The files may import
# each other, files below IMPORT_DIRS, and the messages of the library ("foxglove/PointCloud.proto", "hgros/Imu.proto").
# Imported files that are not listed need a separate target, which TARGET then links.
#
#     find_package(hgros REQUIRED)
#     hgros_add_messages(my_messages robot/gripper.proto IMPORT_DIRS ${CMAKE_CURRENT_SOURCE_DIR})
#     target_link_libraries(my_program PRIVATE hgros::hgros my_messages)
#
# Before this file is included, HGROS_PROTO_DIR must be the folder of the library's own .proto files.
set_property(GLOBAL PROPERTY HGROS_PROTO_DIR ${HGROS_PROTO_DIR})

function(hgros_add_messages target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "STATIC;SHARED" "" "IMPORT_DIRS")
  set(files ${arg_UNPARSED_ARGUMENTS})
  set(call "hgros_add_messages(${target})")
  if(TARGET ${target})
    message(FATAL_ERROR "${call}: there is already a target ${target}. Give one of them another name.")
  endif()
  if(arg_STATIC AND arg_SHARED)
    message(FATAL_ERROR "${call}: STATIC and SHARED exclude each other. Leave one out.")
  endif()
  if(NOT files)
    message(FATAL_ERROR "${call}: no .proto file is given. List at least one after the target's name.")
  endif()
  if(NOT TARGET protobuf::protoc OR NOT TARGET protobuf::libprotobuf)
    message(FATAL_ERROR "${call}: protoc or the protobuf library was not found. Install them "
      "(Debian: protobuf-compiler, libprotobuf-dev), or set Protobuf_PROTOC_EXECUTABLE.")
  endif()

  set(import_dirs)
  foreach(folder IN LISTS arg_IMPORT_DIRS)
    cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    string(REGEX REPLACE "/+$" "" folder "${folder}")
    if(NOT IS_DIRECTORY ${folder})
      message(FATAL_ERROR "${call}: the import folder ${folder} does not exist. Correct IMPORT_DIRS.")
    endif()
    list(APPEND import_dirs ${folder})
  endforeach()

  set(generated_dir ${CMAKE_CURRENT_BINARY_DIR}/${target}_proto)
  file(MAKE_DIRECTORY ${generated_dir})
  set(roots)
  set(names)
  set(inputs)
  set(generated)
  foreach(file IN LISTS files)
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    if(NOT file MATCHES "\\.proto$")
      message(FATAL_ERROR "${call}: ${file} is not a .proto file.")
    endif()
    if(NOT EXISTS ${file})
      message(FATAL_ERROR "${call}: ${file} does not exist. Correct its path, which is relative to "
        "${CMAKE_CURRENT_SOURCE_DIR}.")
    endif()
    cmake_path(GET file PARENT_PATH root)
    foreach(folder IN LISTS import_dirs ITEMS ${CMAKE_CURRENT_SOURCE_DIR})
      cmake_path(IS_PREFIX folder ${file} NORMALIZE below)
      if(below)
        set(root ${folder})
        break()
      endif()
    endforeach()
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${root} OUTPUT_VARIABLE name)
    if(name IN_LIST names)
      message(FATAL_ERROR "${call}: two files are imported as ${name}. List each file once, or move one of them.")
    endif()
    string(REGEX REPLACE "\\.proto$" "" stem ${name})
    list(APPEND names ${name})
    list(APPEND inputs ${file})
    list(APPEND roots ${root})
    list(APPEND generated ${generated_dir}/${stem}.pb.cc ${generated_dir}/${stem}.pb.h)
  endforeach()

  set(proto_paths)
  get_property(own_protos GLOBAL PROPERTY HGROS_PROTO_DIR)
  set(searched ${roots} ${import_dirs} ${own_protos})
  list(REMOVE_DUPLICATES searched)
  list(TRANSFORM searched PREPEND "--proto_path=" OUTPUT_VARIABLE proto_paths)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND protobuf::protoc ${proto_paths} --cpp_out=${generated_dir} ${names}
    DEPENDS ${inputs} protobuf::protoc
    COMMENT "Generating the messages of ${target}"
    VERBATIM)
  set(kind SHARED)
  if(arg_STATIC)
    set(kind STATIC)
  endif()
  add_library(${target} ${kind} ${generated})
  # protoc's code exports all its classes, and its warnings are not the user's concern.
  set_target_properties(${target} PROPERTIES
    CXX_VISIBILITY_PRESET default VISIBILITY_INLINES_HIDDEN OFF POSITION_INDEPENDENT_CODE ON UNITY_BUILD OFF)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -w)
  target_include_directories(${target} SYSTEM PUBLIC $<BUILD_INTERFACE:${generated_dir}>)
  target_link_libraries(${target} PUBLIC hgros::messages protobuf::libprotobuf)
endfunction()
