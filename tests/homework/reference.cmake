# Tests that hold solutions: of the reference and of the shelf of fills.

# The reference passes every stage, test by test; and each fill of the shelf gets the verdict that it deserves.
file(GLOB fill_files CONFIGURE_DEPENDS fills/*.fills)
# A second fill for each mistake, written differently, and those that have no name yet: half of the time that the tests
# take to compile, for what changes with the checks alone.
option(CH5_ALL_FILLS "Compile the second set of fills too: ./course test does with CI or CH5_LONG" OFF)
set(second_set ${fill_files})
list(FILTER second_set INCLUDE REGEX "_again|midnight")
if(NOT CH5_ALL_FILLS)
  list(REMOVE_ITEM fill_files ${second_set})
  foreach(fills IN LISTS second_set)
    cmake_path(GET fills STEM name)
    add_test(NAME Homework.Fills.${name} COMMAND ${CMAKE_COMMAND} -E echo "skipped: CI=1 or CH5_LONG=1 ./course test compiles it")
    set_tests_properties(Homework.Fills.${name} PROPERTIES SKIP_REGULAR_EXPRESSION "^skipped")
  endforeach()
endif()
list(TRANSFORM fill_files REPLACE ".*/(.*)\\.fills" "fills_\\1.cc" OUTPUT_VARIABLE fill_sources)
list(APPEND fill_sources fills_blanks.cc)
add_custom_command(OUTPUT ${fill_sources}
  COMMAND ${ch5_python_module} tests.homework.fills ${CMAKE_CURRENT_BINARY_DIR} ${fill_files}
  DEPENDS fills.py ${skeleton_sources} ${stage_table} ${fill_files} ${solution_files})
add_library(fills OBJECT ${fill_sources})
target_link_libraries(fills PRIVATE student_flags GTest::gtest)
target_precompile_headers(fills REUSE_FROM student_pch)
target_compile_options(fills PRIVATE -w)
# As in a check, the objects with assertions come first.
add_executable(homework_fills $<TARGET_OBJECTS:fills> ${all_stage_tests})
set_target_properties(homework_fills PROPERTIES LINKER_LANGUAGE CXX)
target_link_libraries(homework_fills PRIVATE student_flags ch5_backend GTest::gtest)
if(CH5_SANITIZE)
  target_link_libraries(fills PRIVATE ch5_warnings)
  target_link_libraries(homework_fills PRIVATE ch5_warnings)
endif()
target_link_options(homework_fills PRIVATE -s)  # no lines to find in a generated file
gtest_discover_tests(homework_fills TEST_PREFIX Reference. DISCOVERY_MODE PRE_TEST)
foreach(fills IN LISTS fill_files ITEMS blanks)
  cmake_path(GET fills STEM name)
  set(own)
  if(fills IN_LIST second_set)  # that a fill leaves the other stages alone, the first of its kind has shown
    set(own --own)
  endif()
  add_test(NAME Homework.Fills.${name}
    COMMAND ${ch5_python_module} tests.homework.run_fills ${own} $<TARGET_FILE:homework_fills> ${fills})
endforeach()

ch5_add_python_tests(Homework throw_left.py)
ch5_add_python_tests(Homework first_words.py)
ch5_add_python_tests(Homework languages.py)

add_test(NAME Homework.CheckFromEndToEnd
  COMMAND ${ch5_python_module} unittest tests.homework.end_to_end)
set_tests_properties(Homework.CheckFromEndToEnd PROPERTIES LABELS slow RESOURCE_LOCK ninja
  ENVIRONMENT "CH5_BUILD_DIR=${PROJECT_BINARY_DIR};CH5_HOMEWORK_DIR=${CH5_HOMEWORK_DIR};CH5_CHECK_PREFIX=trial_;CH5_CHECK_FOLDER=${trial};LC_ALL=C.UTF-8"
  ENVIRONMENT_MODIFICATION CH5_DATA_DIR=set:${CH5_DATA_DIR})

include(plain_ctest.cmake)
include(workers.cmake)
