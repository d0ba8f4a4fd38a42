# Run by ctest with -P. A step that fails stops the test.
cmake_minimum_required(VERSION 3.25)
set(prefix ${SCRATCH}/prefix)
set(build ${SCRATCH}/build)
file(REMOVE_RECURSE ${SCRATCH})
set(ENV{DESTDIR})
function(run)  # A command that must succeed.
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix} --strip)

# Components of tests and examples are not part of it, only its own and the finder of those in Python.
file(GLOB_RECURSE manifests ${prefix}/share/hgros/components/*)
list(REMOVE_ITEM manifests ${prefix}/share/hgros/components/hgros.yaml ${prefix}/share/hgros/components/python.yaml)
if(manifests)
  message(FATAL_ERROR "Components were installed with the library: ${manifests}")
endif()

# The package must not need the tree: no static module is installed, and no installed file contains the tree's path.
file(GLOB_RECURSE archives ${prefix}/*.a)
if(archives)
  message(FATAL_ERROR "Static libraries were installed: ${archives}")
endif()
file(GLOB_RECURSE package_files ${prefix}/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "No CMake package was installed below ${prefix}.")
endif()
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  string(FIND "${text}" "${BUILD_DIR}" at)
  if(NOT at EQUAL -1)
    message(FATAL_ERROR "${file} contains the path of the build folder ${BUILD_DIR}.")
  endif()
endforeach()

# The library exports only its own names.
file(GLOB_RECURSE library ${prefix}/*/libhgros.so)
execute_process(COMMAND ${NM} --dynamic --defined-only --demangle ${library}
  OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" symbols "${symbols}")
list(FILTER symbols EXCLUDE REGEX "(^| )hgros::|(typeinfo|vtable|VTT|guard variable|TLS [a-z]+ function|thunk)[a-z ]* (for|to) hgros::")
list(FILTER symbols EXCLUDE REGEX "\\[abi:|^$| for hgros::| to hgros::| hgros::")
if(symbols)
  list(JOIN symbols "\n  " symbols)
  message(FATAL_ERROR "libhgros.so exports names outside hgros:\n  ${symbols}")
endif()

run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CONSUMER} -B ${build} -D CMAKE_CXX_COMPILER=${COMPILER}
    -D CMAKE_PREFIX_PATH=${prefix} -D HGROS_WANTED_VERSION=${VERSION} -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${build})
run(${build}/consumer)
run(${build}/robot)
run(${build}/recording ${SCRATCH}/run.mcap)
run(${build}/shop)

# Components are checked when they are built, and found once they are installed, wherever that is.
set(robot ${SCRATCH}/robot)
run(${CMAKE_COMMAND} --install ${build} --prefix ${robot})
foreach(folder IN ITEMS ${build}/share/hgros/components ${robot}/share/hgros/components)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env HGROS_COMPONENT_PATH=${folder} ${prefix}/bin/hgros components words/Counter
    OUTPUT_VARIABLE shown COMMAND_ERROR_IS_FATAL ANY)
  if(NOT shown MATCHES "words\\.Word")
    message(FATAL_ERROR "hgros components shows of the component in ${folder}: ${shown}")
  endif()
endforeach()

# What `hgros new` writes builds, and its robot runs.
set(new ${SCRATCH}/arm_driver)
run(${CMAKE_COMMAND} -E chdir ${SCRATCH} ${prefix}/bin/hgros new arm_driver)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${new} -B ${new}/build -D CMAKE_CXX_COMPILER=${COMPILER}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${new}/build)
run(${new}/build/limiter_test)
string(MD5 domain ${SCRATCH})
set(ENV{HGROS_DOMAIN} ${domain})
set(ENV{XDG_STATE_HOME} ${SCRATCH}/state)
run(${CMAKE_COMMAND} -E env HGROS_COMPONENT_PATH=${new}/build/share/hgros/components
    ${prefix}/bin/hgros run ${new}/robot.yaml --detach)
run(${prefix}/bin/hgros stop)
unset(ENV{HGROS_DOMAIN})
unset(ENV{XDG_STATE_HOME})

# The Python package is found where it is installed, and finds the library there.
file(GLOB python_packages ${prefix}/lib/python*/dist-packages)
if(python_packages)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${python_packages} HGROS_DOMAIN=none ${PYTHON} -B -c
    "import hgros, foxglove.LaserScan_pb2 as m; hgros.Session().advertise('scan', m.LaserScan)"
    COMMAND_ERROR_IS_FATAL ANY)
endif()

# The programs start from their install folder.
run(${prefix}/bin/hgros-keygen ${SCRATCH}/robot.key)

# The examples, too, need only the package.
set(examples ${SCRATCH}/examples)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${EXAMPLES} -B ${examples} -D CMAKE_CXX_COMPILER=${COMPILER}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=Debug -D CMAKE_UNITY_BUILD=ON -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${examples})
run(${CMAKE_COMMAND} -E env HGROS_COMPONENT_PATH=${examples}/share/hgros/components
    ${prefix}/bin/hgros run ${EXAMPLES}/slam2d/three_processes.yaml --set source.params.scans=50
    --set writer.params.out=${SCRATCH}/slam2d_out)

# Those in C need no C++ compiler, and no CMake.
set(c_examples ${SCRATCH}/c_examples)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${EXAMPLES}/c -B ${c_examples} -D CMAKE_C_COMPILER=${C_COMPILER}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${c_examples})
file(GLOB_RECURSE pc ${prefix}/*/hgros_c.pc)
cmake_path(GET pc PARENT_PATH pc_folder)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
execute_process(COMMAND pkg-config --cflags --libs hgros_c OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
file(GLOB_RECURSE c_library ${prefix}/*/libhgros_c.so)
cmake_path(GET c_library PARENT_PATH c_folder)
run(${C_COMPILER} -std=c99 ${EXAMPLES}/c/service.c ${flags} -Wl,-rpath,${c_folder} -o ${SCRATCH}/service)
foreach(program IN ITEMS ${c_examples}/service ${SCRATCH}/service)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env HGROS_DOMAIN=none ${program} OUTPUT_VARIABLE shown COMMAND_ERROR_IS_FATAL ANY)
  if(NOT shown STREQUAL "2 + 40 = 42\n")
    message(FATAL_ERROR "${program} printed: ${shown}")
  endif()
endforeach()
file(SIZE ${c_library} size)
if(size GREATER 300000)
  message(FATAL_ERROR "libhgros_c.so has ${size} bytes, more than 300000, although it is stripped.")
endif()
