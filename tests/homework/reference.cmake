# Tests that hold solutions: of the reference and of the sample submissions.

# The reference passes every stage, test by test; and each sample submission gets the verdict that it deserves.
file(GLOB mistake_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/ch5_homework/mistakes/*.mistakes)
file(GLOB sample_files CONFIGURE_DEPENDS samples/*.samples)
list(PREPEND sample_files ${mistake_files})
set(samples_blanks blanks)
foreach(file IN LISTS sample_files)
  cmake_path(GET file STEM name)
  list(APPEND sample_names ${name})
  list(APPEND samples_${name} ${file})
endforeach()
list(REMOVE_DUPLICATES sample_names)
list(TRANSFORM sample_names REPLACE "(.+)" "samples_\\1.cc" OUTPUT_VARIABLE sources_of_samples)
list(TRANSFORM sample_names REPLACE "(.+)" "samples_by_night_\\1.cc" OUTPUT_VARIABLE sources_of_samples_by_night)
add_custom_command(OUTPUT ${sources_of_samples} ${sources_of_samples_by_night}
  COMMAND ${ch5_python_module} tests.homework.samples ${CMAKE_CURRENT_BINARY_DIR} ${sample_files}
  DEPENDS samples.py ${skeleton_sources} ${stage_table} ${sample_files} ${solution_files})
add_library(without_lines INTERFACE)  # there are none to find in a generated file
target_compile_options(without_lines INTERFACE -g0)
if(CH5_SANITIZE)  # may hold a comma, which a generator expression would take for its own
  set(sanitized ch5_warnings)
endif()
foreach(part samples samples_by_night)
  add_library(${part} OBJECT EXCLUDE_FROM_ALL ${sources_of_${part}})
  target_link_libraries(${part} PRIVATE student_flags without_lines GTest::gtest ${sanitized})
  target_precompile_headers(${part} PRIVATE <ch5_homework/judge/student_pch.h>)
  target_compile_options(${part} PRIVATE -w)
  # Three stages at a time: those of one file of the homework have most of their templates in common.
  set_target_properties(${part} PROPERTIES UNITY_BUILD ${CH5_UNITY} UNITY_BUILD_BATCH_SIZE 3)
endforeach()
# As in a check, the objects with assertions come first.
add_executable(homework_samples $<TARGET_OBJECTS:samples> ${all_stage_tests})
add_executable(all_homework_samples EXCLUDE_FROM_ALL $<TARGET_OBJECTS:samples> $<TARGET_OBJECTS:samples_by_night> ${all_stage_tests})
foreach(executable homework_samples all_homework_samples)
  set_target_properties(${executable} PROPERTIES LINKER_LANGUAGE CXX)
  target_link_libraries(${executable} PRIVATE student_flags ch5_backend GTest::gtest ${sanitized})
endforeach()
# Builds the executables of all samples, for the tests that judge them by night.
add_test(NAME Homework.all_samples_build
  COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR} --target all_homework_samples all_worker_samples)
ch5_by_night(Homework.all_samples_build)
set_tests_properties(Homework.all_samples_build PROPERTIES RESOURCE_LOCK ninja FIXTURES_SETUP all_samples)
# Brings ch5_homework/mistakes/answers.csv and ch5_homework/exercised.csv up to date, in a minute and a half.
add_custom_target(answers VERBATIM
  COMMAND ${ch5_python_module} tests.homework.run_samples --write $<TARGET_FILE:all_homework_samples> ${mistake_files}
  COMMAND ${ch5_python_module} tests.homework.run_samples --write $<TARGET_FILE:all_homework_samples> blanks)
add_executable(test_formula formula_test.cc open_tasks_formulas_test.cc ${scene_objects} $<TARGET_OBJECTS:stage_tests_slips>
  $<TARGET_OBJECTS:stage_tests_common> $<FILTER:$<TARGET_OBJECTS:stage_tests_given>,EXCLUDE,/main[.]cc>
  $<FILTER:$<TARGET_OBJECTS:stage_tests_open_tasks>,INCLUDE,/right/>)
target_link_libraries(test_formula PRIVATE ch5_backend ch5_test_settings GTest::gtest GTest::gtest_main)
target_precompile_headers(test_formula REUSE_FROM ch5_test_pch)
gtest_discover_tests(test_formula TEST_PREFIX Homework. DISCOVERY_MODE PRE_TEST)
gtest_discover_tests(homework_samples TEST_PREFIX Reference. DISCOVERY_MODE PRE_TEST)
# By day every third one, in the stage that each is made for; by night, and asked for by name, all in all stages of their file.
foreach(name IN LISTS sample_names ITEMS blanks)
  set(run ${ch5_python_module} tests.homework.run_samples)
  add_test(NAME Homework.Samples.${name} COMMAND ${run} --own --by-day $<TARGET_FILE:homework_samples> ${samples_${name}})
  add_test(NAME Homework.SamplesInAllStages.${name} COMMAND ${run} $<TARGET_FILE:all_homework_samples> ${samples_${name}})
  ch5_by_night(Homework.SamplesInAllStages.${name})
  set_tests_properties(Homework.SamplesInAllStages.${name} PROPERTIES FIXTURES_REQUIRED all_samples)
endforeach()

ch5_add_python_tests(Homework answers_test.py)
ch5_add_python_tests(Homework leftover_throw_test.py)
ch5_add_python_tests(Homework compiler_words_test.py)
ch5_add_python_tests(Homework languages_test.py WHOLE)

add_test(NAME Homework.CheckFromEndToEnd
  COMMAND ${ch5_python_module} unittest -k skeleton -k solution -k compile -k missing_file tests.homework.end_to_end_test)
add_test(NAME Homework.CheckOfWrongFiles
  COMMAND ${ch5_python_module} unittest -k crash -k empty -k chinese tests.homework.end_to_end_test)
ch5_by_night(Homework.CheckOfWrongFiles)
set_tests_properties(Homework.CheckFromEndToEnd PROPERTIES LABELS slow)
set_tests_properties(Homework.CheckFromEndToEnd Homework.CheckOfWrongFiles PROPERTIES RESOURCE_LOCK ninja
  ENVIRONMENT "CH5_BUILD_DIR=${PROJECT_BINARY_DIR};CH5_HOMEWORK_DIR=${CH5_HOMEWORK_DIR};CH5_CHECK_PREFIX=trial_;CH5_CHECK_FOLDER=${trial};LC_ALL=C.UTF-8"
  ENVIRONMENT_MODIFICATION CH5_DATA_DIR=set:${CH5_DATA_DIR})

include(workers.cmake)
