# Which tests there are, and who builds and runs them.
#
# EXTPERFC_TESTS and EXTPERFC_BENCHMARKS follow CATKIN_ENABLE_TESTING unless they are given. Under it the usual targets of
# catkin exist: `tests` builds, `run_tests` runs, and a plain build leaves both out. Otherwise (tools/setup, and the core
# without ROS) tests and benchmarks are part of a plain build, and ctest runs the unit tests.
set(EXTPERFC_CATKIN_TESTS OFF)
if(EXTPERFC_WITH_ROS AND CATKIN_ENABLE_TESTING)
  set(EXTPERFC_CATKIN_TESTS ON)
endif()
if(NOT DEFINED EXTPERFC_TESTS)
  set(EXTPERFC_TESTS ON)
  if(EXTPERFC_WITH_ROS)
    set(EXTPERFC_TESTS ${EXTPERFC_CATKIN_TESTS})
  endif()
endif()
if(NOT DEFINED EXTPERFC_BENCHMARKS)
  set(EXTPERFC_BENCHMARKS ${EXTPERFC_TESTS})
endif()
message(STATUS "Tests: ${EXTPERFC_TESTS}, benchmarks: ${EXTPERFC_BENCHMARKS}, run by catkin: ${EXTPERFC_CATKIN_TESTS}")

if(EXTPERFC_TESTS)
  enable_testing()
endif()

# All targets of a folder and of those below it, as a list in `out`.
function(extperfc_targets_below folder out)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(below DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(one IN LISTS below)
    extperfc_targets_below(${one} more)
    list(APPEND targets ${more})
  endforeach()
  set(${out} ${targets} PARENT_SCOPE)
endfunction()

# Makes a target depend on all programs and libraries that folders of this package made so far.
function(extperfc_depend_on_folders target)
  extperfc_targets_below(${PROJECT_SOURCE_DIR} all)
  foreach(one IN LISTS all)
    get_target_property(type ${one} TYPE)
    get_target_property(place ${one} SOURCE_DIR)
    foreach(folder IN LISTS ARGN)
      if(type MATCHES "^(EXECUTABLE|(SHARED|STATIC|MODULE)_LIBRARY)$" AND "${place}/" MATCHES "^${PROJECT_SOURCE_DIR}/${folder}/")
        add_dependencies(${target} ${one})
      endif()
    endforeach()
  endforeach()
endfunction()

# Adds a folder of tests or benchmarks. Under catkin's tests the target `all_of_them` alone builds it, with what of src/
# it loads or starts at run time.
function(extperfc_add_tests folder all_of_them)
  if(NOT EXTPERFC_CATKIN_TESTS)
    add_subdirectory(${folder})
    return()
  endif()
  add_subdirectory(${folder} EXCLUDE_FROM_ALL)
  if(NOT TARGET ${all_of_them})
    add_custom_target(${all_of_them})
  endif()
  extperfc_depend_on_folders(${all_of_them} ${folder} src)
endfunction()

# Registers a GoogleTest program as unit/<name> with ctest, or as <target> with catkin's run_tests.
function(extperfc_register_unit_test name target)
  if(EXTPERFC_CATKIN_TESTS)
    catkin_run_tests_target(gtest ${target} gtest-${target}.xml
      COMMAND "$<TARGET_FILE:${target}> --gtest_output=xml:${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/gtest-${target}.xml"
      DEPENDENCIES ${target})
    return()
  endif()
  add_test(NAME unit/${name} COMMAND ${target})
  set_tests_properties(unit/${name} PROPERTIES LABELS unit TIMEOUT 120)
endfunction()
