# The grader's judge and workers, tested.
# A worker for tests, of the samples of the day; and one of all.
set(objects $<TARGET_OBJECTS:samples> $<TARGET_OBJECTS:worker_main> $<TARGET_OBJECTS:wire> ${scene_objects} ${worker_objects})
add_executable(worker_samples ${objects})
add_executable(all_worker_samples EXCLUDE_FROM_ALL $<TARGET_OBJECTS:samples_by_night> ${objects})
foreach(executable worker_samples all_worker_samples)
  target_link_libraries(${executable} PRIVATE student_flags ch5_backend ch5_warnings -s)
  set_target_properties(${executable} PROPERTIES LINKER_LANGUAGE CXX RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endforeach()

ch5_add_python_tests(Homework judge_and_worker_test.py LABELS grading)

add_library(wire_test OBJECT wire_test.cc)
target_link_libraries(wire_test PRIVATE ch5_backend ch5_test_settings GTest::gtest)
target_precompile_headers(wire_test REUSE_FROM ch5_test_pch)
add_executable(test_wire $<TARGET_OBJECTS:wire_test> $<TARGET_OBJECTS:wire>
  ${scene_objects} $<TARGET_OBJECTS:stage_tests_slips> $<TARGET_OBJECTS:stage_tests_common>
  $<FILTER:$<TARGET_OBJECTS:stage_tests_given>,EXCLUDE,/main[.]cc>)
target_link_libraries(test_wire PRIVATE ch5_backend ch5_test_settings GTest::gtest GTest::gtest_main)
set_target_properties(test_wire PROPERTIES LINKER_LANGUAGE CXX)
gtest_discover_tests(test_wire TEST_PREFIX Homework. DISCOVERY_MODE PRE_TEST PROPERTIES LABELS grading)

# Each sample that is wrong gets the same verdict of the judge as of a check; those that are right get theirs with any seed,
# far from a tolerance. By day some of one file, since Homework.Samples has judged those of all in a check's way.
set(run ${ch5_python_module} tests.homework.run_samples --own --seed 1 --seed 2 --seed 987654321987654321)
foreach(name IN LISTS sample_names ITEMS blanks)
  add_test(NAME Homework.JudgedSamples.${name}
    COMMAND ${run} --worker $<TARGET_FILE:all_worker_samples> $<TARGET_FILE:homework_judge> ${samples_${name}})
  set_tests_properties(Homework.JudgedSamples.${name} PROPERTIES LABELS "grading;nightly" FIXTURES_REQUIRED all_samples)
endforeach()
add_test(NAME Homework.JudgedSamplesOfTheDay
  COMMAND ${run} --by-day --worker $<TARGET_FILE:worker_samples> $<TARGET_FILE:homework_judge> ${samples_stage_3})
set_tests_properties(Homework.JudgedSamplesOfTheDay PROPERTIES LABELS "grading;slow")
