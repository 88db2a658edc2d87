# Helpers that make every target of the package alike.
include(GNUInstallDirs)

# Installed programs and libraries find each other without an environment.
set(EXTPERFC_LIB_DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(EXTPERFC_WITH_ROS)
  set(EXTPERFC_LIB_DESTINATION ${CATKIN_GLOBAL_LIB_DESTINATION})  # where catkin's environment and pluginlib look
endif()
set(CMAKE_INSTALL_RPATH "$ORIGIN;$ORIGIN/..")
if(NOT EXTPERFC_LIB_DESTINATION MATCHES "^lib$")
  list(APPEND CMAKE_INSTALL_RPATH "$ORIGIN/../../${EXTPERFC_LIB_DESTINATION}")
endif()

# Flags of all our targets. Includes are rooted: "<module>/..." in src, "extperfc/..." in include, "test/...".
add_library(extperfc_flags INTERFACE)
target_include_directories(extperfc_flags INTERFACE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR})
target_compile_features(extperfc_flags INTERFACE cxx_std_17)
target_compile_options(extperfc_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wconversion -Wno-sign-conversion
  $<$<BOOL:${EXTPERFC_WERROR}>:-Werror>
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)  # lets ccache see through precompiled headers
if(EXTPERFC_UNITY)
  # Where sources are joined, what is anonymous in one seems to stand in a header.
  target_compile_options(extperfc_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(EXTPERFC_SANITIZE)
  target_compile_options(extperfc_flags INTERFACE
    -fsanitize=${EXTPERFC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1
    # GCC's documentation: sanitizers make it warn falsely, here inside libstdc++'s regex.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(extperfc_flags INTERFACE -fsanitize=${EXTPERFC_SANITIZE})
endif()

# Precompiled headers, one for each kind of target: the core's libraries and programs share this one, tests that of
# extperfc_test_headers, nodelets that of extperfc_ros_support, and their tests that of extperfc_ros_test_support.
# Who shares one compiles with the same flags, so everything of ours is position independent.
target_compile_options(extperfc_flags INTERFACE -fPIC)
set(EXTPERFC_CORE_HEADERS
  <algorithm> <array> <chrono> <cmath> <functional> <map> <memory> <optional> <set> <string>
  <utility> <vector> <Eigen/Core> <Eigen/Geometry> <tl/expected.hpp>)
set(EXTPERFC_HEADERS_FROM extperfc_core_headers)  # src/ros says otherwise
add_library(extperfc_core_headers STATIC EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
target_link_libraries(extperfc_core_headers PRIVATE extperfc_flags Eigen3::Eigen tl::expected)
target_precompile_headers(extperfc_core_headers PRIVATE ${EXTPERFC_CORE_HEADERS})
if(EXTPERFC_TESTS)
  # The tests' own code is compiled quickly, not for speed: what they test is in the libraries.
  add_library(extperfc_test_flags INTERFACE)
  target_link_libraries(extperfc_test_flags INTERFACE extperfc_flags)
  target_compile_options(extperfc_test_flags INTERFACE -O0)
  add_library(extperfc_test_headers STATIC EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(extperfc_test_headers PRIVATE extperfc_test_flags Eigen3::Eigen tl::expected GTest::gtest)
  target_precompile_headers(extperfc_test_headers PRIVATE <gtest/gtest.h> ${EXTPERFC_CORE_HEADERS})
endif()

# extperfc_add_library(<module> SOURCES ... [LINK public targets ...] [PRIVATE_LINK targets ...])
# One shared library libextperfc_<module>.so per module, alias extperfc::<module>.
function(extperfc_add_library module)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(extperfc_${module} SHARED ${ARG_SOURCES})
  add_library(extperfc::${module} ALIAS extperfc_${module})
  set_target_properties(extperfc_${module} PROPERTIES
    DEFINE_SYMBOL ""  # a macro per library would fit no shared header
    UNITY_BUILD ${EXTPERFC_UNITY})
  target_include_directories(extperfc_${module}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(extperfc_${module}
    PUBLIC ${ARG_LINK} PRIVATE $<BUILD_INTERFACE:extperfc_flags> ${ARG_PRIVATE_LINK})
  target_compile_features(extperfc_${module} PUBLIC cxx_std_17)
  if(NOT module STREQUAL ros_support)
    target_precompile_headers(extperfc_${module} REUSE_FROM ${EXTPERFC_HEADERS_FROM})
  endif()
  install(TARGETS extperfc_${module} LIBRARY DESTINATION ${EXTPERFC_LIB_DESTINATION})
endfunction()

# extperfc_add_program(<name> [NO_INSTALL] SOURCES ... LINK ...): an executable that tools/ or roslaunch start.
function(extperfc_add_program name)
  cmake_parse_arguments(ARG "NO_INSTALL" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE extperfc_flags ${ARG_LINK})
  target_precompile_headers(${name} REUSE_FROM ${EXTPERFC_HEADERS_FROM})
  if(NOT ARG_NO_INSTALL)
    install(TARGETS ${name} RUNTIME DESTINATION lib/${PROJECT_NAME})
  endif()
endfunction()

# extperfc_add_test(<module>/<name> [COMPUTES] SOURCES ... LINK ...): a GoogleTest program, run by `tools/test unit`.
# COMPUTES: the test itself computes so much that it is compiled for speed.
function(extperfc_add_test name)
  cmake_parse_arguments(ARG "COMPUTES" "" "SOURCES;LINK" ${ARGN})
  string(REPLACE "/" "_" target test_${name})
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_LINK} GTest::gtest_main)
  if(ARG_COMPUTES)
    target_link_libraries(${target} PRIVATE extperfc_flags)
    target_precompile_headers(${target} REUSE_FROM extperfc_core_headers)
  else()
    target_link_libraries(${target} PRIVATE extperfc_test_flags)
    target_precompile_headers(${target} REUSE_FROM extperfc_test_headers)
  endif()
  target_compile_definitions(${target} PRIVATE
    EXTPERFC_TEST_DATA="${PROJECT_SOURCE_DIR}/test/data" EXTPERFC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(EXTPERFC_SANITIZE MATCHES address)
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/test/support/no_deepbind.cpp)
    target_link_options(${target} PRIVATE -rdynamic)
  endif()
  extperfc_register_unit_test(${name} ${target})
endfunction()
