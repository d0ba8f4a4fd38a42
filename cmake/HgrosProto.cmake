# All files that protoc generates, without compiling them. clang-tidy needs them before it can read a source.
add_custom_target(hgros_generated)

# hgros_proto_sources(OUT_VAR IMPORT_ROOT files...)
# Runs protoc on the files (paths below IMPORT_ROOT) and stores the sources to compile in OUT_VAR. The headers are below
# ${PROJECT_BINARY_DIR}/proto_include with the same paths.
#
# protobuf's own headers take most of the compile time of a generated file, so up to 21 of them are compiled as one. Two
# static names are the same in all of them. A macro, defined for one file only, adds the file's number to each name.
function(hgros_proto_sources out_var import_root)
  set(batch_size 21)
  set(generated_root ${PROJECT_BINARY_DIR}/proto_include)
  file(MAKE_DIRECTORY ${generated_root})
  string(MD5 call "${CMAKE_CURRENT_SOURCE_DIR} ${ARGN}")
  string(SUBSTRING ${call} 0 8 call)
  set(generated)
  set(batches)
  set(number 0)
  foreach(file IN LISTS ARGN)
    string(REGEX REPLACE "\\.proto$" "" stem ${file})
    add_custom_command(
      OUTPUT ${generated_root}/${stem}.pb.cc ${generated_root}/${stem}.pb.h
      COMMAND protobuf::protoc --proto_path=${import_root} --cpp_out=${generated_root} ${import_root}/${file}
      DEPENDS ${import_root}/${file} protobuf::protoc
      VERBATIM)
    math(EXPR batch "${number} / ${batch_size}")
    set(batch_file ${CMAKE_CURRENT_BINARY_DIR}/proto_${call}_${batch}.cc)
    if(NOT batch_file IN_LIST batches)
      list(APPEND batches ${batch_file})
      set(headers_${batch})
      set(bodies_${batch})
      set(inputs_${batch})
    endif()
    string(APPEND headers_${batch} "#include \"${stem}.pb.h\"\n")
    string(APPEND bodies_${batch}
      "#define schemas schemas_${number}\n#define file_default_instances file_default_instances_${number}\n"
      "#include \"${stem}.pb.cc\"\n#undef schemas\n#undef file_default_instances\n")
    list(APPEND inputs_${batch} ${generated_root}/${stem}.pb.cc)
    list(APPEND generated ${generated_root}/${stem}.pb.cc)
    math(EXPR number "${number} + 1")
  endforeach()
  # No warnings, debug information or sanitizers for protoc's code: instrumented, it would take longer to compile than
  # everything else.
  set(options -w -g0)
  if(HGROS_SANITIZE)
    list(APPEND options -fno-sanitize=all)
  endif()
  set(batch 0)
  foreach(batch_file IN LISTS batches)
    string(CONCAT text
      "${headers_${batch}}"
      "#include <google/protobuf/extension_set.h>\n#include <google/protobuf/generated_message_reflection.h>\n"
      "#include <google/protobuf/reflection_ops.h>\n#include <google/protobuf/wire_format.h>\n"
      "#include <google/protobuf/wire_format_lite.h>\n#include <google/protobuf/io/coded_stream.h>\n"
      "#include <google/protobuf/descriptor.h>\n"
      "${bodies_${batch}}")
    file(CONFIGURE OUTPUT ${batch_file} CONTENT "${text}" @ONLY)
    set_source_files_properties(${batch_file} PROPERTIES
      COMPILE_OPTIONS "${options}" INCLUDE_DIRECTORIES ${generated_root} OBJECT_DEPENDS "${inputs_${batch}}")
    math(EXPR batch "${batch} + 1")
  endforeach()
  set_source_files_properties(${generated} PROPERTIES HEADER_FILE_ONLY ON)
  add_custom_target(hgros_generated_${call} DEPENDS ${generated})
  add_dependencies(hgros_generated hgros_generated_${call})
  set(${out_var} ${batches} ${generated} PARENT_SCOPE)
endfunction()
