# The grader's judge and workers, tested.
# A worker for tests, of all samples.
add_executable(worker_samples $<TARGET_OBJECTS:samples> $<TARGET_OBJECTS:worker_main> $<TARGET_OBJECTS:wire>
  ${scene_objects} ${worker_objects})
target_link_libraries(worker_samples PRIVATE student_flags ch5_backend ch5_warnings -s)
set_target_properties(worker_samples PROPERTIES LINKER_LANGUAGE CXX RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

ch5_add_python_tests(Homework judge_and_worker_test.py LABELS grading)

add_library(wire_test OBJECT wire_test.cc)
target_link_libraries(wire_test PRIVATE ch5_backend ch5_test_settings GTest::gtest)
target_precompile_headers(wire_test REUSE_FROM ch5_test_pch)
add_executable(test_wire $<TARGET_OBJECTS:wire_test> $<TARGET_OBJECTS:wire>
  ${scene_objects} $<TARGET_OBJECTS:stage_tests_slips> $<FILTER:$<TARGET_OBJECTS:stage_tests_common>,EXCLUDE,/main[.]cc>)
target_link_libraries(test_wire PRIVATE ch5_backend ch5_test_settings GTest::gtest GTest::gtest_main)
set_target_properties(test_wire PROPERTIES LINKER_LANGUAGE CXX)
gtest_discover_tests(test_wire TEST_PREFIX Homework. DISCOVERY_MODE PRE_TEST PROPERTIES LABELS grading)

# Each sample that is wrong gets the same verdict of the judge as of a check; those that are right get theirs with any seed,
# far from a tolerance. By day one file of them, since Homework.Samples has judged all in a check's way.
foreach(name IN LISTS sample_names ITEMS blanks)
  add_test(NAME Homework.JudgedSamples.${name}
    COMMAND ${ch5_python_module} tests.homework.run_samples --own --seed 1 --seed 2 --seed 987654321987654321 --worker $<TARGET_FILE:worker_samples>
            $<TARGET_FILE:homework_judge> ${samples_${name}})
  set_tests_properties(Homework.JudgedSamples.${name} PROPERTIES LABELS "grading;nightly")
endforeach()
set_tests_properties(Homework.JudgedSamples.stage_3 PROPERTIES LABELS "grading;slow")
